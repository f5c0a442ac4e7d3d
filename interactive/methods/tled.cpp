#include <memory>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

/// Total Lagrangian explicit dynamics on linear tetrahedra, as NiftySim has it: all derivatives are those at rest.
Method tled() {
    return {.summary = "neo-Hookean linear tetrahedra, explicit (total Lagrangian explicit dynamics)",
            .source = "Miller, Joldes, Lance, Wittek 2007, Commun. Numer. Meth. Engng 23",
            .energy = "mu / 2 (I1 - 3 - 2 ln J) + lambda / 2 (ln J)^2",
            .converges_to = "the motion of the energy as h goes to 0; at rest the equilibrium of neo-Hookean linear "
                            "tetrahedra",
            .objection =
                "It was published for under-integrated hexahedra (Miller et al. 2007). The standard linear "
                "tetrahedron locks where a material is almost incompressible (Joldes, Wittek, Miller 2009, Commun. "
                "Numer. Meth. Engng 25): 'livermark run --load-case palpation --model tled tled_nodal_pressure fem_p2 "
                "--poisson 0.3 0.49' shows it. A GPU is more than ten times as fast (Johnsen et al. 2015, NiftySim, "
                "Int. J. CARS 10).",
            .implementation = "vector units, single precision",
            .iterations = 40,
            .is_explicit = true,
            .knows_contact = true,
            .prepare = [](const Scene &scene) {
                return explicit_with_springs<ElementEnergy<densities::NeoHookean>>(
                    scene, kernels::Pressure::of_tetrahedra, tetrahedra_at_rest(*scene.body));
            }};
}

} // namespace livermark::interactive::methods
