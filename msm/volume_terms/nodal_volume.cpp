#include <map>
#include <utility>

#include "msm/volume_penalty.hpp"
#include "msm/volume_term.hpp"

namespace livermark::msm::volume_terms {

namespace {

/// A control volume for each node and region at it, with a quarter of each of its tetrahedra there (Bonet and Burton
/// 1998: average nodal pressure). One pressure for each node leaves the nodes room to move; where two materials meet
/// the pressure jumps, so each has its own.
std::shared_ptr<const ElasticTerm> make(const core::Body &body, const std::vector<double> &modulus) {
    const auto &mesh = body.mesh;
    std::map<std::pair<int, int>, int> number; // of each node and region
    ControlVolumes parts;
    std::vector<Eigen::Triplet<double>> share;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        for (const int node : mesh.tetrahedra[t]) {
            const auto [place, is_new] = number.try_emplace({node, mesh.region[t]}, static_cast<int>(number.size()));
            if (is_new) {
                parts.modulus.push_back(modulus[mesh.region[t]]);
                parts.centre.push_back(node);
            }
            share.emplace_back(place->second, t, 0.25);
        }
    parts.share.resize(static_cast<Eigen::Index>(number.size()), mesh.num_tetrahedra());
    parts.share.setFromTriplets(share.begin(), share.end());
    return volume_penalty(mesh, parts);
}

} // namespace

VolumeTerm nodal_volume() {
    return {.name = {},
            .summary = "the volume around each node (average nodal pressure)",
            .source = "Bonet, Burton 1998, Commun. Numer. Meth. Engng. 14",
            .make = make};
}

} // namespace livermark::msm::volume_terms
