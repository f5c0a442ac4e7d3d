#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/generators/box_generator.hpp"
#include "tests/fuzz/fuzz_target.hpp"

void livermark::fuzz::read(Input input) {
    static const auto mesh = meshes::generate_box({0.1, 0.1, 0.1}, 0.064, meshes::BoxTopology::kuhn);
    load_cases::read_load_case(as_file(input, ".toml"), mesh);
}
