# Tests of the Python package, against what `livermark` itself writes. Without pybind11 there is no package, and without
# pytest no test of it.
if(NOT TARGET _livermark)
  message(STATUS "The Python package is not tested: it is not built")
  return()
endif()
# As somebody installs it who has no build folder: into a folder of its own, from which a short program runs.
add_test(NAME Package.IsMadeByPip COMMAND ${LIVERMARK_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/package/pip_test.py
  ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_BINARY_DIR}/pip_test)
set_tests_properties(Package.IsMadeByPip PROPERTIES LABELS full TIMEOUT 1500 SKIP_RETURN_CODE 77)

execute_process(COMMAND ${LIVERMARK_PYTHON} -c "import pytest, pandas, h5py, matplotlib, jinja2" RESULT_VARIABLE missing OUTPUT_QUIET ERROR_QUIET)
if(NOT missing STREQUAL "0")
  message(STATUS "The Python package is not tested: see python3-pytest, python3-pandas, python3-h5py,
    python3-matplotlib, python3-jinja2")
  return()
endif()

set(python_runs ${CMAKE_CURRENT_BINARY_DIR}/python_runs)
add_test(NAME Python.ProgramRuns COMMAND livermark run --jobs 1 --reference-on-mesh --body beam
  --load-case beam_bend ${CMAKE_CURRENT_SOURCE_DIR}/python/beam_release.toml
  --model fem_p1 fem_p2 lloyd van_gelder patch uniform van_gelder_nodal_volume van_gelder_tetrahedral_volume nodal_springs nodal_neo_hookean
  --kernel simd_double --integrator velocity_verlet --output ${python_runs})
add_test(NAME Python.ProgramRunsOneLoadCase COMMAND livermark run --jobs 1 --reference-on-mesh --body beam --load-case beam_bend
  --model fem_p1 fem_p2 lloyd van_gelder van_gelder_nodal_volume nodal_springs --output ${python_runs}/alone)
set_tests_properties(Python.ProgramRuns Python.ProgramRunsOneLoadCase PROPERTIES LABELS full TIMEOUT 600 FIXTURES_SETUP python_runs)

if(TARGET try_readers)
  set(damaged_files ";LIVERMARK_TRY_READERS=$<TARGET_FILE:try_readers>")
endif()
file(GLOB parts CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}/python ${CMAKE_CURRENT_SOURCE_DIR}/python/*_test.py)
foreach(part IN LISTS parts)
  string(REPLACE "_test.py" "" name ${part})
  add_test(NAME Python.${name}
    COMMAND ${LIVERMARK_PYTHON} -m pytest -q -p no:cacheprovider ${CMAKE_CURRENT_SOURCE_DIR}/python/${part})
  set_tests_properties(Python.${name} PROPERTIES LABELS full TIMEOUT 600 FIXTURES_REQUIRED "python_runs;sample_result"
    ENVIRONMENT "PYTHONPATH=${PROJECT_BINARY_DIR}/python;PYTHONDONTWRITEBYTECODE=1;LIVERMARK_BINARY=$<TARGET_FILE:livermark>;LIVERMARK_SOURCE_DIR=${PROJECT_SOURCE_DIR};LIVERMARK_PYTHON_RUNS=${python_runs};LIVERMARK_SAMPLES=${CMAKE_CURRENT_BINARY_DIR}${damaged_files}")
endforeach()
