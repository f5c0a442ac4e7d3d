#include "msm/spring_law.hpp"

namespace livermark::msm::spring_laws {

namespace {

/// k_ij = c E_ij,   E_ij = sum of E_t V_t / sum of V_t over t at edge ij,
/// c = 15 sum over t of mu_t V_t / sum over edges of E_ij l_ij^2,   mu = E / 2.5
///
/// In a body of one material every spring has the same stiffness; at a tumour a spring takes the mean modulus of what
/// it runs through, by volume. One number is left to choose. An affine strain eps stores sum of k (l n.eps n)^2 / 2 in
/// the springs, so that C_abcd V = sum of k l^2 n_a n_b n_c n_d stands for them all; c makes its trace C_aabb that of
/// the isotropic solid with lambda = mu, C_aabb = 15 mu. It is the stiffness of the body as a whole, the mean over all
/// directions of stretch, that fits: no choice of one number can make every part of the body fit (Bianchi et al. 2004).
std::vector<double> stiffness(const core::Body &body, const core::EdgeTable &table) {
    const auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    std::vector<double> stiffness(table.edges.size(), 0.0);
    std::vector<double> volume_around(table.edges.size(), 0.0);
    double needed = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const double young_modulus = body.young_modulus_of(t);
        needed += 15.0 * (young_modulus / 2.5) * volumes[t];
        for (const int edge : table.tetrahedron_edge[t]) {
            stiffness[edge] += young_modulus * volumes[t];
            volume_around[edge] += volumes[t];
        }
    }
    double present = 0.0;
    for (std::size_t s = 0; s < stiffness.size(); ++s) {
        const auto [i, j] = table.edges[s];
        stiffness[s] /= volume_around[s];
        present += stiffness[s] * (mesh.points[j] - mesh.points[i]).squaredNorm();
    }
    for (double &k : stiffness)
        k *= needed / present;
    return stiffness;
}

} // namespace

SpringLaw uniform() {
    return {.name = {},
            .summary = "The same stiffness for every edge of a material, fitted to the body as a whole",
            .source = "the usual choice of mass-spring models; Bianchi et al. 2004 (MICCAI) on what it cannot do",
            .stiffness = stiffness};
}

} // namespace livermark::msm::spring_laws
