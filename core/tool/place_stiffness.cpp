#include "core/tool/place_stiffness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace livermark::core {

namespace {

Vector3 mean_prescribed(const TetraMesh &mesh, const LoadCase &load_case, const ToolPlace &place) {
    Vector3 sum = Vector3::Zero();
    double area = 0.0;
    for (const int facet : place.facets) {
        const double part = area_vector(mesh, facet).norm();
        area += part;
        for (const int node : mesh.boundary_triangles[facet]) {
            const Vector3 prescribed = load_case.prescribed_at(facet, node);
            sum += part / 3.0 * prescribed.array().isNaN().select(0.0, prescribed.array()).matrix();
        }
    }
    return sum / area;
}

} // namespace

double work_correction(const TetraMesh &mesh, const LoadCase &load_case, std::span<const ToolPlace> places,
                       const Solution &solution) {
    double at_nodes = 0.0;
    for (const auto &place : places)
        if (place.drive == ToolDrive::traction)
            at_nodes += work_of(nodal_forces(mesh, load_case, place), solution.displacement);
    return std::isnan(solution.load_work) || at_nodes == 0.0 ? 1.0 : solution.load_work / at_nodes;
}

double stiffness_at(const TetraMesh &mesh, const LoadCase &load_case, std::span<const ToolPlace> places,
                    std::size_t place, const Solution &solution) {
    constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
    const auto &tool = places[place];
    if (tool.drive == ToolDrive::depth)
        return solution.reaction[tool.constraint].norm() /
               std::max(load_case.contact_depth(), std::abs(load_case.press_depth));
    if (tool.drive == ToolDrive::displacement) {
        const Vector3 moved = mean_prescribed(mesh, load_case, tool);
        return moved.isZero(0.0) ? no_number : solution.reaction[tool.constraint].dot(moved) / moved.squaredNorm();
    }
    Vector3 resultant = Vector3::Zero();
    double possible = 0.0;
    const auto forces = nodal_forces(mesh, load_case, tool);
    for (const auto &[node, force] : forces) {
        resultant += force;
        possible += force.norm();
    }
    const double work = work_correction(mesh, load_case, places, solution) * work_of(forces, solution.displacement);
    constexpr double least_resultant = 1e-6; // below this part of what it could be it is rounding, as under torsion
    return resultant.norm() > least_resultant * possible && work != 0.0 ? resultant.squaredNorm() / work : no_number;
}

} // namespace livermark::core
