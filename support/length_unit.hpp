#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "support/toml_input.hpp"

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

} // namespace livermark::support
