#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "core/tool/tool_stiffness.hpp"

namespace livermark::core {

/// Distance of one motion from another.
struct HistoryComparison {
    std::string reference;        ///< name of the model that it was compared with
    double relative_l2 = 0.0;     ///< sqrt(sum |u_kq - r_kq|^2 / sum |r_kq|^2) over all records k and probes q
    double amplitude_error = 0.0; ///< a - 1, with a the ratio of the root mean squares of u and r
    /// Delay of the motion [s]: the shift of its records in time, the nearest to none, at which sum u_kq .
    /// r_kq over the norms of both, of those that still meet, is greatest; between records by a parabola, and not
    /// beyond a quarter of the time.
    double lag = 0.0;
    /// (F, N) u - r of the frames [m]; empty where one of them has none
    std::vector<Eigen::Vector3f> error{};
    std::string frames_reference{}; ///< whose frames r of the error is; empty if there is none

    bool operator==(const HistoryComparison &) const = default;
};

/// Distance of one solution of a load case of surgical size from another, in what a surgeon sees and feels.
struct PathComparison {
    /// sum_p R_p . R_rp / sum_p |R_rp|^2 - 1 over the constraints at the whole load: how much stronger the reactions
    /// are along those of the reference; NaN where these have no resultant
    double reaction_bias = 0.0;
    double worst_reaction_error = 0.0;    ///< the largest of Comparison::reaction_error along the path
    double worst_relative_l2 = 0.0;       ///< the largest of Comparison::relative_l2 along the path
    double percentile_95 = 0.0;           ///< of |u_i - r_i|, weighted by the nodal volumes [m]
    double volume_error = 0.0;            ///< (v - v_r) / V of the whole body
    std::vector<double> centroid_error{}; ///< (R) distance of the centroid of each region from where it should be [m]

    bool operator==(const PathComparison &) const = default;
};

/// Distance of a solution from a reference solution of the same problem. Ratios are NaN where the reference is at rest
/// at the end of its way, as where a ball has slid off: all that is left there is rounding.
struct Comparison {
    std::string reference;      ///< name of the reference model
    double load_fraction = 1.0; ///< part of the load at which all is compared: below 1 where the reference ended early
    double relative_l2 = 0.0;   ///< sqrt(sum_i V_i |u_i - r_i|^2 / sum_i V_i |r_i|^2), V_i barycentric nodal volume
    double max_error = 0.0;     ///< max_i |u_i - r_i| [m]
    double max_error_relative = 0.0; ///< max_error / max_i |r_i|
    double energy_error = 0.0;       ///< (U - U_r) / U_r of the strain energies, signed
    /// sqrt(sum_p |R_p - R_rp|^2 / sum_p |R_rp|^2) over the constraints; NaN where these have no resultant, as under
    /// torsion
    double reaction_error = 0.0;
    std::optional<HistoryComparison> history; ///< of the motion; not set by compare()
    std::optional<PathComparison> path;       ///< in the large regime, on a path of loads
    std::optional<SlowComparison> slow;       ///< of a slow history with a tool
    std::optional<ToolComparison> tool;       ///< where the load case has one
    std::vector<Vector3> error;               ///< (N) u - r [m]
};

/// Compares a solution with the reference.
/// @param mesh            nodes and volumes of both
/// @param load_case       on the mesh, whose solutions they are; its tools are compared
/// @param solution        any status; what is not finite gives a comparison that is not finite. Along the path it is
///   compared as far as it came
/// @param reference       status ok, not zero everywhere unless a ball may have left it
/// @param reference_name  kept in the comparison
/// @throws std::invalid_argument if the shapes differ, or if the reference is not a solution to compare with
Comparison compare(const TetraMesh &mesh, const LoadCase &load_case, const Solution &solution,
                   const Solution &reference, const std::string &reference_name);

/// Number of points of the path that a reference that ended early has come to, and others can be compared at: 0 for one
/// that has a solution to the whole load or that came to none, and where time passes in the material.
std::size_t num_points_reached(const LoadCase &load_case, const Solution &reference);

/// Compares a solution with a reference that ended early, at the last point of the path which that has reached, as two
/// solutions of the load there.
/// @param reference  with a number of points reached that is not 0
/// @return nothing if the solution did not come so far itself
std::optional<Comparison> compare_as_far_as_reached(const TetraMesh &mesh, const LoadCase &load_case,
                                                    const Solution &solution, const Solution &reference,
                                                    const std::string &reference_name);

/// Compares the motion of the probes. What is not finite gives a comparison that is not finite.
/// @param reference_name  kept in the comparison
/// @throws std::invalid_argument if they were recorded at other times, probes or nodes, or at fewer than two times
HistoryComparison compare(const History &history, const History &reference, const std::string &reference_name);

/// Modal assurance criterion of two shapes (Allemang and Brown 1982), 1 where they differ by a factor only and 0 where
/// they have nothing in common: (a . b)^2 / (a . a)(b . b) with a . b = sum_i V_i a_i . b_i, V_i barycentric nodal
/// volume.
/// @param a, b  shape (N), not zero everywhere
double modal_assurance(const TetraMesh &mesh, std::span<const Vector3> a, std::span<const Vector3> b);

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

/// A factor beyond these is not believed: differences that hardly shrink say little, and one that shrinks faster than
/// elements of second degree let expect is luck. Where meshes are refined at rims no order better than the first is
/// believed: there is none, and refinement there leaves the rest of the mesh as it is.
inline constexpr double largest_believed_factor = 0.8, smallest_believed_factor = 0.25, first_order_factor = 0.5;

/// The same of the motion of probes.
/// @param levels       at least three, recorded at the same times and probes
/// @param best_factor  that is believed: first_order_factor of meshes, smallest_believed_factor of steps
/// @throws std::invalid_argument if there are fewer, or if they do not fit together
ObservedMotionError observed_motion_error(std::span<const History> levels, double best_factor);

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
