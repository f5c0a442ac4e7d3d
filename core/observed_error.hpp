#pragma once

#include <cstddef>
#include <span>

#include "core/load_case.hpp"
#include "core/solution.hpp"

namespace livermark::core {

/// The discretisation error of the finest of some solutions, observed and not assumed: of errors that shrink by a
/// factor r from mesh to mesh the differences of neighbours do so too, and what is left after the last difference d is
/// d r / (1 - r). Strain energy, reactions and stiffness at the tool have factors of their own, and none below 1/2,
/// which is the first order, is believed of them: at rims there is none better, and what local refinement leaves as it
/// is does not shrink.
/// @param mesh       whose nodes all solutions are given at
/// @param load_case  on that mesh
/// @param levels  at least three, each on a finer mesh than the one before, status ok; r is from the last three
/// @throws std::invalid_argument if there are fewer
ObservedError observed_error(const TetraMesh &mesh, const LoadCase &load_case, std::span<const Solution> levels);

/// The same of one number that rims determine, such as a displacement there, with the factor of a force.
/// @param levels  as above
double observed_error(std::span<const double> levels);

/// The same part of the way to the whole load, where finer meshes come no further: at the last point of
/// LoadCase::path that all levels have. What is left after level c is the sum of the differences from there on, and of
/// what is left after the last of them.
/// @param levels  the last three count; all have a point of the path
/// @param chosen  c, one of the last three
/// @throws std::invalid_argument if there are fewer than three, or one has no point
ObservedError observed_error_on_path(const TetraMesh &mesh, const LoadCase &load_case, std::span<const Solution> levels,
                                     std::size_t chosen);

/// The same of the motion of probes. No order better than the first is believed: at rims there is none, and refinement
/// there leaves the rest of the mesh as it is.
/// @param levels  at least three, recorded at the same times and probes
/// @throws std::invalid_argument if there are fewer, or if they do not fit together
ObservedMotionError observed_motion_error(std::span<const History> levels);

/// A factor beyond these is not believed: differences that hardly shrink say little, and one that shrinks faster than
/// elements of second degree let expect is luck.
inline constexpr double largest_believed_factor = 0.8, smallest_believed_factor = 0.25;

/// Part of what extrapolation adds that may be wrong. On both livers it was a quarter to seven tenths of a half.
inline constexpr double doubt = 0.5;

/// Limit of the solutions on ever finer meshes: u_3 + (u_3 - u_2) r / (1 - r), where the order is clean, that is
/// where r is believed; otherwise the finest. Reactions and energy have factors of their own. What is added is counted
/// as error by the share doubt, see Solution::observed_error.
/// (L. F. Richardson 1911, Phil. Trans. R. Soc. A 210)
/// @param mesh, load_case, levels  as above; their paths have the same points
/// @return the finest but for displacement, reaction, energy, path, and with observed_error
Solution extrapolated(const TetraMesh &mesh, const LoadCase &load_case, std::span<const Solution> levels);

} // namespace livermark::core
