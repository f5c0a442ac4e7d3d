#include "core/mesh/deformation.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <stdexcept>

namespace livermark::core {

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
