#include <memory>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

/// The same as tled, with the pressure averaged around nodes.
Method tled_nodal_pressure() {
    return {.summary = "neo-Hookean linear tetrahedra with averaged nodal pressure, explicit",
            .source = "Joldes, Wittek, Miller 2009, Commun. Numer. Meth. Engng 25; Bonet, Burton 1998, ibid. 14",
            .energy =
                "mu / 2 (I1 - 3 - 2 ln J) in tetrahedra, lambda / 2 (ln J)^2 at nodes with the mean J around them",
            .converges_to = "the motion of the energy as h goes to 0; at rest its equilibrium",
            .objection =
                "Where materials meet, another average clearly improves reactions and displacements (Joldes, Wittek, "
                "Miller 2009); here the average is that of Bonet and Burton: 'livermark arena --mesh 1 --body "
                "liver_healthy liver_tumours --method tled_nodal_pressure' has a body without such borders and one "
                "with them. The element needs a finer mesh than ten-node tetrahedra (Erhart 2011, Review of solid "
                "element formulations in LS-DYNA, quoted in the group LS-DYNA2 in 2020): 'livermark arena --mesh 1 3 "
                "--method tled_nodal_pressure' shows how its error falls.",
            .implementation = "vector units, single precision",
            .iterations = 40,
            .is_explicit = true,
            .knows_contact = true,
            .prepare = [](const Scene &scene) {
                return explicit_with_springs<NodalPressureEnergy>(scene, kernels::Pressure::around_nodes, *scene.body);
            }};
}

} // namespace livermark::interactive::methods
