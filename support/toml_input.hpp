#pragma once

#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include <toml++/toml.h>

#include <Eigen/Core>

/// TOML from outside: every fault is an InputError that says file, line and remedy.
namespace livermark::support {

/// Stems of the .toml files of a folder, in alphabetical order.
/// @throws InputError if there is no such folder
std::vector<std::string> list_toml(const std::filesystem::path &folder);

/// Parses TOML text. The file name is only for messages.
/// @throws InputError if it is not TOML
toml::table parse_toml(const std::string &text, const std::filesystem::path &file);

/// Where a node of a parsed table stands: "file:line".
std::string place_of(const toml::node &node);

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
