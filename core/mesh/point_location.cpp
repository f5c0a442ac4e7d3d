#include "core/mesh/point_location.hpp"

#include <Eigen/Dense>
#include <limits>

namespace livermark::core {

Eigen::Matrix3d coordinate_gradients(const TetraMesh &mesh, const std::array<int, 4> &nodes) {
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k)
        edges.row(k) = (mesh.points[nodes[k + 1]] - mesh.points[nodes[0]]).transpose();
    return edges.inverse();
}

bool LocatedPoint::is_inside() const {
    constexpr double rounding = 1e-9;
    return coordinates.minCoeff() >= -rounding;
}

LocatedPoint locate(const TetraMesh &mesh, const Vector3 &point) {
    LocatedPoint best;
    double inside = -std::numeric_limits<double>::infinity();
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        const auto &nodes = mesh.tetrahedra[t];
        const Vector3 last = coordinate_gradients(mesh, nodes).transpose() * (point - mesh.points[nodes[0]]);
        const Eigen::Vector4d coordinates(1.0 - last.sum(), last[0], last[1], last[2]);
        if (coordinates.minCoeff() > inside) {
            inside = coordinates.minCoeff();
            best = {t, coordinates};
        }
    }
    return best;
}

} // namespace livermark::core
