#pragma once

#include <toml++/toml.h>

#include <Eigen/Core>

#include <array>
#include <filesystem>
#include <fmt/core.h>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/support/input_error.hpp"

namespace livermark::support {

/// Units of length that files and options may name, and the metres of each.
inline constexpr std::array<std::pair<std::string_view, double>, 3> length_units{
    {{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}}};

/// Metres per unit of length: one of length_units, or the metres themselves, such as "0.025".
/// @throws InputError for another word; place is named in it
double metres_per_unit(const std::string &unit, const std::string &place);

/// The 'unit' of a table, which is such a word or a number of metres; 1 where there is none.
/// @throws InputError with file, line and remedy
double metres_per_unit(const toml::table &table);

/// TOML from outside: every fault is an InputError that says file, line and remedy.

/// Stems of the .toml files of a folder, in alphabetical order.
/// @throws InputError if there is no such folder
std::vector<std::string> list_toml(const std::filesystem::path &folder);

/// Parses TOML text. The file name is only for messages.
/// @throws InputError if it is not TOML
toml::table parse_toml(const std::string &text, const std::filesystem::path &file);

/// A string as TOML has it, in quotes.
std::string quoted(const std::string &text);

/// Place of a node of a parsed table: "file:line".
std::string place_of(const toml::node &node);

/// Refuses what stands at a node: "file:line: fault".
/// @param fault  as for fmt::format(), with the remedy
/// @throws InputError
template <class... Values>
[[noreturn]] void refuse(const toml::node &node, fmt::format_string<Values...> fault, Values &&...values) {
    throw InputError("{}: {}", place_of(node), fmt::format(fault, std::forward<Values>(values)...));
}

/// Refuses keys that nobody would read, and names the nearest known one.
/// @throws InputError
void refuse_unknown_keys(const toml::table &table, std::span<const std::string_view> known);
void refuse_unknown_keys(const toml::table &table, std::initializer_list<std::string_view> known);

/// Values by key.
/// @throws InputError if the key is missing, or its value of another type or not finite
const toml::table &required_table(const toml::table &table, std::string_view key);
double required_number(const toml::table &table, std::string_view key);
std::string required_string(const toml::table &table, std::string_view key);
/// One string or more.
std::vector<std::string> required_strings(const toml::table &table, std::string_view key);
/// One finite number or more.
std::vector<double> required_numbers(const toml::table &table, std::string_view key);
/// True or false; false where the key is missing.
bool optional_flag(const toml::table &table, std::string_view key);
/// Three numbers. Where free_allowed, the word "free" stands for a component that is free and becomes NaN.
Eigen::Vector3d required_vector(const toml::table &table, std::string_view key, bool free_allowed = false);

} // namespace livermark::support
