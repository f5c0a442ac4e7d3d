#include "msm/volume_penalty.hpp"
#include "msm/volume_term.hpp"

namespace livermark::msm::volume_terms {

namespace {

/// The relative change of volume around a node, averaged over the corners of each tetrahedron, and that over the
/// tetrahedra around each node. Held nodes have nothing to give to the volumes around them, so at a constrained patch
/// even one pressure for each node is more than the nodes there can follow. Mesh-wide patterns of pressure, which the
/// nodes follow worst, are what the second mean leaves out.
std::shared_ptr<const ElasticTerm> make(const core::Body &body, const std::vector<double> &modulus) {
    return volume_penalty(body.mesh, mean_volumes_around_nodes(nodal_parts(body), modulus));
}

} // namespace

VolumeTerm mean_nodal_volume() {
    return {.name = {},
            .summary = "the volume around each node, averaged with its neighbours'",
            .source =
                "Livermark; Onishi, Iida, Amaya 2017, Int. J. Numer. Meth. Engng. 109, average strains of volume again "
                "and again",
            .make = make};
}

} // namespace livermark::msm::volume_terms
