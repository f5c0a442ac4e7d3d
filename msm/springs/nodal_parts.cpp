#include "msm/springs/nodal_parts.hpp"

#include <map>
#include <utility>

namespace livermark::msm {

NodalParts nodal_parts(const core::Body &body) {
    const auto &mesh = body.mesh;
    NodalParts parts;
    parts.tetrahedron_volume = core::tetrahedron_volumes(mesh);
    parts.at_corner.resize(mesh.tetrahedra.size());
    std::map<std::pair<int, int>, int> number; // of each node and region
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (int corner = 0; corner < 4; ++corner) {
            const int node = mesh.tetrahedra[t][corner];
            const auto [place, is_new] = number.try_emplace({node, mesh.region[t]}, static_cast<int>(number.size()));
            if (is_new) {
                parts.node.push_back(node);
                parts.region.push_back(mesh.region[t]);
                parts.volume.push_back(0.0);
            }
            parts.at_corner[t][corner] = place->second;
            parts.volume[place->second] += parts.tetrahedron_volume[t] / 4.0;
        }
    return parts;
}

} // namespace livermark::msm
