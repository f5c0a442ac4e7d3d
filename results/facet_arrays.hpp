#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"

namespace livermark::results {

/// What holds on a facet, as result files number it.
enum class FacetCode : std::uint8_t { free = 0, prescribed_displacement = 1, traction = 2 };

/// The conditions of a load case as one row for each facet: what result files hold, and keys of problems are made of.
struct FacetArrays {
    std::vector<FacetCode> condition; ///< (T)
    std::vector<int> constraint;      ///< (T) index into constraint_names, -1 where the force is known
    std::vector<std::string> constraint_names;
    std::vector<int> load; ///< (T) index into load_names, -1 where no traction is given; empty where none has a name
    std::vector<std::string> load_names;
    std::vector<std::uint8_t> follows; ///< (T) 1 where a pressure follows the surface; empty where none does
    std::vector<int> round_load; ///< (T) index into round_loads, -1 where the traction is even; empty where all are
    std::vector<core::RoundLoad> round_loads;
};

FacetArrays facet_arrays(const core::LoadCase &load_case);

/// Gives a load case the conditions that the rows came from.
/// @param load_case  with its events
/// @return what contradicts itself, in words; nothing if all is well
std::optional<std::string> set_conditions(const FacetArrays &facets, core::LoadCase &load_case);

} // namespace livermark::results
