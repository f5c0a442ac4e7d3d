#include "core/support/toml_input.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <numeric>
#include <sstream>
#include <system_error>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

namespace livermark::support {

namespace {

/// From a nanometre to a kilometre: squares of lengths in it are numbers.
bool can_be_a_unit(double metres) {
    return metres >= 1e-9 && metres <= 1e3;
}

} // namespace

double metres_per_unit(const std::string &unit, const std::string &place) {
    const auto *known = std::ranges::find(length_units, unit, &std::pair<std::string_view, double>::first);
    if (known != length_units.end())
        return known->second;
    double metres = 0.0;
    const auto [end, error] = std::from_chars(unit.data(), unit.data() + unit.size(), metres);
    if (error != std::errc{} || end != unit.data() + unit.size() || !(metres > 0.0 && std::isfinite(metres)))
        throw InputError("{}: '{}' is not a unit of length; give m, cm or mm, or its length in metres, such as 0.025",
                         place, shown(unit));
    if (!can_be_a_unit(metres))
        throw InputError("{}: a unit of {} m is none of bodies; give m, cm or mm", place, metres);
    return metres;
}

double metres_per_unit(const toml::table &table) {
    const auto *unit = table.get("unit");
    if (!unit)
        return 1.0;
    if (!unit->is_number())
        return metres_per_unit(required_string(table, "unit"), place_of(*unit));
    const double metres = required_number(table, "unit");
    if (!(metres > 0.0))
        refuse(*unit, "the unit is {} m; it has to be positive", metres);
    if (!can_be_a_unit(metres))
        refuse(*unit, "a unit of {} m is none of bodies; give m, cm or mm", metres);
    return metres;
}

namespace {

const toml::node &required_node(const toml::table &table, std::string_view key) {
    const auto *node = table.get(key);
    if (!node)
        refuse(table, "'{}' is missing; add it", key);
    return *node;
}

/// Line of the first key that is dotted deeper than anybody writes, 0 if there is none. toml++ goes down each of them
/// by a call of a function, and the stack ends before the keys of a file that was made for that.
int line_of_deep_key(std::string_view text) {
    constexpr int deepest = 256;
    int line = 1, num_dots = 0;
    for (const char c : text) {
        const bool is_of_key = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == ' ' ||
                               c == '\t' || c == '"' || c == '\'';
        num_dots = c == '.' ? num_dots + 1 : is_of_key ? num_dots : 0;
        if (num_dots > deepest)
            return line;
        line += c == '\n' ? 1 : 0;
    }
    return 0;
}

} // namespace

std::vector<std::string> list_toml(const std::filesystem::path &folder) {
    if (std::error_code ignored; !std::filesystem::is_directory(folder, ignored))
        throw InputError("{}: there is no such folder; check the path", folder.string());
    std::vector<std::string> stems;
    for (const auto &file : std::filesystem::directory_iterator(folder))
        if (file.path().extension() == ".toml")
            stems.push_back(file.path().stem().string());
    std::ranges::sort(stems);
    return stems;
}

toml::table parse_toml(const std::string &text, const std::filesystem::path &file) {
    if (const int line = line_of_deep_key(text); line > 0)
        throw InputError("{}:{}: a key has hundreds of dots; correct the line", file.string(), line);
    try {
        return toml::parse(text, file.string());
    } catch (const toml::parse_error &error) {
        const auto words = error.description();
        const auto end = std::min(words.find(" (TOML_"), words.size()); // the name of a macro of the library
        throw InputError("{}:{}: this is not TOML: {}; correct the line", file.string(), error.source().begin.line,
                         words.substr(0, end));
    }
}

std::string quoted(const std::string &text) {
    std::ostringstream stream;
    stream << toml::value<std::string>(text);
    return stream.str();
}

std::string place_of(const toml::node &node) {
    const auto &source = node.source();
    return fmt::format("{}:{}", source.path ? *source.path : "TOML text", source.begin.line);
}

void refuse_unknown_keys(const toml::table &table, std::span<const std::string_view> known) {
    for (const auto &[key, value] : table) {
        if (std::ranges::find(known, key.str()) != known.end())
            continue;
        const std::vector<std::string> words(known.begin(), known.end());
        const auto nearest = nearest_word(key.str(), words);
        refuse(value, "unknown key '{}'; {}", key.str(),
               nearest.empty() ? fmt::format("known are: {}", fmt::join(words, ", "))
                               : fmt::format("did you mean '{}'?", nearest));
    }
}

void refuse_unknown_keys(const toml::table &table, std::initializer_list<std::string_view> known) {
    refuse_unknown_keys(table, std::span(known.begin(), known.size()));
}

const toml::table &required_table(const toml::table &table, std::string_view key) {
    const auto &node = required_node(table, key);
    if (const auto *found = node.as_table())
        return *found;
    refuse(node, "'{}' has to be a table", key);
}

double required_number(const toml::table &table, std::string_view key) {
    const auto &node = required_node(table, key);
    const auto number = node.is_number() ? node.value<double>() : std::nullopt;
    if (!number || !std::isfinite(*number))
        refuse(node, "'{}' has to be a finite number", key);
    return *number;
}

std::string required_string(const toml::table &table, std::string_view key) {
    const auto &node = required_node(table, key);
    if (const auto *text = node.as_string())
        return text->get();
    refuse(node, "'{}' has to be a string in quotes", key);
}

std::vector<std::string> required_strings(const toml::table &table, std::string_view key) {
    const auto &node = required_node(table, key);
    const auto *array = node.as_array();
    std::vector<std::string> strings;
    if (array)
        for (const auto &entry : *array)
            if (const auto *text = entry.as_string())
                strings.push_back(text->get());
    if (!array || strings.empty() || strings.size() != array->size())
        refuse(node, "'{}' has to be strings in brackets", key);
    return strings;
}

bool optional_flag(const toml::table &table, std::string_view key) {
    const auto *node = table.get(key);
    if (!node)
        return false;
    if (const auto *flag = node->as_boolean())
        return flag->get();
    refuse(*node, "'{}' has to be true or false", key);
}

std::vector<double> required_numbers(const toml::table &table, std::string_view key) {
    const auto &node = required_node(table, key);
    const auto fault = InputError("{}: '{}' has to be a list of finite numbers", place_of(node), key);
    const auto *array = node.as_array();
    if (!array || array->empty())
        throw fault;
    std::vector<double> numbers;
    for (const auto &entry : *array) {
        if (!entry.is_number() || !std::isfinite(*entry.value<double>()))
            throw fault;
        numbers.push_back(*entry.value<double>());
    }
    return numbers;
}

Eigen::Vector3d required_vector(const toml::table &table, std::string_view key, bool free_allowed) {
    const auto &node = required_node(table, key);
    const auto fault = InputError("{}: '{}' has to be three finite numbers{}", place_of(node), key,
                                  free_allowed ? ", or \"free\" for a component that is" : "");
    const auto *array = node.as_array();
    if (!array || array->size() != 3)
        throw fault;
    Eigen::Vector3d vector;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto &entry = *array->get(c);
        const auto component = static_cast<Eigen::Index>(c);
        if (free_allowed && entry.is_string() && entry.as_string()->get() == "free")
            vector[component] = std::numeric_limits<double>::quiet_NaN();
        else if (entry.is_number() && std::isfinite(*entry.value<double>()))
            vector[component] = *entry.value<double>();
        else
            throw fault;
    }
    return vector;
}

} // namespace livermark::support
