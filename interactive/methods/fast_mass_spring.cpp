#include <memory>
#include <utility>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/prefactored.hpp"
#include "interactive/kernels/prefactored_steps.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

class FastMassSpring : public Prefactored {
  public:
    explicit FastMassSpring(Scene given)
        : Prefactored(std::move(given)), energy_(springs_with_shear_modulus(*scene().body)) {
        use_elements(kernels::spring_rows(scene(), energy_.springs()));
    }

    const Energy &energy() const override { return energy_; }

  protected:
    void add_laplacian(Energy::Triplets &triplets) const override {
        const auto &springs = energy_.springs();
        for (std::size_t s = 0; s < springs.edges.size(); ++s)
            for (const int a : springs.edges[s])
                for (const int b : springs.edges[s])
                    triplets.emplace_back(a, b, a == b ? springs.stiffness[s] : -springs.stiffness[s]);
    }

  private:
    SpringEnergy energy_;
};

} // namespace

/// Springs on edges, without volumes: Poisson's ratio is 1/4 whatever the material says. Directions of springs and a
/// global solve with one factor.
Method fast_mass_spring() {
    return {.name = {},
            .summary = "fast mass-spring systems: springs on edges, backward Euler with one factor",
            .source = "Liu, Bargteil, O'Brien, Kavan 2013, Fast simulation of mass-spring systems, ACM TOG 32(6)",
            .energy = "k / 2 (|x_a - x_b| - l)^2 on edges by Lloyd's formula for mu",
            .converges_to = "the step of backward Euler",
            .objection =
                "It is for visual applications, where speed and stability are more important than precision (Liu et "
                "al. 2013). Springs alone have Poisson's ratio 1/4, so they cannot be nearly incompressible tissue "
                "(Golec et al. 2020, Hybrid 3D mass-spring system, The Visual Computer 36): 'livermark run "
                "--load-case pneumoperitoneum --model fast_mass_spring fem_p2 --poisson 0.25 0.45' shows it.",
            .implementation = "vector units, CHOLMOD's factor in single precision",
            .time_step = frame_time,
            .iterations = 10,
            .knows_contact = true,
            .prepare = [](const Scene &scene) { return std::make_unique<FastMassSpring>(scene); }};
}

} // namespace livermark::interactive::methods
