#pragma once

#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/prefactored.hpp"
#include "interactive/kernels/orders.hpp"
#include "tests/oracles/explicit_steps.hpp"
#include "tests/oracles/implicit_steps.hpp"

/// The laws of Bullet's tetrahedra, as its headers have them, in double precision: energies per volume as those of
/// interactive/elements/energies.hpp. Its third law, btDeformableLinearElasticityForce, is
/// interactive::densities::Corotational but for the rotation that it takes.
namespace livermark::benchmarks::bullet_laws {

using interactive::Matrix3;
using interactive::densities::Tangent;

/// btDeformableNeoHookeanForce: W = mu / 2 (I1 - 3 - ln(I1 + 1)) + lambda / 2 (J - 1 - 3 mu / (4 lambda))^2.
/// (Smith, De Goes, Kim 2018, Stable neo-Hookean flesh simulation, ACM TOG 37(2), eq. 14)
struct NeoHookean {
    double mu, lambda;

    /// Parameters that give small strains the Lame parameters of a material: 4/3 mu and lambda + 5/6 mu.
    /// (the same, eq. 16)
    static NeoHookean for_small_strains(double mu, double lambda) {
        return {.mu = 4.0 / 3.0 * mu, .lambda = lambda + 5.0 / 6.0 * mu};
    }

    double value(const Matrix3 &f) const {
        const double square = f.squaredNorm(), growth = f.determinant() - 1.0 - 0.75 * mu / lambda;
        return 0.5 * mu * (square - 3.0 - std::log(square + 1.0)) + 0.5 * lambda * growth * growth;
    }
    Matrix3 stress(const Matrix3 &f) const { return shear(f) * f + pressure(f) * interactive::cofactors(f); }
    Tangent tangent(const Matrix3 &f) const {
        const Eigen::Matrix<double, 9, 1> c = interactive::densities::by_columns(interactive::cofactors(f)),
                                          a = interactive::densities::by_columns(f);
        const double base = f.squaredNorm() + 1.0;
        return shear(f) * Tangent::Identity() + 2.0 * mu / (base * base) * a * a.transpose() +
               lambda * c * c.transpose() + pressure(f) * interactive::densities::determinant_tangent(f);
    }

  private:
    double shear(const Matrix3 &f) const { return mu * (1.0 - 1.0 / (f.squaredNorm() + 1.0)); }
    double pressure(const Matrix3 &f) const { return lambda * (f.determinant() - 1.0) - 0.75 * mu; }
};

/// btDeformableCorotatedForce: W = mu |F - R|^2 + lambda / 2 (J - 1)^2. Only its stress: Bullet has no more of it
/// either.
struct Corotated {
    double mu, lambda;

    Matrix3 stress(const Matrix3 &f) const {
        return 2.0 * mu * (f - interactive::densities::rotation(f)) +
               lambda * (f.determinant() - 1.0) * interactive::cofactors(f);
    }
};

} // namespace livermark::benchmarks::bullet_laws

/// Methods of ours with the materials that Bullet has.
namespace livermark::benchmarks {

/// Tetrahedra with the parameters that Bullet's neo-Hookean law needs for the material.
inline std::vector<interactive::Tetrahedron> tetrahedra_for_bullet(const core::Body &body) {
    auto tetrahedra = interactive::tetrahedra_at_rest(body);
    for (auto &t : tetrahedra) {
        const auto law = bullet_laws::NeoHookean::for_small_strains(t.mu, t.lambda);
        t.mu = law.mu;
        t.lambda = law.lambda;
    }
    return tetrahedra;
}

/// The steps of `tled` with Bullet's neo-Hookean law.
class BulletLawExplicit : public tests::CentralDifferences {
  public:
    explicit BulletLawExplicit(interactive::Scene given)
        : CentralDifferences(std::move(given)), energy_(tetrahedra_for_bullet(*scene().body)) {}

    const interactive::Energy &energy() const override { return energy_; }
    interactive::Cost cost(int iterations) const override {
        return {.element_passes = static_cast<double>(iterations),
                .bytes_per_element = sizeof(interactive::Tetrahedron)};
    }

  private:
    interactive::ElementEnergy<bullet_laws::NeoHookean> energy_;
};

/// Springs of `fast_mass_spring`, all with the mean stiffness: Bullet has one for all.
inline interactive::Springs springs_of_mean_stiffness(const core::Body &body) {
    auto springs = interactive::springs_with_shear_modulus(body);
    auto &k = springs.stiffness;
    k.assign(k.size(), std::accumulate(k.begin(), k.end(), 0.0) / static_cast<double>(k.size()));
    return springs;
}

/// The steps of `fast_mass_spring` with these.
class UniformMassSpring : public tests::Prefactored {
  public:
    explicit UniformMassSpring(const interactive::Scene &given)
        : Prefactored(given, interactive::laplacian(springs_of_mean_stiffness(*given.body))),
          energy_(springs_of_mean_stiffness(*given.body)) {}

    const interactive::SpringEnergy &energy() const override { return energy_; }
    interactive::Cost cost(int iterations) const override {
        return {.element_passes = static_cast<double>(iterations)};
    }

  private:
    interactive::SpringEnergy energy_;
};

/// Links in the order in which xpbd_springs visits its springs. Bullet has no compliance: in its first pass, each of
/// these takes away the part of its fault that the spring does with its own, w / (w + 1 / (k h^2)) with w the sum of
/// inverse masses.
struct CompliantLinks {
    std::vector<std::array<int, 2>> edges;
    std::vector<double> parts; ///< of (0, 1]
};

inline CompliantLinks links_as_compliant(const interactive::Scene &scene, double time_step) {
    const auto springs = interactive::springs_with_shear_modulus(*scene.body);
    const auto is_free = interactive::free_nodes(scene);
    const auto inverse_mass = [&](int i) { return is_free[i] ? 1.0 / scene.node_mass[i] : 0.0; };
    std::vector<std::vector<int>> sets;
    for (const auto &edge : springs.edges)
        sets.emplace_back(edge.begin(), edge.end());
    CompliantLinks links;
    for (const int s : interactive::colour_sets(sets, scene.body->mesh.num_nodes()).order) {
        const auto &[a, b] = springs.edges[s];
        const double weight = inverse_mass(a) + inverse_mass(b);
        links.edges.push_back(springs.edges[s]);
        links.parts.push_back(weight == 0.0 ? 1.0
                                            : weight / (weight + 1.0 / (springs.stiffness[s] * time_step * time_step)));
    }
    return links;
}

} // namespace livermark::benchmarks
