#include <memory>
#include <utility>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/prefactored.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

class ProjectiveDynamics : public Prefactored {
  public:
    explicit ProjectiveDynamics(Scene given)
        : Prefactored(std::move(given)), energy_(tetrahedra_at_rest(*scene().body)) {
        use_elements(kernels::explicit_rows(scene(), kernels::Pressure::of_tetrahedra));
    }

    const Energy &energy() const override { return energy_; }

  protected:
    void add_laplacian(Energy::Triplets &triplets) const override {
        for (const auto &t : energy_.tetrahedra()) {
            const Eigen::Matrix4d block = t.volume * densities::Projective{t.mu, t.lambda}.weight() *
                                          t.shape_gradients() * t.shape_gradients().transpose();
            for (int a = 0; a < 4; ++a)
                for (int b = 0; b < 4; ++b)
                    triplets.emplace_back(t.nodes[a], t.nodes[b], block(a, b));
        }
    }

  private:
    ElementEnergy<densities::Projective> energy_;
};

} // namespace

/// Local projections of each tetrahedron on rotations and on unit determinants, and a global solve with one factor.
Method projective_dynamics() {
    return {.name = {},
            .summary = "projective dynamics: co-rotational strain and volume constraints, prefactorised",
            .source = "Bouaziz, Martin, Liu, Kavan, Pauly 2014, Projective dynamics, ACM TOG 33(4)",
            .energy = "mu |F - R|^2 + 3 lambda / 2 |F - D|^2, D the nearest matrix with det D = 1",
            .converges_to = "the step of backward Euler",
            .objection =
                "It supports few materials, and not the neo-Hookean one (Liu, Bouaziz, Kavan 2017, Quasi-Newton "
                "methods, ACM TOG 36(3)). L-BFGS accelerates its iterations (the same), or Chebyshev's weights do "
                "(Wang 2015, ACM TOG 34(6)); here nothing does: 'livermark arena --mesh 1 --iterations 2 5 10 50 "
                "--method projective_dynamics' shows how it converges. Backward Euler damps its motion (Dinev, Liu, "
                "Kavan 2018, Stabilizing integrators, ACM TOG 37(1)). Rigorous benchmarks against reality were "
                "missing (Dubied et al. 2022, arXiv:2201.12560v1).",
            .implementation = "vector units without singular values, CHOLMOD's factor in single precision",
            .time_step = frame_time,
            .iterations = 10,
            .knows_contact = true,
            .prepare = [](const Scene &scene) { return std::make_unique<ProjectiveDynamics>(scene); }};
}

} // namespace livermark::interactive::methods
