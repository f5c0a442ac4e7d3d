set(livermark_live_sources parameters.cpp find_cut.cpp scene_cuts.cpp
  messages.cpp scene.cpp held_tools.cpp jaws.cpp)
