#include "fuzz/scratch_file.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/generators/box_generator.hpp"
#include "support/input_error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    static const auto mesh =
        livermark::meshes::generate_box({0.1, 0.1, 0.1}, 0.064, livermark::meshes::BoxTopology::kuhn);
    try {
        livermark::load_cases::read_load_case(livermark::fuzz::as_file(data, size, ".toml"), mesh);
    } catch (const livermark::support::InputError &) { // what bad input has to come to
    }
    return 0;
}
