#include <cstddef>
#include <cstdint>
#include <string>

#include "core/input_error.hpp"
#include "meshes/msh_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    try {
        livermark::meshes::parse_msh(std::string(data, data + size), "fuzz.msh");
    } catch (const livermark::core::InputError &) { // what bad input has to come to
    }
    return 0;
}
