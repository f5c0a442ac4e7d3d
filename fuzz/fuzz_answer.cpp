#include <cstddef>
#include <cstdint>
#include <string>

#include "core/input_error.hpp"
#include "exchange/answer.hpp"
#include "meshes/box_generator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    static const auto mesh =
        livermark::meshes::generate_box({0.1, 0.1, 0.1}, 0.13, livermark::meshes::BoxTopology::kuhn);
    try {
        const auto answer = livermark::exchange::parse_answer(std::string(data, data + size), "fuzz.csv");
        livermark::exchange::displacement_at_nodes(answer, mesh, "fuzz.csv");
    } catch (const livermark::core::InputError &) { // what bad input has to come to
    }
    return 0;
}
