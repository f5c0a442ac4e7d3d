#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"

namespace livermark::msm::volume_terms {

namespace {

/// One pressure around each node leaves the nodes room to move.
std::shared_ptr<const ElasticTerm> make(const core::Body &body, const std::vector<double> &modulus) {
    return volume_penalty(body.mesh, volumes_around_nodes(nodal_parts(body), modulus));
}

} // namespace

VolumeTerm nodal_volume() {
    return {.name = {},
            .summary = "the volume around each node (average nodal pressure)",
            .source = "Bonet, Burton 1998, Commun. Numer. Meth. Engng. 14",
            .make = make};
}

} // namespace livermark::msm::volume_terms
