#pragma once

#include <toml++/toml.h>

namespace livermark::load_cases {

/// Says at once what a load case lacks, where that is more than one thing: the conditions, a place or what happens
/// there in each of them, a condition that constrains, keys of the [release] and of the [tool]. One thing alone is
/// refused by who reads it.
/// @throws support::InputError
void refuse_missing_parts(const toml::table &load_case);

} // namespace livermark::load_cases
