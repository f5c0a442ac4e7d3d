# Tests that start programs: ours on bad input, on several ranks and on small files, and those of other people on our files.
# The table of bad inputs, each for a child process. Programs that do not load two hundred libraries start at once.
add_library(livermark_bad_inputs STATIC app/cli/bad_inputs/bad_command_lines.cpp app/cli/bad_inputs/bad_files.cpp
  app/cli/bad_inputs/bad_hdf5_files.cpp app/cli/bad_inputs/bad_inputs.cpp app/cli/bad_inputs/bad_load_cases.cpp)
target_link_libraries(livermark_bad_inputs PUBLIC livermark::core livermark::meshes livermark_result_samples
  PRIVATE livermark_hdf5 livermark_build_options)
target_link_options(livermark_bad_inputs PUBLIC -Wl,--as-needed)
target_compile_definitions(livermark_bad_inputs PUBLIC LIVERMARK_BINARY="$<TARGET_FILE:livermark>")
add_executable(bad_input_table app/cli/bad_inputs/write_table.cpp)
target_link_libraries(bad_input_table PRIVATE livermark_bad_inputs livermark_build_options)
add_executable(bad_input_tests app/cli/bad_inputs/bad_input_test.cpp)
target_link_libraries(bad_input_tests PRIVATE livermark_bad_inputs GTest::gtest_main livermark_build_options)
target_compile_definitions(bad_input_tests PRIVATE LIVERMARK_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
  LIVERMARK_SEGMENTATION=$<BOOL:${LIVERMARK_SEGMENTATION}>)
add_dependencies(bad_input_tests ${programs})
add_dependencies(bad_input_table ${programs})
gtest_discover_tests(bad_input_tests NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60 PROPERTIES LABELS full TIMEOUT 60)

# The distributed solver on one rank, then on two and four, which compare with what the one wrote.
if(LIVERMARK_WITH_MPI)
  add_executable(distributed_solver_check fem_reference/distributed_solver_check.cpp)
  target_link_libraries(distributed_solver_check PRIVATE livermark_fem_samples fmt::fmt
    livermark_build_options)
  set(one_rank_solutions ${CMAKE_CURRENT_BINARY_DIR}/one_rank_solutions.txt)
  foreach(num_ranks 1 2 4)
    set(name DistributedSolver.AgreesWithTheSerialOneOn${num_ranks}Ranks)
    add_test(NAME ${name} COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${num_ranks}
      $<TARGET_FILE:distributed_solver_check> ${one_rank_solutions})
    set_tests_properties(${name} PROPERTIES LABELS full TIMEOUT 300 ENVIRONMENT "${mpi_environment}"
      PROCESSORS ${num_ranks})
  endforeach()
  set_tests_properties(DistributedSolver.AgreesWithTheSerialOneOn1Ranks PROPERTIES FIXTURES_SETUP one_rank_solutions)
  foreach(num_ranks 2 4)
    set_tests_properties(DistributedSolver.AgreesWithTheSerialOneOn${num_ranks}Ranks PROPERTIES
      FIXTURES_REQUIRED one_rank_solutions)
  endforeach()
endif()

# What h5py and VTK, and so ParaView, see of a result file: one program writes it, Python looks at it.
foreach(candidate /usr/bin/python3 python3)
  execute_process(COMMAND ${candidate} -c "import h5py, jinja2, matplotlib; from vtkmodules.vtkIOHDF import vtkHDFReader"
    RESULT_VARIABLE missing OUTPUT_QUIET ERROR_QUIET)
  if(missing STREQUAL "0")
    set(vtk_python ${candidate})
    break()
  endif()
endforeach()
if(NOT vtk_python)
  message(FATAL_ERROR "no Python with VTK, h5py, Matplotlib and Jinja2 for tests of result files and reports; install python3-vtk9 "
    "python3-h5py python3-matplotlib python3-jinja2")
endif()
add_executable(write_sample_result results/write_sample_result.cpp)
target_link_libraries(write_sample_result PRIVATE livermark_result_samples livermark_build_options)
set(sample_result ${CMAKE_CURRENT_BINARY_DIR}/sample_result.h5)
set(sample_stability ${CMAKE_CURRENT_BINARY_DIR}/sample_stability.h5)
set(sample_cohort ${CMAKE_CURRENT_BINARY_DIR}/sample_cohort.h5)
set(sample_arena ${CMAKE_CURRENT_BINARY_DIR}/sample_arena.h5)
set(sample_calibration ${CMAKE_CURRENT_BINARY_DIR}/sample_calibration.h5)
set(sample_timings ${CMAKE_CURRENT_BINARY_DIR}/sample_timings.h5)
add_test(NAME ResultFile.IsWrittenForPython COMMAND write_sample_result ${CMAKE_CURRENT_BINARY_DIR})
add_test(NAME StudyFiles.AreWrittenForPython
  COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${PROJECT_SOURCE_DIR}/python ${vtk_python}
    ${CMAKE_CURRENT_SOURCE_DIR}/python/sample_sensitivity.py ${CMAKE_CURRENT_BINARY_DIR})
add_test(NAME ResultFile.OpensInVtk
  COMMAND ${vtk_python} ${CMAKE_CURRENT_SOURCE_DIR}/results/vtkhdf_reader_test.py ${sample_result}
    ${CMAKE_CURRENT_BINARY_DIR}/still_result.h5 ${CMAKE_CURRENT_BINARY_DIR}/path_result.h5)
add_test(NAME ResultFiles.AreWhatTheSchemaSays
  COMMAND ${vtk_python} ${CMAKE_CURRENT_SOURCE_DIR}/results/schema_test.py ${PROJECT_SOURCE_DIR}/results/schema.md
    ${CMAKE_CURRENT_BINARY_DIR})
# What a browser would read, without a browser.
add_test(NAME Report.IsWellFormedAndNeedsNothingElse
  COMMAND ${vtk_python} ${CMAKE_CURRENT_SOURCE_DIR}/app/cli/report_page_test.py $<TARGET_FILE:livermark> ${sample_result}
    ${CMAKE_CURRENT_BINARY_DIR}/still_result.h5 ${sample_stability} ${sample_timings}
    ${sample_calibration} ${sample_cohort} ${sample_arena})
add_test(NAME ResultFile.HasTheStructureOfTheExample
  COMMAND ${PROJECT_SOURCE_DIR}/scripts/example_h5dump ${CMAKE_CURRENT_BINARY_DIR}/small_result.h5
    --same-as ${PROJECT_SOURCE_DIR}/results/example_h5dump.txt)
set_tests_properties(ResultFile.IsWrittenForPython StudyFiles.AreWrittenForPython PROPERTIES LABELS full TIMEOUT 60 FIXTURES_SETUP sample_result)
set_tests_properties(StudyFiles.AreWrittenForPython PROPERTIES DEPENDS ResultFile.IsWrittenForPython)
set_tests_properties(ResultFile.OpensInVtk ResultFiles.AreWhatTheSchemaSays Report.IsWellFormedAndNeedsNothingElse
  ResultFile.HasTheStructureOfTheExample PROPERTIES LABELS full TIMEOUT 60 FIXTURES_REQUIRED sample_result)

# The examples, as their users start them.
add_executable(read_result ${PROJECT_SOURCE_DIR}/examples/read_result.cpp)
target_link_libraries(read_result PRIVATE livermark_hdf5 livermark_build_options)
add_test(NAME Examples.CppReadsAResultFile COMMAND read_result ${sample_result})
add_test(NAME Examples.PythonReadsAResultFile
  COMMAND ${vtk_python} ${PROJECT_SOURCE_DIR}/examples/read_result.py ${sample_result})
find_program(OCTAVE octave-cli)
if(OCTAVE)
  add_test(NAME Examples.OctaveReadsAResultFile
    COMMAND ${OCTAVE} --norc --path ${PROJECT_SOURCE_DIR}/examples --eval "read_result('${sample_result}')")
  set_tests_properties(Examples.OctaveReadsAResultFile PROPERTIES LABELS full TIMEOUT 60 FIXTURES_REQUIRED sample_result
    PASS_REGULAR_EXPRESSION "blown_up: diverged.*springs: at most 0.549 mm off the reference, at .200.0, 100.0, 100.0. mm")
else()
  message(STATUS "The example for MATLAB and Octave is not tested: no octave-cli (Debian package octave)")
endif()
set_tests_properties(Examples.CppReadsAResultFile PROPERTIES
  PASS_REGULAR_EXPRESSION "springs: [0-9.]+ mm at most, 4004 nodes")
set_tests_properties(Examples.PythonReadsAResultFile PROPERTIES
  PASS_REGULAR_EXPRESSION "blown_up: diverged.*springs: 20.00 % off fem_p2, at most [0-9.]+ mm")
set_tests_properties(Examples.CppReadsAResultFile Examples.PythonReadsAResultFile PROPERTIES LABELS full TIMEOUT 60 FIXTURES_REQUIRED sample_result)

# Engines as somebody else's programs: what docs/howto/judge_my_engine.md shows.
set(bullet_adapter "")
if(BULLET_FOUND)
  add_executable(bullet_adapter ${PROJECT_SOURCE_DIR}/examples/engines/bullet/bullet.cpp)
  target_compile_features(bullet_adapter PRIVATE cxx_std_20)
  target_include_directories(bullet_adapter PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(bullet_adapter PRIVATE livermark_hdf5 livermark_bullet livermark_build_options)
  # Whatever the tests are compiled with: it is an example of something fast.
  target_compile_options(bullet_adapter PRIVATE -O2)
  set(bullet_adapter $<TARGET_FILE:bullet_adapter>)
  add_test(NAME Examples.BulletMovesABody
    COMMAND ${vtk_python} ${CMAKE_CURRENT_SOURCE_DIR}/peer/bullet_example_test.py ${bullet_adapter} $<TARGET_FILE:livermark>
      ${CMAKE_CURRENT_BINARY_DIR}/peer_runs/bullet_example)
  set_tests_properties(Examples.BulletMovesABody PROPERTIES LABELS full TIMEOUT 300)
endif()
foreach(engine jolt mujoco bullet calculix livermark_springs)
  add_test(NAME Engines.${engine}
    COMMAND ${vtk_python} ${CMAKE_CURRENT_SOURCE_DIR}/peer/compare_engines_test.py ${engine} $<TARGET_FILE:livermark>
      "${bullet_adapter}" ${CMAKE_CURRENT_BINARY_DIR}/peer_runs/compare_engines)
  set_tests_properties(Engines.${engine} PROPERTIES LABELS full TIMEOUT 300 SKIP_RETURN_CODE 77
    ENVIRONMENT "PYTHONPATH=${PROJECT_BINARY_DIR}/python")
endforeach()
add_test(NAME Engines.FilesOfFebioAndSofaComeBack
  COMMAND ${vtk_python} ${CMAKE_CURRENT_SOURCE_DIR}/peer/engine_files_test.py $<TARGET_FILE:livermark>
    ${CMAKE_CURRENT_BINARY_DIR}/peer_runs/engine_files)
set_tests_properties(Engines.FilesOfFebioAndSofaComeBack PROPERTIES LABELS full TIMEOUT 300)

# Somebody else's program against the installed package; and against the source tree and Debian packages.
set(package_test ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR} -DSOURCE=${CMAKE_CURRENT_SOURCE_DIR}/package
  -DPYTHON=${LIVERMARK_PYTHON})
add_test(NAME Package.ServesAProgramOfSomebodyElse COMMAND ${package_test} -DWORK=${CMAKE_CURRENT_BINARY_DIR}/package_test
  -P ${CMAKE_CURRENT_SOURCE_DIR}/package/package_test.cmake)
set_tests_properties(Package.ServesAProgramOfSomebodyElse PROPERTIES LABELS full TIMEOUT 600)
add_test(NAME Package.ServesASourceTreeAndDebian COMMAND ${package_test} -DWHOLE=ON
  -DWORK=${CMAKE_CURRENT_BINARY_DIR}/whole_package_test -P ${CMAKE_CURRENT_SOURCE_DIR}/package/package_test.cmake)
set_tests_properties(Package.ServesASourceTreeAndDebian PROPERTIES LABELS nightly TIMEOUT 1200)

# Sweeps by Snakemake, here and on a Slurm that the test starts; skipped where scripts/install-cluster-tools was not called.
foreach(kind local slurm)
  add_test(NAME Sweep.${kind} COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/workflow/sweep_test.py ${kind}
    $<TARGET_FILE:livermark>)
  set_tests_properties(Sweep.${kind} PROPERTIES LABELS nightly TIMEOUT 900 SKIP_RETURN_CODE 77)
endforeach()
