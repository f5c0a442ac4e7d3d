#include "core/mesh/interior_place.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <stdexcept>

namespace livermark::core {

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

} // namespace livermark::core
