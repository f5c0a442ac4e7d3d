set(livermark_live_sources parameters.cpp find_cut.cpp part_body.cpp way_out.cpp scene_cuts.cpp
  messages.cpp scene.cpp held_tools.cpp jaws.cpp)
