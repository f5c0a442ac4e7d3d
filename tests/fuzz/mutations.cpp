#include "tests/fuzz/mutations.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <fmt/format.h>
#include <iterator>
#include <limits>

#include "core/support/files.hpp"
#include "tests/fuzz/seed_files.hpp"

namespace livermark::fuzz {

namespace {

using support::RandomNumbers;

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
constexpr std::string_view signatures =
    "\211HDF\r\n\032\n|OHDR|OCHK|FRHP|FHDB|FHIB|BTHD|BTIN|BTLF|EAHD|EAIB|EASB|EADB|FAHD|FADB|SMTB";

/// Numbers that no program should have written, and some will have.
constexpr std::string_view absurd_numbers =
    "nan|-nan|inf|-inf|0|-0|-1|1e308|-1e308|1e400|1e-320|1e-4000|2147483647|2147483648|-2147483648|4294967295|"
    "4294967296|9223372036854775807|-9223372036854775808|18446744073709551615|99999999999999999999999999|0x10|1,5|+1|"
    "%s%n|";

/// Parts of a text between bars.
std::vector<std::string_view> parts_of(std::string_view text) {
    std::vector<std::string_view> parts;
    for (auto end = text.find('|'); end != std::string_view::npos; end = text.find('|')) {
        parts.push_back(text.substr(0, end));
        text.remove_prefix(end + 1);
    }
    parts.push_back(text);
    return parts;
}

/// 0, 1, and the ends of signed and unsigned integers of one byte to eight.
std::vector<std::uint64_t> absurd_integers() {
    std::vector<std::uint64_t> integers{0, 1};
    for (const int bits : {8, 16, 32, 64}) {
        const auto half = std::uint64_t{1} << (bits - 1);
        integers.insert(integers.end(), {half - 1, half, half - 1 + half});
    }
    return integers;
}

using Float = std::numeric_limits<float>;
const std::vector<float> absurd_floats{Float::quiet_NaN(),
                                       Float::infinity(),
                                       -Float::infinity(),
                                       Float::max(),
                                       Float::lowest(),
                                       Float::denorm_min(),
                                       0.0F,
                                       -1.0F,
                                       1e9F,
                                       1e-9F};

template <class Values> auto one_of(const Values &values, RandomNumbers &random) {
    return values.at(static_cast<std::size_t>(random.below(static_cast<int>(values.size()))));
}

/// 0 ... number - 1, 0 of none.
std::size_t some_of(std::size_t number, RandomNumbers &random) {
    return number == 0 ? 0 : static_cast<std::size_t>(random.below(static_cast<int>(number)));
}

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
    auto bytes = little_endian(one_of(absurd_integers(), random), 1 << random.below(4));
    if (random.below(3) == 0)
        std::ranges::reverse(bytes);
    return bytes;
}

/// A data element, also in sequences: where it, its length and its value are.
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

struct Word {
    std::size_t begin, length;
};

/// Words between whitespace and commas.
std::vector<Word> words_of(std::string_view text) {
    std::vector<Word> words;
    std::size_t begin = 0;
    for (std::size_t c = 0; c <= text.size(); ++c)
        if (c == text.size() || std::strchr(" \t\r\n,()=", text[c]) != nullptr) {
            if (c > begin)
                words.push_back({begin, c - begin});
            begin = c + 1;
        }
    return words;
}

bool is_number(std::string_view word) {
    return std::isdigit(static_cast<unsigned char>(word.back())) != 0 &&
           (std::isdigit(static_cast<unsigned char>(word.front())) != 0 || word.front() == '-' || word.front() == '.');
}

std::vector<std::string> lines_of(const std::string &text) {
    std::vector<std::string> lines;
    std::size_t begin = 0;
    while (begin < text.size()) {
        const auto end = std::min(text.find('\n', begin), text.size() - 1);
        lines.push_back(text.substr(begin, end + 1 - begin));
        begin = end + 1;
    }
    return lines;
}

std::string joined(const std::vector<std::string> &lines) {
    return fmt::format("{}", fmt::join(lines, ""));
}

std::string with_other_lines(const std::string &text, RandomNumbers &random) {
    auto lines = lines_of(text);
    if (lines.empty())
        return text;
    const auto first = some_of(lines.size(), random), second = some_of(lines.size(), random);
    switch (random.below(5)) {
    case 0:
        lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(first));
        break;
    case 1:
        std::swap(lines[first], lines[second]);
        break;
    case 2: {
        const std::size_t times = random.below(10) == 0 ? 5000 : 1;
        lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(first), times, std::string(lines[second]));
        break;
    }
    case 3:
        lines[first].resize(lines[first].size() - 1); // runs into the next one
        break;
    default:
        lines[first].insert(lines[first].size() - 1, random.below(2) == 0 ? "\r" : std::string(5000, 'x'));
    }
    return joined(lines);
}

std::string with_other_word(const std::string &text, RandomNumbers &random) {
    const auto words = words_of(text);
    if (words.empty())
        return text;
    std::vector<Word> numbers;
    std::ranges::copy_if(words, std::back_inserter(numbers),
                         [&](const Word &word) { return is_number(text.substr(word.begin, word.length)); });
    if (random.below(4) != 0 && !numbers.empty()) {
        const auto &[begin, length] = numbers[some_of(numbers.size(), random)];
        return text.substr(0, begin) + std::string(one_of(parts_of(absurd_numbers), random)) +
               text.substr(begin + length);
    }
    const auto &[begin, length] = words[some_of(words.size(), random)];
    const auto &other = words[some_of(words.size(), random)];
    return text.substr(0, begin) + text.substr(other.begin, other.length) + text.substr(begin + length);
}

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
    for (const auto signature : parts_of(signatures))
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
        return overwrite(bytes, place, little_endian(one_of(absurd_integers(), random), field.bytes));
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
                         little_endian(one_of(absurd_integers(), random), static_cast<int>(one.length_bytes)));
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
        if (const std::string text(one_of(parts_of(absurd_numbers), random)); random.below(2) == 0)
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

void damage_text(std::string &bytes, std::size_t length, RandomNumbers &random) {
    const auto text = bytes.substr(0, length);
    bytes.replace(0, length, random.below(3) == 0 ? with_other_lines(text, random) : with_other_word(text, random));
}

} // namespace livermark::fuzz
