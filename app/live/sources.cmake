set(livermark_live_sources parameters.cpp contact.cpp find_cut.cpp scene_cuts.cpp
  messages.cpp needle.cpp scene.cpp springs.cpp)
