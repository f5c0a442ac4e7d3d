#pragma once

#include <string>
#include <vector>

namespace livermark::studies {

/// Numbers that bodies of a cohort are drawn by, from a list of numbers and ranges such as "1-8,12".
/// @return ascending, at least one
/// @throws support::InputError for anything else, for a number that is there twice, and for more than a thousand
std::vector<int> body_numbers(const std::string &text);

} // namespace livermark::studies
