#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"

namespace livermark::msm::volume_terms {

namespace {

/// A control volume for each tetrahedron. There are five times as many tetrahedra as nodes, so this fixes more than the
/// nodes have to give, and locks when the material is nearly incompressible, as linear finite elements do.
std::shared_ptr<const ElasticTerm> make(const core::Body &body, const std::vector<double> &modulus) {
    const auto &mesh = body.mesh;
    ControlVolumes parts;
    parts.share.resize(mesh.num_tetrahedra(), mesh.num_tetrahedra());
    parts.share.setIdentity();
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        parts.modulus.push_back(modulus[mesh.region[t]] * body.modulus_factor_of(t));
    return volume_penalty(mesh, parts);
}

} // namespace

VolumeTerm tetrahedral_volume() {
    return {.name = {},
            .summary = "the volume of each tetrahedron",
            .source = "Teschner, Heidelberger, Mueller, Gross 2004, Computer Graphics International",
            .make = make};
}

} // namespace livermark::msm::volume_terms
