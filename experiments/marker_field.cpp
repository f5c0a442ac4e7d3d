#include "experiments/marker_field.hpp"

#include <algorithm>
#include <set>

#include "load_cases/places/facets.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;
using Gradient = Eigen::Matrix3d;

Vector3 point_in(const core::TetraMesh &mesh, const std::array<int, 4> &nodes, const Eigen::Vector4d &coordinates) {
    Vector3 point = Vector3::Zero();
    for (int k = 0; k < 4; ++k)
        point += coordinates[k] * mesh.points[nodes[k]];
    return point;
}

/// (N) gradient of the displacement at each node: row i is the gradient of component i
std::vector<Gradient> nodal_gradients(const core::TetraMesh &mesh, std::span<const Vector3> displacement) {
    std::vector<Gradient> sum(mesh.points.size(), Gradient::Zero());
    std::vector<double> volume(mesh.points.size(), 0.0);
    for (const auto &nodes : mesh.tetrahedra) {
        Gradient differences;
        for (int k = 0; k < 3; ++k)
            differences.col(k) = displacement[nodes[k + 1]] - displacement[nodes[0]];
        const Gradient gradient = differences * core::coordinate_gradients(mesh, nodes).transpose();
        const double size = core::signed_volume(mesh.points[nodes[0]], mesh.points[nodes[1]], mesh.points[nodes[2]],
                                                mesh.points[nodes[3]]);
        for (const int node : nodes) {
            sum[node] += size * gradient;
            volume[node] += size;
        }
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] /= volume[i];
    return sum;
}

} // namespace

MarkerField::MarkerField(const core::TetraMesh &mesh, std::span<const Vector3> points) : mesh_(&mesh) {
    for (const auto &point : points) {
        places_.push_back(find(point));
        outside_.push_back(places_.back().peg.norm());
    }
}

MarkerField::Place MarkerField::find(const Vector3 &point) const {
    if (const auto at = core::locate(*mesh_, point); at.is_inside())
        return {at, Vector3::Zero()};
    const Vector3 base = load_cases::nearest_point(load_cases::all_facets(*mesh_), *mesh_, point).point;
    return {core::locate(*mesh_, base), point - base};
}

std::vector<int> MarkerField::nodes() const {
    std::set<int> corners, all; // gradients are of all tetrahedra at a corner
    for (const auto &place : places_)
        corners.insert(mesh_->tetrahedra[place.at.tetrahedron].begin(), mesh_->tetrahedra[place.at.tetrahedron].end());
    for (const auto &nodes : mesh_->tetrahedra)
        if (std::ranges::any_of(nodes, [&](int node) { return corners.contains(node); }))
            all.insert(nodes.begin(), nodes.end());
    return {all.begin(), all.end()};
}

std::vector<Vector3> MarkerField::at_points(std::span<const Vector3> displacement) const {
    const auto gradients = nodal_gradients(*mesh_, displacement);
    std::vector<Vector3> result;
    for (const auto &place : places_) {
        const auto &nodes = mesh_->tetrahedra[place.at.tetrahedron];
        const Vector3 point = point_in(*mesh_, nodes, place.at.coordinates);
        Vector3 &u = result.emplace_back(Vector3::Zero());
        for (int k = 0; k < 4; ++k) {
            const auto &gradient = gradients[nodes[k]];
            u += place.at.coordinates[k] *
                 (displacement[nodes[k]] + 0.5 * gradient * (point - mesh_->points[nodes[k]]) + gradient * place.peg);
        }
    }
    return result;
}

} // namespace livermark::experiments
