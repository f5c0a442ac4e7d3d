#include "fuzz/scratch_file.hpp"
#include "results/hdf5/result_file.hpp"
#include "support/input_error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    try {
        livermark::results::read_result(livermark::fuzz::as_file(data, size, ".h5"));
    } catch (const livermark::support::InputError &) { // what bad input has to come to
    }
    return 0;
}
