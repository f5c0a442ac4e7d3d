#include "fuzz/hdf5_checksums.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace livermark::fuzz {

namespace {

std::uint32_t word_at(std::string_view bytes, std::size_t place) {
    std::uint32_t word = 0;
    for (std::size_t b = 0; b < 4 && place + b < bytes.size(); ++b)
        word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[place + b])) << (8 * b);
    return word;
}

/// a, b, c of the source.
using State = std::array<std::uint32_t, 3>;

void mix(State &state) {
    auto &[a, b, c] = state;
    const auto step = [](std::uint32_t &x, std::uint32_t &y, std::uint32_t z, int bits) {
        x -= y;
        x ^= std::rotl(y, bits);
        y += z;
    };
    // The three take turns: x loses y and gets its bits, y gains what is left of the third.
    step(a, c, b, 4);
    step(b, a, c, 6);
    step(c, b, a, 8);
    step(a, c, b, 16);
    step(b, a, c, 19);
    step(c, b, a, 4);
}

std::uint32_t finished(State state) {
    auto &[a, b, c] = state;
    const auto step = [](std::uint32_t &x, std::uint32_t y, int bits) {
        x ^= y;
        x -= std::rotl(y, bits);
    };
    step(c, b, 14);
    step(a, c, 11);
    step(b, a, 25);
    step(c, b, 16);
    step(a, c, 4);
    step(b, a, 14);
    step(c, b, 24);
    return c;
}

/// Signatures of blocks with a checksum at their end (HDF5 File Format Specification 3.0). What begins with a
/// superblock is found as well.
constexpr std::array<std::string_view, 16> signatures{"\211HDF\r\n\032\n",
                                                      "OHDR",
                                                      "OCHK",
                                                      "FRHP",
                                                      "FHDB",
                                                      "FHIB",
                                                      "BTHD",
                                                      "BTIN",
                                                      "BTLF",
                                                      "EAHD",
                                                      "EAIB",
                                                      "EASB",
                                                      "EADB",
                                                      "FAHD",
                                                      "FADB",
                                                      "SMTB"};

} // namespace

std::uint32_t lookup3(std::string_view bytes, std::uint32_t initial) {
    const auto start = 0xdeadbeefU + static_cast<std::uint32_t>(bytes.size()) + initial;
    State state{start, start, start};
    while (bytes.size() > 12) {
        for (std::size_t w = 0; w < 3; ++w)
            state.at(w) += word_at(bytes, 4 * w);
        mix(state);
        bytes.remove_prefix(12);
    }
    if (bytes.empty())
        return state[2];
    for (std::size_t w = 0; w < 3; ++w)
        state.at(w) += word_at(bytes, 4 * w);
    return finished(state);
}

std::vector<ChecksummedBlock> checksummed_blocks(std::string_view file) {
    // Their lengths stand in many forms, and the right one is known by its checksum.
    constexpr std::size_t shortest = 8, longest = 8192;
    std::vector<ChecksummedBlock> blocks;
    for (const auto signature : signatures)
        for (auto begin = file.find(signature); begin != std::string_view::npos;
             begin = file.find(signature, begin + 1))
            for (std::size_t length = shortest; length < longest && begin + length + 4 <= file.size(); ++length)
                if (lookup3(file.substr(begin, length)) == word_at(file, begin + length)) {
                    blocks.push_back({begin, begin + length});
                    break;
                }
    std::ranges::sort(blocks, {}, &ChecksummedBlock::begin);
    return blocks;
}

void update_checksums(std::string &file, const std::vector<ChecksummedBlock> &blocks) {
    for (const auto &[begin, end] : blocks)
        if (end + 4 <= file.size()) {
            const auto sum = lookup3(std::string_view(file).substr(begin, end - begin));
            for (std::size_t b = 0; b < 4; ++b)
                file[end + b] = static_cast<char>(sum >> (8 * b) & 0xff);
        }
}

} // namespace livermark::fuzz
