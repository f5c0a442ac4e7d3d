#pragma once

#include <array>
#include <numeric>
#include <utility>
#include <vector>

#include "benchmarks/peers/bullet_laws.hpp"
#include "interactive/colouring.hpp"
#include "interactive/elements/energies/element_energy.hpp"
#include "interactive/elements/spring_body.hpp"
#include "tests/oracles/explicit_steps.hpp"
#include "tests/oracles/implicit_steps.hpp"

/// Methods of ours with the materials that Bullet has.
namespace livermark::benchmarks {

/// Tetrahedra with the parameters that Bullet's neo-Hookean law needs for the material.
inline std::vector<interactive::Tetrahedron> tetrahedra_for_bullet(const core::Body &body) {
    auto tetrahedra = interactive::tetrahedra_at_rest(body);
    for (auto &t : tetrahedra) {
        const auto law = bullet_laws::NeoHookean::of_material(t.mu, t.lambda);
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
        : Prefactored(given, tests::laplacian(springs_of_mean_stiffness(*given.body))),
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
