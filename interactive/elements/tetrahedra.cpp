#include "interactive/elements/tetrahedra.hpp"

namespace livermark::interactive {

std::vector<Tetrahedron> tetrahedra_at_rest(const core::Body &body) {
    std::vector<Tetrahedron> result;
    result.reserve(body.mesh.tetrahedra.size());
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t) {
        const auto &nodes = body.mesh.tetrahedra[t];
        const auto &material = body.materials[body.mesh.region[t]];
        Matrix3 edges;
        for (int c = 0; c < 3; ++c)
            edges.col(c) = body.mesh.points[nodes[c + 1]] - body.mesh.points[nodes[0]];
        result.push_back({.nodes = nodes,
                          .inverse_edges = edges.inverse(),
                          .volume = edges.determinant() / 6.0,
                          .mu = material.shear_modulus(),
                          .lambda = material.lame_lambda()});
    }
    return result;
}

} // namespace livermark::interactive
