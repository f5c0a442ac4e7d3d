// write_sample_result <folder>: the files that schema_test.py and vtkhdf_reader_test.py look at, and a result small
// enough to be printed and fuzzed.
#include <filesystem>
#include <memory>
#include <utility>

#include "results/hdf5/references.hpp"
#include "results/hdf5/result_file.hpp"
#include "studies/run/run.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/records/sample_records.hpp"
#include "tests/samples/records/sample_result.hpp"
#include "tests/samples/tool_block.hpp"

namespace results = livermark::results;
namespace tests = livermark::tests;

int main(int argc, char **argv) {
    if (argc != 2)
        return 2;
    const std::filesystem::path folder = argv[1];
    // Enough bricks that the larger datasets are chunked and compressed, as those of a liver are.
    const auto result = tests::sample_result(1000);
    auto part_of_load = result; // as where the reference ends before its load, below a plate
    auto &touching = part_of_load.problem.load_case.touching.value();
    touching.shape = {livermark::core::ToolFace::round, 0.3, 0.03, touching.press};
    for (auto &model : part_of_load.models)
        if (model.comparison)
            model.comparison->load_fraction = 0.75;
    results::write_result(folder / "sample_result.h5", part_of_load);
    auto jaws = tests::with_jaws(result);
    auto body = *tests::covered::with_capsule(jaws.problem.body);
    body.vessels = tests::vessels::chain(16);
    body.modulus_factor.assign(body.mesh.tetrahedra.size(), 1.0);
    jaws.problem.body = std::make_shared<const livermark::core::Body>(std::move(body));
    results::write_result(folder / "with_jaws_result.h5", jaws);
    results::write_result(folder / "still_result.h5", tests::without_motion(result));
    results::write_result(folder / "path_result.h5", tests::along_a_path(result));
    results::write_result(folder / "small_result.h5", tests::sample_result());

    results::write_stability(folder / "sample_stability.h5", tests::sample_stability());
    results::write_calibration(folder / "sample_calibration.h5", tests::sample_calibration(*result.problem.body));
    results::write_cohort(folder / "sample_cohort.h5", tests::sample_cohort());
    auto below_a_plate = tests::sample_arena();
    below_a_plate.tool = livermark::results::touching_tool;
    below_a_plate.face = livermark::core::ToolFace::square;
    below_a_plate.plate_size = 0.02;
    results::write_arena(folder / "sample_arena.h5", below_a_plate);
    results::write_cut(folder / "sample_cut.h5", tests::sample_cut());
    results::write_needles(folder / "sample_needles.h5", tests::sample_needles());
    results::write_experiment(folder / "sample_experiment.h5", tests::sample_experiment());
    const auto moved = tests::tool_block();
    results::write_tool_scene(
        folder / "sample_scene.h5", moved,
        {.held = {0, 1},
         .nodes = {2, 3, 4},
         .displacement = std::vector<livermark::core::Vector3>(3 * 16, livermark::core::Vector3::Zero())},
        {});
    results::write_timings(folder / "sample_timings.h5", tests::sample_timings());
}
