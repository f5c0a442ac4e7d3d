#include "core/input_error.hpp"
#include "fuzz/scratch_file.hpp"
#include "load_cases/load_case_reader.hpp"
#include "tests/test_meshes.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    static const auto mesh = livermark::tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2});
    try {
        livermark::load_cases::read_load_case(livermark::fuzz::as_file(data, size, ".toml"), mesh);
    } catch (const livermark::core::InputError &) { // what bad input has to come to
    }
    return 0;
}
