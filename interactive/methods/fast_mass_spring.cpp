#include <memory>
#include <utility>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/implicit_elements.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

/// Springs on edges, without volumes: Poisson's ratio is 1/4 whatever the material says. Directions of springs and a
/// global solve with one factor.
Method fast_mass_spring() {
    return {.summary = "fast mass-spring systems: springs on edges, backward Euler with one factor",
            .source = "Liu, Bargteil, O'Brien, Kavan 2013, Fast simulation of mass-spring systems, ACM TOG 32(6)",
            .energy = "k / 2 (|x_a - x_b| - l)^2 on edges by Lloyd's formula for mu",
            .converges_to = "the step of backward Euler",
            .objection =
                "It is for visual applications, where speed and stability are more important than precision (Liu et "
                "al. 2013). Springs alone have Poisson's ratio 1/4, so they cannot be nearly incompressible tissue "
                "(Golec et al. 2020, Hybrid 3D mass-spring system, The Visual Computer 36): 'livermark run "
                "--load-case pneumoperitoneum --model fast_mass_spring fem_p2 --poisson 0.25 0.45' shows it.",
            .implementation = "vector units, CHOLMOD's factor in single precision",
            .knows_contact = true,
            .prepare = [](const Scene &scene) {
                auto energy = std::make_unique<WithSprings<SpringEnergy>>(vessel_fibres(scene),
                                                                          springs_with_shear_modulus(*scene.body));
                const auto &springs = energy->springs();
                const auto &fibres = energy->point_springs();
                return std::make_unique<Prefactored>(
                    scene, std::move(energy),
                    [&springs, &fibres] { return sum_of(laplacian(springs), laplacian(fibres)); },
                    [&springs, &fibres](const Scene &of) { return kernels::spring_rows(of, springs, fibres); });
            }};
}

} // namespace livermark::interactive::methods
