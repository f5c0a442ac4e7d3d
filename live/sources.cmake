set(livermark_live_sources body_checks.cpp contact.cpp material.cpp messages.cpp needle.cpp parameters.cpp scene.cpp springs.cpp
  surface.cpp virtual_coupling.cpp)
