set(livermark_live_sources body_checks.cpp contact.cpp cutting/find_cut.cpp cutting/fitted_rest.cpp cutting/remains.cpp
  cutting/scene_cuts.cpp material.cpp messages.cpp needle.cpp parameters.cpp scene.cpp springs.cpp
  surface.cpp virtual_coupling.cpp)
