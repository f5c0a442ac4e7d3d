# Everything comes from Debian packages; scripts/bootstrap installs them and names them.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(Spectra 1.0 REQUIRED)
find_package(Threads REQUIRED)
find_package(hwy 1.0 REQUIRED)
# What has no AVX2 has SSE4 since 2008: kernels compile in four fifths of the time without the one between.
target_compile_definitions(hwy::hwy INTERFACE HWY_DISABLED_TARGETS=HWY_SSSE3)
find_package(Boost REQUIRED)
if(NOT LIVERMARK_WITH_FEM_REFERENCE)
  return()
endif()

find_package(CLI11 REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(nlohmann_json REQUIRED)

include(finite_elements)

# A deal.II with MPI, such as Debian's, links the openmpi flavour of HDF5; the serial one beside it breaks both.
set(HDF5_PREFER_PARALLEL ${DEAL_II_WITH_MPI})
find_package(HDF5 REQUIRED COMPONENTS C HL)
if(DEAL_II_WITH_MPI AND NOT HDF5_IS_PARALLEL)
  message(FATAL_ERROR "found serial HDF5, which clashes with the one deal.II links; install libhdf5-openmpi-dev")
endif()
if(HDF5_IS_PARALLEL OR LIVERMARK_WITH_MPI)
  find_package(MPI REQUIRED COMPONENTS C) # headers of this HDF5 include mpi.h
endif()
add_library(livermark_hdf5 INTERFACE)
target_include_directories(livermark_hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIRS} ${MPI_C_INCLUDE_DIRS})
target_link_libraries(livermark_hdf5 INTERFACE ${HDF5_LIBRARIES} ${HDF5_HL_LIBRARIES})

find_library(GMSH_LIBRARY gmsh REQUIRED)
find_path(GMSH_INCLUDE_DIR gmsh.h REQUIRED)
add_library(livermark_gmsh INTERFACE)
target_include_directories(livermark_gmsh SYSTEM INTERFACE ${GMSH_INCLUDE_DIR})
target_link_libraries(livermark_gmsh INTERFACE ${GMSH_LIBRARY})

if(BUILD_TESTING)
  find_package(GTest REQUIRED)
  # The eigensolver that the tests compare Spectra with.
  find_library(ARPACK_LIBRARY arpack REQUIRED)
  find_path(ARPACK_INCLUDE_DIR arpack/arpack.hpp REQUIRED)
  add_library(livermark_arpack INTERFACE)
  target_include_directories(livermark_arpack SYSTEM INTERFACE ${ARPACK_INCLUDE_DIR})
  target_link_libraries(livermark_arpack INTERFACE ${ARPACK_LIBRARY})
endif()
if(LIVERMARK_WITH_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
# A physics engine whose soft bodies tests and benchmarks compare with.
if(BUILD_TESTING)
  find_package(Bullet CONFIG QUIET HINTS /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/bullet)
  if(BULLET_FOUND)
    add_library(livermark_bullet INTERFACE)
    target_include_directories(livermark_bullet SYSTEM INTERFACE ${BULLET_ROOT_DIR}/${BULLET_INCLUDE_DIR})
    target_compile_definitions(livermark_bullet INTERFACE ${BULLET_DEFINITIONS})
    target_link_libraries(livermark_bullet INTERFACE BulletSoftBody BulletDynamics BulletCollision LinearMath)
  else()
    message(STATUS "Bullet is not there: nothing is compared with its soft bodies (package libbullet-dev)")
  endif()
endif()

# From images to bodies, in a program of its own. Only these parts of ITK, because its
# HDF5 is the serial one.
if(LIVERMARK_WITH_SEGMENTATION)
  set(CMAKE_MESSAGE_LOG_LEVEL ERROR) # it warns of that HDF5 on its way
  find_package(ITK 5.2 QUIET COMPONENTS ITKIOGDCM ITKIOMeta ITKIONIFTI ITKIONRRD ITKConnectedComponents
    ITKBinaryMathematicalMorphology ITKImageGrid ITKSmoothing)
  unset(CMAKE_MESSAGE_LOG_LEVEL)
  find_package(CGAL 5.5 QUIET)
endif()
if(ITK_FOUND AND CGAL_FOUND)
  set(LIVERMARK_SEGMENTATION ON)
  add_library(livermark_itk INTERFACE)
  # GDCM reads DICOM for ITK, segmentation objects for us, and warns on standard error unless it is told not to.
  find_path(GDCM_INCLUDE_DIR gdcmTrace.h PATH_SUFFIXES gdcm-3.0 REQUIRED)
  find_library(GDCM_LIBRARY gdcmCommon REQUIRED)
  find_library(GDCM_DATA_LIBRARY gdcmDSED REQUIRED)
  find_library(GDCM_FILE_LIBRARY gdcmMSFF REQUIRED)
  target_include_directories(livermark_itk SYSTEM INTERFACE ${ITK_INCLUDE_DIRS} ${GDCM_INCLUDE_DIR})
  # ITK's headers bring an older Eigen, which does not go with ours.
  target_compile_definitions(livermark_itk INTERFACE ITK_USE_SYSTEM_EIGEN)
  target_link_libraries(livermark_itk INTERFACE ${ITK_LIBRARIES} ${GDCM_FILE_LIBRARY} ${GDCM_DATA_LIBRARY}
    ${GDCM_LIBRARY})
else()
  set(LIVERMARK_SEGMENTATION OFF)
  message(STATUS "Without ITK and CGAL bodies cannot be made of segmentations; see libinsighttoolkit5-dev, libcgal-dev")
endif()
