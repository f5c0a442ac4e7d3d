#pragma once

#include <memory>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "interactive/elements/implicit_elements.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/elements/position_based.hpp"
#include "interactive/method.hpp"
#include "tests/oracles/explicit_steps.hpp"
#include "tests/oracles/implicit_steps.hpp"

namespace livermark::tests {

/// Slow steps with the scene, the energy and the critical step of a fast simulation.
template <class Steps> class SlowSimulation : public Steps {
  public:
    template <class... Arguments>
    explicit SlowSimulation(std::unique_ptr<interactive::Simulation> fast, Arguments &&...arguments)
        : Steps(fast->scene(), std::forward<Arguments>(arguments)...), fast_(std::move(fast)) {}

    const interactive::Energy &energy() const override { return fast_->energy(); }
    double critical_time_step() const override { return fast_->critical_time_step(); }
    interactive::Cost cost(int iterations) const override { return fast_->cost(iterations); }

  private:
    std::unique_ptr<interactive::Simulation> fast_;
};

/// Constraints in the order in which a method visits those whose colours no scene knows.
template <class Kind> Constraints<Kind> coloured(const std::vector<Kind> &kinds, const interactive::Scene &scene) {
    return {kinds, interactive::ConstraintSet<Kind>(kinds, interactive::num_nodes(scene)).colours()};
}

/// The steps of a method in double precision, in plain loops: what its vectors are compared with.
inline std::unique_ptr<interactive::Simulation> prepare_slowly(const interactive::Method &method,
                                                               const interactive::Scene &scene) {
    auto fast = method.prepare(scene);
    if (method.is_explicit)
        return std::make_unique<SlowSimulation<CentralDifferences>>(std::move(fast));
    const auto tetrahedra = interactive::tetrahedra_at_rest(*scene.body);
    const auto orders = fast->orders();
    if (method.name == "corotational_implicit")
        return std::make_unique<SlowSimulation<Corotational>>(std::move(fast));
    if (method.name == "projective_dynamics")
        return std::make_unique<SlowSimulation<Prefactored>>(
            std::move(fast),
            interactive::sum_of(laplacian(tetrahedra), laplacian(interactive::capsule_and_vessels(scene))));
    if (method.name == "fast_mass_spring")
        return std::make_unique<SlowSimulation<Prefactored>>(
            std::move(fast), interactive::sum_of(laplacian(interactive::springs_with_shear_modulus(*scene.body)),
                                                 laplacian(interactive::vessel_fibres(scene))));
    if (method.name == "vertex_block_descent")
        return std::make_unique<SlowSimulation<BlockDescent>>(std::move(fast), orders.node_colour);
    if (method.name == "xpbd_neo_hookean") {
        using Sets = std::tuple<Constraints<interactive::NeoHookeanPair>, Constraints<interactive::Distance>,
                                Constraints<interactive::Fibre>>;
        const auto springs = interactive::capsule_and_vessels(scene);
        return std::make_unique<SlowSimulation<PositionBased<Sets>>>(
            std::move(fast),
            Sets({interactive::neo_hookean_pairs(tetrahedra), orders.tetrahedron_colour},
                 coloured(interactive::distances(springs), scene), coloured(interactive::fibres(springs), scene)));
    }
    if (method.name != "xpbd_springs")
        return fast; // is in double precision itself
    using Sets = std::tuple<Constraints<interactive::Distance>, Constraints<interactive::Volume>,
                            Constraints<interactive::Fibre>>;
    std::vector<int> colours = orders.tetrahedron_colour;
    std::erase(colours, -1); // those without a volume to keep
    return std::make_unique<SlowSimulation<PositionBased<Sets>>>(
        std::move(fast),
        Sets({interactive::distances(interactive::springs_with_shear_modulus(*scene.body, orders.edges)),
              orders.edge_colour},
             {interactive::volumes(tetrahedra), colours},
             coloured(interactive::fibres(interactive::vessel_fibres(scene)), scene)));
}

/// The method of that name with its slow steps. None acts after steps.
inline interactive::Method slow_method(std::string_view name) {
    auto method = interactive::find_method(name);
    method.prepare = [fast = method](const interactive::Scene &scene) { return prepare_slowly(fast, scene); };
    return method;
}

} // namespace livermark::tests
