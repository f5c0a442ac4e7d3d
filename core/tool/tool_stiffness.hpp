#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/solution.hpp"

namespace livermark::core {

/// Drive of a place, and so what its stiffness is compared by. The values are those of the result file.
enum class ToolDrive : std::uint8_t {
    traction = 0,    ///< by a given force: its displacement, in the mean weighted with the traction
    depth = 1,       ///< by LoadCase::press_depth, or the way of LoadCase::touching: its force
    displacement = 2 ///< to a prescribed displacement: its reaction
};

/// A place that is pressed, pulled or held to move. Constraints that stay where they are, and accelerations, are none.
struct ToolPlace {
    std::string name; ///< empty where the load case gives none
    ToolDrive drive = ToolDrive::traction;
    int constraint = -1;              ///< index into LoadCase::constraint_names(); -1 of a given traction
    std::vector<int> facets{};        ///< indices into mesh.boundary_triangles, ascending
    Vector3 middle = Vector3::Zero(); ///< of a round tool, otherwise the area centroid of the facets [m]
    /// Radius of a round tool, or where a ball sinks in that of Hertz's circle of contact, otherwise of the disc of the
    /// area of the facets [m].
    double radius = 0.0;
    double edge_length = 0.0; ///< mean over the edges of the facets [m]
};

/// The tools of a load case: first given tractions, in the order of LoadCase::load_names, then those of constraints.
/// Given tractions that LoadCase::load gives no name are one place.
std::vector<ToolPlace> tool_places(const TetraMesh &mesh, const LoadCase &load_case);

/// The smallest radius of a tool over the edge length under it; nothing without a tool.
std::optional<double> radius_in_edges(std::span<const ToolPlace> places);

/// Radius of contact of a ball that touches, by Hertz, sqrt(R d) at a depth d, over the mean edge below it, at
/// each point of the path. Below smallest_contact the error of its force has the sign that the mesh gives it.
/// @return shape (L); empty without a ball
std::vector<double> contact_radii_in_edges(const TetraMesh &mesh, const LoadCase &load_case);

/// Measured against finer and finer meshes, see docs/studies/contact.md.
inline constexpr double smallest_contact = 0.5;

/// Nodal forces of the given traction on a place: node and force [N], a row for each corner of a facet.
std::vector<std::pair<int, Vector3>> nodal_forces(const TetraMesh &mesh, const LoadCase &load_case,
                                                  const ToolPlace &place);

/// Errors of a solution at one tool.
struct PlaceErrors {
    std::string name;
    /// Force over displacement of the model over that of the reference, minus one; positive is too stiff. With a given
    /// traction t it is w_r / w - 1 with w the integral of t . u over the place at rest; else F . F_r / |F_r|^2 - 1 of
    /// the forces. At the whole load w is each model's own (Solution::load_work) where the reference says it;
    /// otherwise, and along the path, u is linear on facets for both. NaN where the reference has no such work or
    /// force, and where the model says nothing of it.
    double stiffness = 0.0;
    /// Comparison::relative_l2 over the nodes within two radii of the middle; NaN if there are none that move.
    double relative_l2 = 0.0;
    std::vector<double> path{}; ///< (L) stiffness at the points that both have; empty in the small regime,
                                ///< and of slow histories, which SlowComparison compares

    bool operator==(const PlaceErrors &) const = default;
};

/// Errors of a solution where it is touched.
struct ToolComparison {
    std::vector<PlaceErrors> places; ///< (G) as in tool_places(), at least one

    /// The place whose stiffness has the largest absolute value, of those that have one; otherwise the first.
    const PlaceErrors &worst_place() const;
    /// Its stiffness, which is that of the load case.
    double stiffness() const { return worst_place().stiffness; }
    /// Over the places, the stiffness of the largest absolute value at each point of the path.
    std::vector<double> along_path() const;
    /// The stiffness of the largest absolute value along the path and at the whole load; NaN where stiffness() is.
    double worst_stiffness() const;

    bool operator==(const ToolComparison &) const = default;
};

/// From here on fingers tell two forces apart. (Pang, Tan, Durlach 1991, Percept. Psychophys. 49(6))
inline constexpr double smallest_felt_difference = 0.07;

/// Compares a solution with the reference at the tools of a load case.
/// @param solution        any status; what is not finite gives what is not finite
/// @param smallest_force  below which forces of the reference are rounding [N]
/// @return nothing where the load case has no tool
std::optional<ToolComparison> compare_at_tool(const TetraMesh &mesh, const LoadCase &load_case,
                                              const Solution &solution, const Solution &reference,
                                              double smallest_force);

/// Work of nodal forces on displacements [J].
/// @param forces         as from nodal_forces()
/// @param displacements  shape (N), of either precision [m]
template <class Displacements>
double work_of(std::span<const std::pair<int, Vector3>> forces, const Displacements &displacements) {
    double sum = 0.0;
    for (const auto &[node, force] : forces)
        sum += force.dot(displacements[node].template cast<double>());
    return sum;
}

/// Factor that sums of nodal forces times displacements need so that they are the work of the tractions
/// with the model's own shape functions: Solution::load_work over the sum at the nodes, over all places with a given
/// traction; 1 where the model does not say it. Displacements below a round tool are a dome between the corners of
/// facets, so sums there miss 5 to 7 % of the work on quadratic elements.
double work_correction(const TetraMesh &mesh, const LoadCase &load_case, std::span<const ToolPlace> places,
                       const Solution &solution);

/// Force over displacement where a body is touched [N/m]; errors of it are PlaceErrors::stiffness.
///   given traction t:      |F|^2 / W, with F the resultant of t and W the integral of t . u over the place
///   pressed to a depth d:  |R| / d, with R the reaction
///   displaced by d:        R . d / |d|^2, with d the area mean of what is prescribed; free components count as 0
/// @param places    of the load case
/// @param solution  status ok
/// @return NaN where the traction has no resultant or does no work
double stiffness_at(const TetraMesh &mesh, const LoadCase &load_case, std::span<const ToolPlace> places,
                    std::size_t place, const Solution &solution);

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
