#include "meshes/generators/box_generator.hpp"
#include "studies/exchange/formats/export_format.hpp"
#include "tests/fuzz/fuzz_target.hpp"

void livermark::fuzz::read(Input input) {
    static const auto mesh = meshes::generate_box({0.1, 0.1, 0.1}, 0.13, meshes::BoxTopology::kuhn);
    const auto solution = studies::parse_outside_solution(as_text(input), "fuzz.csv");
    studies::displacement_at_nodes(solution, mesh, "fuzz.csv");
}
