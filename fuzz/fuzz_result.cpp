#include "core/input_error.hpp"
#include "fuzz/scratch_file.hpp"
#include "results/result_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    try {
        livermark::results::read_result(livermark::fuzz::as_file(data, size, ".h5"));
    } catch (const livermark::core::InputError &) { // what bad input has to come to
    }
    return 0;
}
