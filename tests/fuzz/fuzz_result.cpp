#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>

#include "results/hdf5/result_file.hpp"
#include "tests/fuzz/fuzz_target.hpp"
#include "tests/fuzz/mutations.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t *data, std::size_t size, std::size_t max_size);

/// Makes the checksums of HDF5 right again, or nearly all damage would end there.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t *data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
    using namespace livermark;
    std::string bytes(data, data + size);
    const auto blocks = fuzz::checksummed_blocks(bytes);
    support::RandomNumbers random(seed);
    if (random.below(3) == 0) { // with what libFuzzer has learnt
        bytes.resize(max_size);
        bytes.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t *>(bytes.data()), size, max_size));
        fuzz::update_checksums(bytes, blocks);
    } else {
        fuzz::damage_hdf5(bytes, blocks, random);
    }
    bytes.resize(std::min(bytes.size(), max_size));
    std::ranges::copy(bytes, data);
    return bytes.size();
}

void livermark::fuzz::read(Input input) {
    try {
        results::read_result(as_file(input, ".h5"));
    } catch (const support::InputError &refusal) {
        // The file is read in a process of its own, where a sanitizer ends the process without a word. Signals are
        // HDF5's.
        if (std::string_view(refusal.what()).find("no reason given") != std::string_view::npos)
            std::abort();
    }
}
