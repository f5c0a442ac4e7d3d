#pragma once

#include <span>
#include <utility>

#include "core/tool/tool_stiffness.hpp"

namespace livermark::core {

/// What nodal forces do on displacements [J].
/// @param forces         as from nodal_forces()
/// @param displacements  shape (N), of either precision [m]
template <class Displacements>
double work_of(std::span<const std::pair<int, Vector3>> forces, const Displacements &displacements) {
    double sum = 0.0;
    for (const auto &[node, force] : forces)
        sum += force.dot(displacements[node].template cast<double>());
    return sum;
}

/// What sums of nodal forces times displacements have to be multiplied by so that they are the work of the tractions
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

} // namespace livermark::core
