#include "fuzz/mutations.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>

#include "fuzz/absurd_values.hpp"
#include "fuzz/dicom_elements.hpp"
#include "support/fnv_hash.hpp"

namespace livermark::fuzz {

namespace {

using support::RandomNumbers;

struct Range {
    std::size_t begin, length;
};

/// Mostly short.
Range some_range(std::size_t size, RandomNumbers &random) {
    const std::size_t begin = some_of(size, random);
    const std::size_t most = random.below(4) == 0 ? size - begin : std::min<std::size_t>(size - begin, 16);
    return {begin, most == 0 ? 0 : 1 + some_of(most, random)};
}

void overwrite(std::string &bytes, std::size_t place, std::string_view with) {
    for (std::size_t b = 0; b < with.size() && place + b < bytes.size(); ++b)
        bytes[place + b] = with[b];
}

/// An absurd integer of 1, 2, 4 or 8 bytes in either order, or a float.
std::string absurd_bytes(RandomNumbers &random) {
    if (random.below(4) == 0) {
        const float value = one_of(absurd_floats, random);
        std::string bytes(sizeof value, '\0');
        std::memcpy(bytes.data(), &value, sizeof value);
        return bytes;
    }
    auto bytes = little_endian(one_of(absurd_integers, random), 1 << random.below(4));
    if (random.below(3) == 0)
        std::ranges::reverse(bytes);
    return bytes;
}

/// Where each data element begins, also in sequences, and where its length and its value are.
struct Element {
    std::size_t begin, length_at, length_bytes, value, end;
};

std::size_t number_at(std::string_view bytes, std::size_t place, std::size_t count) {
    std::size_t value = 0;
    for (std::size_t b = 0; b < count && place + b < bytes.size(); ++b)
        value |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[place + b])) << (8 * b);
    return value;
}

std::vector<Element> elements_of(std::string_view bytes) {
    std::vector<Element> elements;
    std::size_t at = 132;
    while (at + 8 <= bytes.size()) {
        Element element{at, at + 6, 2, at + 8, 0};
        const auto vr = bytes.substr(at + 4, 2);
        const bool is_item = number_at(bytes, at, 2) == 0xfffe;
        const bool is_sequence = vr == "SQ";
        if (is_item)
            element = {at, at + 4, 4, at + 8, 0};
        else if (is_sequence || vr == "OB" || vr == "OW" || vr == "UN" || vr == "UT")
            element = {at, at + 8, 4, at + 12, 0};
        element.end = element.value + number_at(bytes, element.length_at, element.length_bytes);
        if (element.end > bytes.size())
            break;
        elements.push_back(element);
        at = is_item || is_sequence ? element.value : element.end; // what is in them comes next
    }
    return elements;
}

} // namespace

void damage_bytes(std::string &bytes, RandomNumbers &random) {
    if (bytes.empty())
        return;
    const auto [begin, length] = some_range(bytes.size(), random);
    const auto [other, other_length] = some_range(bytes.size(), random);
    switch (random.below(9)) {
    case 0:
        bytes[begin] = static_cast<char>(static_cast<unsigned char>(bytes[begin]) ^ (1U << random.below(8)));
        break;
    case 1:
        bytes[begin] = static_cast<char>(random.below(256));
        break;
    case 2:
        overwrite(bytes, begin, absurd_bytes(random));
        break;
    case 3:
        bytes.resize(begin);
        break;
    case 4:
        bytes.erase(begin, length);
        break;
    case 5:
        bytes.insert(begin, std::string(bytes, other, other_length));
        break;
    case 6:
        overwrite(bytes, begin, std::string(bytes, other, other_length));
        break;
    case 7:
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(begin), length, random.below(2) == 0 ? '\0' : '\xff');
        break;
    default:
        bytes.append(static_cast<std::size_t>(random.below(1000)), static_cast<char>(random.below(256)));
    }
}

void damage_nifti_header(std::string &bytes, RandomNumbers &random) {
    struct Field {
        int place, bytes, count;
        bool is_float;
    };
    static constexpr std::array<Field, 14> fields{{{0, 4, 1, false},
                                                   {40, 2, 8, false},
                                                   {68, 2, 1, false},
                                                   {70, 2, 1, false},
                                                   {72, 2, 1, false},
                                                   {76, 4, 8, true},
                                                   {108, 4, 1, true},
                                                   {112, 4, 2, true},
                                                   {123, 1, 1, false},
                                                   {252, 2, 2, false},
                                                   {256, 4, 3, true},
                                                   {268, 4, 3, true},
                                                   {280, 4, 12, true},
                                                   {344, 1, 4, false}}};
    const auto field = one_of(fields, random);
    const auto place = static_cast<std::size_t>(field.place + field.bytes * random.below(field.count));
    if (!field.is_float)
        return overwrite(bytes, place, little_endian(one_of(absurd_integers, random), field.bytes));
    const float value = one_of(absurd_floats, random);
    std::string four(sizeof value, '\0');
    std::memcpy(four.data(), &value, sizeof value);
    overwrite(bytes, place, four);
}

void damage_elements(std::string &bytes, RandomNumbers &random) {
    const auto elements = elements_of(bytes);
    if (elements.empty())
        return damage_bytes(bytes, random);
    const auto one = elements[some_of(elements.size(), random)], other = elements[some_of(elements.size(), random)];
    const auto whole = bytes.substr(one.begin, one.end - one.begin);
    switch (random.below(6)) {
    case 0:
        return overwrite(bytes, one.length_at,
                         little_endian(one_of(absurd_integers, random), static_cast<int>(one.length_bytes)));
    case 1: {
        const auto length = bytes.substr(one.length_at, std::min(one.length_bytes, other.length_bytes));
        overwrite(bytes, one.length_at, bytes.substr(other.length_at, length.size()));
        return overwrite(bytes, other.length_at, length);
    }
    case 2:
        bytes.erase(one.begin, whole.size());
        return;
    case 3:
        bytes.insert(other.begin, whole);
        return;
    case 4: // another value of the same length
        if (const std::string text(one_of(absurd_numbers, random)); random.below(2) == 0)
            return overwrite(bytes, one.value, text.substr(0, one.end - one.value));
        return overwrite(bytes, one.value, absurd_bytes(random).substr(0, one.end - one.value));
    default: // another kind
        return overwrite(bytes, one.begin + 4, bytes.substr(other.begin + 4, 2));
    }
}

void damage_hdf5(std::string &bytes, const std::vector<ChecksummedBlock> &blocks, RandomNumbers &random) {
    if (blocks.empty() || random.below(8) == 0)
        return damage_bytes(bytes, random);
    const auto place_in = [&](const ChecksummedBlock &block) {
        constexpr std::size_t signature = 4;
        return block.begin + signature + some_of(block.end - block.begin - signature, random);
    };
    const auto place = place_in(blocks[some_of(blocks.size(), random)]);
    if (place >= bytes.size())
        return;
    switch (random.below(4)) {
    case 0:
        bytes[place] = static_cast<char>(static_cast<unsigned char>(bytes[place]) ^ (1U << random.below(8)));
        break;
    case 1:
        bytes[place] = static_cast<char>(random.below(256));
        break;
    case 2:
        overwrite(bytes, place, absurd_bytes(random));
        break;
    default: { // an address, or something else, of another block
        const auto other = place_in(blocks[some_of(blocks.size(), random)]);
        overwrite(bytes, place, bytes.substr(std::min(other, bytes.size()), 8));
    }
    }
    update_checksums(bytes, blocks);
}

std::string damaged(std::string_view kind, std::string bytes, std::uint64_t number,
                    const std::vector<ChecksummedBlock> &blocks) {
    support::FnvHash hash;
    hash.add(kind);
    RandomNumbers random(hash.value() ^ number);
    const bool is_text = bytes.find('\0') == std::string::npos;
    // Headers of NRRD and PLY end in a line of their own; those of MetaImage in the name of the data.
    const auto end = [&](std::string_view mark) {
        const auto at = bytes.find(mark);
        return at == std::string::npos ? bytes.size() : at + mark.size();
    };
    for (int faults = 1 + random.below(3); faults > 0; --faults) {
        const bool is_by_structure = random.below(4) != 0;
        if (kind == "hdf5")
            damage_hdf5(bytes, blocks, random);
        else if (!is_by_structure)
            damage_bytes(bytes, random);
        else if (kind == "nifti")
            damage_nifti_header(bytes, random);
        else if (kind == "dicom")
            damage_elements(bytes, random);
        else if (kind == "nrrd")
            damage_text(bytes, random.below(4) == 0 && is_text ? bytes.size() : end("\n\n"), random);
        else if (kind == "metaimage")
            damage_text(bytes, end("ElementDataFile = LOCAL\n"), random);
        else if (kind == "ply")
            damage_text(bytes, is_text ? bytes.size() : end("end_header\n"), random);
        else if (is_text)
            damage_text(bytes, bytes.size(), random);
        else
            damage_bytes(bytes, random);
    }
    return bytes;
}

} // namespace livermark::fuzz
