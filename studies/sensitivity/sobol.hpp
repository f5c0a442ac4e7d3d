#pragma once

#include <cstddef>
#include <vector>

namespace livermark::studies {

/// Sobol indices of one output; see results::OutputSensitivity.
struct SobolIndices {
    std::vector<double> first, first_lower, first_upper; ///< (P)
    std::vector<double> total, total_lower, total_upper; ///< (P)
    std::vector<double> group_total;                     ///< (G)
    double unexplained = 0.0;
};

/// The first points of Sobol's sequence in the unit cube, by OpenTURNS in a process of its own: more points begin with
/// the same ones.
/// @param dimension  P
/// @return (count, P)
/// @throws support::InputError that names the Debian package where OpenTURNS is missing
std::vector<std::vector<double>> sobol_points(std::size_t count, std::size_t dimension);

/// Estimates the indices of independent parameters that are uniform in the unit cube, by a sparse polynomial chaos
/// (OpenTURNS; python/livermark/studies/sobol.py says how).
/// @param points  (S, P) in the unit cube, S > P
/// @param values  (O, S) finite
/// @param groups  (G) numbers of parameters; at least one group
/// @return (O)
/// @throws support::InputError as sobol_points()
std::vector<SobolIndices> sobol_indices(const std::vector<std::vector<double>> &points,
                                        const std::vector<std::vector<double>> &values,
                                        const std::vector<std::vector<int>> &groups);

} // namespace livermark::studies
