# Models against finite elements: the program runs first, and the tests look at its result files. The full tier has every model of a
# run on the beam and under three load cases of a liver; the nightly one has every model on every body and load case.
file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/validation/*_test.cpp)
livermark_test_executable(validation_tests full SOURCES ${sources} LINK livermark::studies livermark_result_samples livermark_hdf5)

# livermark_runs_folder(<tier> <folder>): where runs of a tier put their files. Those of earlier tests go first.
function(livermark_runs_folder tier folder)
  set(${tier}_runs ${CMAKE_CURRENT_BINARY_DIR}/${folder} PARENT_SCOPE)
  add_test(NAME Livermark.BeginsAnew.${tier} COMMAND ${CMAKE_COMMAND} -E rm -rf ${CMAKE_CURRENT_BINARY_DIR}/${folder})
  set_tests_properties(Livermark.BeginsAnew.${tier} PROPERTIES LABELS ${tier} FIXTURES_SETUP ${tier}_folder)
endfunction()

# livermark_run(<tier> <name> <argument>...): a run whose files tests of that tier look at.
function(livermark_run tier name)
  add_test(NAME Livermark.${name} COMMAND livermark run ${ARGN})
  set_tests_properties(Livermark.${name} PROPERTIES LABELS ${tier} TIMEOUT ${timeout_of_${tier}} FIXTURES_REQUIRED ${tier}_folder
    FIXTURES_SETUP ${tier}_runs)
endfunction()

# livermark_validation(<tier> <name> <filter> [<runs>])
function(livermark_validation tier name filter)
  add_test(NAME Validation.${name} COMMAND validation_tests --gtest_filter=${filter})
  set_tests_properties(Validation.${name} PROPERTIES LABELS ${tier} TIMEOUT ${timeout_of_${tier}})
  if(ARGN)
    set_tests_properties(Validation.${name} PROPERTIES FIXTURES_REQUIRED ${tier}_runs ENVIRONMENT "LIVERMARK_VALIDATION_RUNS=${ARGN}")
  endif()
endfunction()

livermark_runs_folder(full validation_runs)
livermark_run(full RunsModelsOn.beam --jobs 1 --static --body beam --output ${full_runs})
livermark_run(full RunsModelsOn.liver_tumours --jobs 1 --body liver_tumours --load-case palpation pneumoperitoneum traction
  --output ${full_runs})
livermark_run(full MovesSpringsOf.liver_healthy --body liver_healthy --load-case release --model fem_p1 fem_p2 lloyd patch_nodal_volume
  --output ${full_runs})
livermark_run(full RunsLargeDeformationsOf.liver_healthy --body liver_healthy
  --load-case large_traction ${CMAKE_CURRENT_SOURCE_DIR}/validation/flat_palpation.toml
    ${CMAKE_CURRENT_SOURCE_DIR}/validation/held_retraction.toml --reference-on-mesh --output ${full_runs}/large
  --model fem_p1 fem_p1_neo_hookean fem_p2_neo_hookean lloyd van_gelder patch_nodal_volume nodal_springs nodal_neo_hookean)
# Pressures that strain a nearly incompressible body by a ten-thousandth, where rounding hides that energy falls.
add_test(NAME Livermark.FindsRestUnderTheSmallestLoads COMMAND livermark run --jobs 1 --static --reference-on-mesh --poisson 0.49
  --body liver_healthy --load-case pneumoperitoneum --model edge_neo_hookean nodal_neo_hookean nodal_neo_hookean_f nodal_springs
  --output ${full_runs}/smallest)
set_tests_properties(Livermark.FindsRestUnderTheSmallestLoads PROPERTIES LABELS full TIMEOUT ${timeout_of_full}
  FIXTURES_REQUIRED full_folder)
livermark_validation(full ModelsAgainstFem Runs/ModelsAgainstFem.* ${full_runs})
livermark_validation(full LargeDeformations OnTheHealthyLiver/LargeDeformations.* ${full_runs}/large)
livermark_validation(full RelaxationOf.beam Bodies/Relaxation.*/beam)

if("nightly" IN_LIST LIVERMARK_TESTS)
  livermark_runs_folder(nightly nightly_runs)
  # Those that a run leaves out unless they are named have bands too.
  set(all_models edge_neo_hookean fem_p1 fem_p2 fem_p2p1 lloyd lloyd_edge lloyd_mean_edge lloyd_nodal_volume
    nodal_neo_hookean nodal_neo_hookean_f nodal_springs patch patch_nodal_volume uniform van_gelder van_gelder_nodal_volume
    van_gelder_tetrahedral_volume)
  file(GLOB bodies CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/meshes/*.toml)
  foreach(file IN LISTS bodies)
    cmake_path(GET file STEM body)
    livermark_run(nightly RunsEveryModelOn.${body} --jobs 1 --static --body ${body} --model ${all_models} --output ${nightly_runs})
    if(NOT body STREQUAL "beam")
      livermark_validation(nightly RelaxationOf.${body} Bodies/Relaxation.*/${body})
    endif()
  endforeach()
  livermark_run(nightly MovesSpringsOf.liver_tumours --body liver_tumours --load-case release --model fem_p1 fem_p2 lloyd
    --output ${nightly_runs})
  livermark_validation(nightly EveryModelAgainstFem Runs/ModelsAgainstFem.* ${nightly_runs})
  livermark_validation(nightly ReferenceError LoadCases/ReferenceError.*)
  livermark_validation(nightly LargeReferenceError LoadCases/LargeReferenceError.*)
  add_test(NAME StoredReferences.AreSolvedAgain COMMAND livermark reference --check --model fem_p2p1_neo_hookean fem_p2p1_refined)
  # Its exit status says whether runs on both livers bear the steps that are predicted.
  add_test(NAME Livermark.PredictsTheTimeStepThatRunsCanBear
    COMMAND livermark stability --output ${CMAKE_CURRENT_BINARY_DIR}/stability_runs)
  set_tests_properties(StoredReferences.AreSolvedAgain Livermark.PredictsTheTimeStepThatRunsCanBear PROPERTIES
    LABELS nightly TIMEOUT ${timeout_of_nightly})
endif()
