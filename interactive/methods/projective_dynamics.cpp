#include <memory>
#include <utility>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/implicit_elements.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

/// Local projections of each tetrahedron on rotations and on unit determinants, and a global solve with one factor.
Method projective_dynamics() {
    return {.summary = "projective dynamics: co-rotational strain and volume constraints, prefactorised",
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
            .knows_contact = true,
            .prepare = [](const Scene &scene) {
                auto energy = std::make_unique<WithSprings<ElementEnergy<densities::Projective>>>(
                    capsule_and_vessels(scene), tetrahedra_at_rest(*scene.body));
                const auto &tetrahedra = energy->tetrahedra();
                const auto &springs = energy->point_springs();
                return std::make_unique<Prefactored>(
                    scene, std::move(energy),
                    [&tetrahedra, &springs] { return sum_of(laplacian(tetrahedra), laplacian(springs)); },
                    [&springs](const Scene &of) {
                        return kernels::explicit_rows(of, kernels::Pressure::of_tetrahedra, springs);
                    });
            }};
}

} // namespace livermark::interactive::methods
