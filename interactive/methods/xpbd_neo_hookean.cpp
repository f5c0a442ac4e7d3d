#include <memory>
#include <utility>
#include <vector>

#include "interactive/elements/energies.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/elements/position_based.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

class XpbdNeoHookean : public PositionBased {
  public:
    explicit XpbdNeoHookean(Scene given)
        : PositionBased(std::move(given)), energy_(capsule_and_vessels(scene()), tetrahedra_at_rest(*scene().body)),
          pairs_(neo_hookean_pairs(energy_.tetrahedra()), static_cast<int>(positions().cols()),
                 scene().orders ? scene().orders->tetrahedron_colour : std::vector<int>{}),
          edges_(distances(energy_.point_springs()), static_cast<int>(positions().cols())),
          fibres_(fibres(energy_.point_springs()), static_cast<int>(positions().cols())) {
        use_constraints({pairs_.rows(positions()), edges_.rows(positions()), fibres_.rows(positions())});
    }

    const Energy &energy() const override { return energy_; }
    Orders orders() const override {
        Orders orders;
        orders.tetrahedron_colour = pairs_.colours();
        return orders;
    }

  protected:
    void add_constraint_forces(const Field &x, double time_step, std::span<const kernels::ConstraintRows> sets,
                               Field &f) const override {
        pairs_.add_forces(x, time_step, sets[0], f);
        edges_.add_forces(x, time_step, sets[1], f);
        fibres_.add_forces(x, time_step, sets[2], f);
    }

  private:
    WithSprings<ElementEnergy<densities::StableNeoHookean>> energy_;
    ConstraintSet<NeoHookeanPair> pairs_;
    ConstraintSet<Distance> edges_; ///< of a capsule
    ConstraintSet<Fibre> fibres_;   ///< of vessels
};

} // namespace

/// A neo-Hookean material as constraints.
Method xpbd_neo_hookean() {
    return {.summary = "extended position-based dynamics: stable neo-Hookean tetrahedra as pairs of constraints",
            .source = "Macklin, Mueller 2021, A constraint-based formulation of stable neo-Hookean materials, MIG",
            .energy = "mu / 2 (I1 - 3) - mu (J - 1) + (lambda + mu) / 2 (J - 1)^2",
            .converges_to = "the step of backward Euler, up to turns of constraint gradients during a step, which "
                            "vanish with h",
            .objection =
                "With hyperelasticity it does not always converge, because it linearises backward Euler approximately "
                "(Chen et al. 2024, Primal residual reduction with XPBD, Computers and Graphics): "
                "'interactive_fast_tests --gtest_filter=*PositionBased*' prints what remains. One step with many "
                "iterations is less effective than as many small steps with one each (Macklin et al. 2019, Small "
                "steps, SCA): 'livermark arena --mesh 1 --iterations 1 3 10 30 100 --method xpbd_neo_hookean' has "
                "both. The two constraints of a tetrahedron converge faster together (Ton-That, Kry, Andrews 2022, "
                "Parallel block neo-Hookean XPBD, Computers and Graphics), which is done here.",
            .implementation = "vector units over tetrahedra of one colour, single precision",
            .knows_contact = true,
            .prepare = [](const Scene &scene) { return std::make_unique<XpbdNeoHookean>(scene); }};
}

} // namespace livermark::interactive::methods
