#include "core/mesh/places.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace livermark::core {

namespace {

std::vector<FacetPoint> radon_points() {
    const double root = std::sqrt(15.0);
    std::vector<FacetPoint> points{{{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, 9.0 / 40.0}};
    for (const double sign : {-1.0, 1.0}) {
        const double small = (6.0 + sign * root) / 21.0, part = (155.0 + sign * root) / 1200.0;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            FacetPoint point{{small, small, small}, part};
            point.shape[corner] = 1.0 - 2.0 * small;
            points.push_back(point);
        }
    }
    return points;
}

} // namespace

std::vector<FacetPoint> facet_points(int divisions) {
    const auto rule = radon_points();
    std::vector<FacetPoint> points;
    points.reserve(rule.size() * static_cast<std::size_t>(divisions) * static_cast<std::size_t>(divisions));
    const double side = 1.0 / divisions;
    // The triangle with its first corner at (i, j) in steps along two sides, or turned around, with that opposite.
    const auto add = [&](int i, int j, double way) {
        for (const auto &point : rule) {
            const double first = side * (i + way * point.shape[0]), second = side * (j + way * point.shape[1]);
            points.push_back({{first, second, 1.0 - first - second}, side * side * point.part});
        }
    };
    for (int i = 0; i < divisions; ++i)
        for (int j = 0; i + j < divisions; ++j) {
            add(i, j, 1.0);
            if (i + j + 1 < divisions)
                add(i + 1, j + 1, -1.0);
        }
    return points;
}

Eigen::Matrix3d coordinate_gradients(const TetraMesh &mesh, const std::array<int, 4> &nodes) {
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k)
        edges.row(k) = (mesh.points[nodes[k + 1]] - mesh.points[nodes[0]]).transpose();
    return edges.inverse();
}

Eigen::Vector4d coordinate_slopes(const TetraMesh &mesh, const std::array<int, 4> &nodes, const Vector3 &direction) {
    const Vector3 others = coordinate_gradients(mesh, nodes).transpose() * direction;
    return {-others.sum(), others[0], others[1], others[2]};
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

namespace {

using Barycentric = Eigen::Vector4d;
using Part = std::array<Barycentric, 4>;

/// The edges of what a part is cut into, over the radius: the quadrature is then good to 1e-4 of the mean of a linear
/// field.
constexpr double longest_part = 0.25;
constexpr int most_cuts = 6;

/// Calls visit(part, its part of the volume) for the eight children of a tetrahedron, again and again.
template <class Visit> void cut(const Part &part, int times, double share, const Visit &visit) {
    if (times == 0)
        return visit(part, share);
    const auto mid = [&](int i, int j) -> Barycentric { return 0.5 * (part[i] + part[j]); };
    const auto m01 = mid(0, 1), m02 = mid(0, 2), m03 = mid(0, 3), m12 = mid(1, 2), m13 = mid(1, 3), m23 = mid(2, 3);
    const std::array<Part, 8> children{{{part[0], m01, m02, m03},
                                        {m01, part[1], m12, m13},
                                        {m02, m12, part[2], m23},
                                        {m03, m13, m23, part[3]},
                                        {m01, m02, m03, m13},
                                        {m01, m02, m12, m13},
                                        {m02, m03, m13, m23},
                                        {m02, m12, m13, m23}}};
    for (const auto &child : children)
        cut(child, times - 1, 0.125 * share, visit);
}

Part whole() {
    return {Barycentric::Unit(0), Barycentric::Unit(1), Barycentric::Unit(2), Barycentric::Unit(3)};
}

} // namespace

std::vector<PlacePoint> points_of(const InteriorPlace &place, const TetraMesh &mesh) {
    std::vector<PlacePoint> points;
    double sum = 0.0;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        Eigen::Matrix<double, 3, 4> corners;
        for (int k = 0; k < 4; ++k)
            corners.col(k) = mesh.points[mesh.tetrahedra[t][k]];
        if (((corners.rowwise().minCoeff() - place.middle).array() > place.radius).any() ||
            ((place.middle - corners.rowwise().maxCoeff()).array() > place.radius).any())
            continue;
        double longest = 0.0;
        for (const auto &[i, j] : tetrahedron_edges)
            longest = std::max(longest, (corners.col(i) - corners.col(j)).norm());
        int times = 0;
        while (times < most_cuts && longest > longest_part * place.radius) {
            longest *= 0.5;
            ++times;
        }
        const double volume = signed_volume(corners.col(0), corners.col(1), corners.col(2), corners.col(3));
        cut(whole(), times, volume, [&](const Part &part, double size) {
            const Barycentric centroid = 0.25 * (part[0] + part[1] + part[2] + part[3]);
            const double away = (corners * centroid - place.middle).squaredNorm() / (place.radius * place.radius);
            if (away >= 1.0)
                return;
            const double weight = size * (1.0 - away) * (1.0 - away);
            points.push_back({t, centroid, weight});
            sum += weight;
        });
    }
    if (points.empty())
        throw std::invalid_argument(fmt::format("no point of the body is within {:g} m of ({:g}, {:g}, {:g}) m",
                                                place.radius, place.middle.x(), place.middle.y(), place.middle.z()));
    for (auto &point : points)
        point.weight /= sum;
    return points;
}

Eigen::SparseMatrix<double, Eigen::RowMajor> nodal_weights(std::span<const InteriorPlace> places,
                                                           const TetraMesh &mesh) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t k = 0; k < places.size(); ++k)
        for (const auto &[tetrahedron, barycentric, weight] : points_of(places[k], mesh))
            for (int i = 0; i < 4; ++i)
                entries.emplace_back(static_cast<int>(k), mesh.tetrahedra[tetrahedron][i], weight * barycentric[i]);
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights(static_cast<Eigen::Index>(places.size()), mesh.num_nodes());
    weights.setFromTriplets(entries.begin(), entries.end());
    return weights;
}

Deformation deformation(const TetraMesh &mesh, std::span<const Vector3> displacement) {
    if (displacement.size() != mesh.points.size())
        throw std::invalid_argument(
            fmt::format("{} displacements on a mesh of {} nodes", displacement.size(), mesh.points.size()));
    const auto at_rest = tetrahedron_volumes(mesh);
    Deformation result;
    result.smallest_jacobian = std::numeric_limits<double>::infinity();
    result.centroid.assign(mesh.region_names.size(), Vector3::Zero());
    std::vector<double> volume_of_region(mesh.region_names.size(), 0.0);
    double before = 0.0, after = 0.0;
    bool is_finite = true;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        std::array<Vector3, 4> corner;
        Vector3 middle = Vector3::Zero();
        for (std::size_t c = 0; c < 4; ++c) {
            const int node = mesh.tetrahedra[t][c];
            corner[c] = mesh.points[node] + displacement[node];
            middle += 0.25 * corner[c];
        }
        const double volume = signed_volume(corner[0], corner[1], corner[2], corner[3]);
        is_finite = is_finite && std::isfinite(volume);
        if (!(volume > 0.0))
            ++result.num_inverted;
        result.smallest_jacobian = std::min(result.smallest_jacobian, volume / at_rest[t]);
        before += at_rest[t];
        after += volume;
        // Weights of rest: the mass of tissue does not change.
        result.centroid[mesh.region[t]] += at_rest[t] * middle;
        volume_of_region[mesh.region[t]] += at_rest[t];
    }
    for (std::size_t r = 0; r < result.centroid.size(); ++r)
        result.centroid[r] /= volume_of_region[r];
    result.volume_change = after / before - 1.0;
    if (!is_finite)
        result.smallest_jacobian = std::numeric_limits<double>::quiet_NaN();
    return result;
}

} // namespace livermark::core
