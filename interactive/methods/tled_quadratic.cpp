#include <memory>

#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

/// The same as tled, with a node in the middle of each edge: elements that do not lock. Their frequencies are higher.
Method tled_quadratic() {
    return {.summary = "neo-Hookean quadratic tetrahedra, explicit (total Lagrangian explicit dynamics)",
            .source = "Miller, Joldes, Lance, Wittek 2007, Commun. Numer. Meth. Engng 23; Hinton, Rock, Zienkiewicz "
                      "1976, Earthq. Engng Struct. Dyn. 4",
            .energy = "mu / 2 (I1 - 3 - 2 ln J) + lambda / 2 (ln J)^2 at four points of a tetrahedron",
            .converges_to = "the motion of the energy as h goes to 0; at rest the equilibrium of neo-Hookean quadratic "
                            "tetrahedra",
            .objection =
                "Ten-node tetrahedra need short time steps (Altair Radioss, theory manual, Solid Tetrahedron "
                "Elements): 'livermark arena --mesh 1 --budget 66.7 --details --method tled tled_quadratic' says how "
                "many. Composite ones were designed for well-defined lumped masses and contact tractions (Thoutireddy "
                "et al. 2002, Tetrahedral composite finite elements, IJNME 53). For incompressible rubber at large "
                "strains users of LS-DYNA are told to average nodal pressures instead (Erhart 2011, Review of solid "
                "element formulations in LS-DYNA, quoted in the group LS-DYNA2 in 2020).",
            .implementation = "vector units, single precision",
            .iterations = 100,
            .is_explicit = true,
            .knows_contact = true,
            .prepare = [](const Scene &scene) {
                const auto quadratic = quadratic_scene(scene);
                return explicit_with_springs<QuadraticEnergy>(quadratic, kernels::Pressure::of_tetrahedra, quadratic);
            }};
}

} // namespace livermark::interactive::methods
