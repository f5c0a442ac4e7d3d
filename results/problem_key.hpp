#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"

namespace livermark::results {

/// Kinds of conditions on a facet, as result files number them.
enum FacetCode : std::uint8_t { free_facet, prescribed_facet, traction_facet };

/// The conditions of a load case as one row for each facet: what result files hold, and keys of problems are made of.
struct FacetArrays {
    std::vector<std::uint8_t> condition; ///< (T) FacetCode
    std::vector<int> constraint;         ///< (T) index into constraint_names, -1 where the force is known
    std::vector<std::string> constraint_names;
    std::vector<int> load; ///< (T) index into load_names, -1 where no traction is given; empty where none has a name
    std::vector<std::string> load_names;
    std::vector<std::uint8_t> follows; ///< (T) 1 where a pressure follows the surface; empty where none does
    std::vector<int> round_load; ///< (T) index into round_loads, -1 where the traction is even; empty where all are
    std::vector<core::RoundLoad> round_loads;
};

FacetArrays facet_arrays(const core::LoadCase &load_case);

/// Sixteen digits that stand for all that a solution depends on beside the model: mesh, materials, conditions, loads,
/// path, release, and the names and the definition that it is kept with. Every bit counts. It is the same after a
/// result file was written and read.
std::string problem_key(const core::Problem &problem);

/// Sixteen digits that stand for all that a solution depends on: model, mesh, materials, conditions, path, release.
/// Numbers count with nine digits, so that machines that round differently agree.
std::string fingerprint(const core::Problem &problem, const std::string &model);

} // namespace livermark::results
