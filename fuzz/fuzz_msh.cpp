#include <cstddef>
#include <cstdint>
#include <string>

#include "meshes/io/msh_reader.hpp"
#include "support/input_error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    try {
        livermark::meshes::parse_msh(std::string(data, data + size), "fuzz.msh");
    } catch (const livermark::support::InputError &) { // what bad input has to come to
    }
    return 0;
}
