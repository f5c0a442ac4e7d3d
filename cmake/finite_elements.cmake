# What finite elements and sparse factors are made with. A package of Livermark includes this file as well.
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
add_library(livermark_cholmod INTERFACE)
target_include_directories(livermark_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})
# CHOLMOD runs on GCC's OpenMP; core/support/processes/own_process.hpp keeps it in one thread.
target_link_libraries(livermark_cholmod INTERFACE ${CHOLMOD_LIBRARY} gomp)

find_library(BLAS_LIBRARY blas REQUIRED) # the one that CHOLMOD runs on
add_library(livermark_blas INTERFACE)
target_link_libraries(livermark_blas INTERFACE ${BLAS_LIBRARY})

# deal.II's own target set-up would put its flags behind ours and make its warnings public, so only its include
# directories, definitions and library are taken.
find_package(deal.II 9.4 REQUIRED HINTS /usr/share/cmake/deal.II)
include(${DEAL_II_TARGET_CONFIG})
add_library(livermark_dealii INTERFACE)
target_include_directories(livermark_dealii SYSTEM INTERFACE ${DEAL_II_INCLUDE_DIRS})
if(NOT DEAL_II_WITH_MPI)
  set(LIVERMARK_WITH_MPI OFF)
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Debug")
  target_compile_definitions(livermark_dealii INTERFACE ${DEAL_II_USER_DEFINITIONS} ${DEAL_II_USER_DEFINITIONS_DEBUG})
  target_link_libraries(livermark_dealii INTERFACE ${DEAL_II_TARGET_DEBUG})
else()
  target_compile_definitions(livermark_dealii INTERFACE ${DEAL_II_USER_DEFINITIONS} ${DEAL_II_USER_DEFINITIONS_RELEASE})
  target_link_libraries(livermark_dealii INTERFACE ${DEAL_II_TARGET_RELEASE})
endif()
