#include <memory>
#include <utility>

#include "interactive/elements/central_differences.hpp"
#include "interactive/elements/nodal_pressure_energy.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

class TledNodalPressure : public CentralDifferences {
  public:
    explicit TledNodalPressure(Scene given) : CentralDifferences(std::move(given)), energy_(*scene().body) {}

    const Energy &energy() const override { return energy_; }
    Cost cost(int iterations) const override {
        return {.element_passes = 2.0 * iterations, .bytes_per_element = sizeof(Tetrahedron)};
    }

  private:
    NodalPressureEnergy energy_;
};

} // namespace

/// The same as tled, with the pressure averaged around nodes.
Method tled_nodal_pressure() {
    return {.name = {},
            .summary = "neo-Hookean linear tetrahedra with averaged nodal pressure, explicit",
            .source = "Joldes, Wittek, Miller 2009, Commun. Numer. Meth. Engng 25; Bonet, Burton 1998, ibid. 14",
            .energy =
                "mu / 2 (I1 - 3 - 2 ln J) in tetrahedra, lambda / 2 (ln J)^2 at nodes with the mean J around them",
            .converges_to = "the motion of the energy as h goes to 0; at rest its equilibrium",
            .implementation = "two plain loops over tetrahedra, double",
            .time_step = frame_time,
            .iterations = 40,
            .prepare = [](const Scene &scene) { return std::make_unique<TledNodalPressure>(scene); }};
}

} // namespace livermark::interactive::methods
