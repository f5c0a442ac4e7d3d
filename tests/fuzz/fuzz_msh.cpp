#include "meshes/io/mesh_files.hpp"
#include "tests/fuzz/fuzz_target.hpp"

void livermark::fuzz::read(Input input) {
    meshes::parse_msh(as_text(input), "fuzz.msh");
}
