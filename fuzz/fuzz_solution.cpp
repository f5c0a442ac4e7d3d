#include <cstddef>
#include <cstdint>
#include <string>

#include "meshes/generators/box_generator.hpp"
#include "studies/exchange/formats/outside_solution.hpp"
#include "support/input_error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    static const auto mesh =
        livermark::meshes::generate_box({0.1, 0.1, 0.1}, 0.13, livermark::meshes::BoxTopology::kuhn);
    try {
        const auto solution = livermark::studies::parse_outside_solution(std::string(data, data + size), "fuzz.csv");
        livermark::studies::displacement_at_nodes(solution, mesh, "fuzz.csv");
    } catch (const livermark::support::InputError &) { // what bad input has to come to
    }
    return 0;
}
