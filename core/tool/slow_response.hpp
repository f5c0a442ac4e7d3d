#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/solution.hpp"

namespace livermark::core {

/// Response that a tool meets at each time of a slow history.
struct SlowResponse {
    std::string place; ///< its name; empty where the load case gives none
    /// Whether the tool is moved, and the values are its force along its motion [N]; otherwise its traction is given,
    /// and they are the displacement along that, in the mean weighted with it [m].
    bool is_force = false;
    std::vector<double> values; ///< (K) as far as the solution came
};

/// Responses of each tool, as in tool_places().
/// @param load_case  with a slow history
std::vector<SlowResponse> slow_responses(const TetraMesh &mesh, const LoadCase &load_case, const Solution &solution);

/// The energy that the body turns into heat in the last cycle [J]: what its branches dissipate, or where the model does
/// not sum that, the work of all that drives it less what it stores more at the end; NaN without cycles, and where the
/// model says neither.
double lost_energy(const SlowHistory &history, const Solution &solution);

/// Distance of a slow history from that of the reference.
struct SlowComparison {
    /// Median and largest of |f_k - r_k| over the records, over the largest |r_k|; of the place where the largest is
    /// largest. NaN where the way ended early.
    double median_error = 0.0, worst_error = 0.0;
    std::string place; ///< that place
    /// lost_energy() over that of the reference, by the same rule, minus one; NaN without cycles or heat
    double lost_energy = 0.0;

    bool operator==(const SlowComparison &) const = default;
};

/// @return nothing where the load case has no slow history or no tool, or the reference no point for each time
std::optional<SlowComparison> compare_slow_histories(const TetraMesh &mesh, const LoadCase &load_case,
                                                     const Solution &solution, const Solution &reference);

} // namespace livermark::core
