#include <memory>
#include <utility>
#include <vector>

#include "interactive/elements/point_springs.hpp"
#include "interactive/elements/position_based.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

class XpbdSprings : public PositionBased {
  public:
    explicit XpbdSprings(Scene given)
        : PositionBased(std::move(given)), edges_(edges_of(scene())),
          energy_(vessel_fibres(scene()), *scene().body, edges_),
          distances_(distances(energy_.springs()), static_cast<int>(positions().cols()),
                     scene().orders ? scene().orders->edge_colour : std::vector<int>{}),
          volumes_(volumes(energy_.tetrahedra()), static_cast<int>(positions().cols()), colours_of_volumes()),
          fibres_(fibres(energy_.point_springs()), static_cast<int>(positions().cols())) {
        use_constraints({distances_.rows(positions()), volumes_.rows(positions()), fibres_.rows(positions())});
    }

    const Energy &energy() const override { return energy_; }
    Orders orders() const override {
        Orders orders;
        orders.edges = edges_;
        orders.edge_colour = distances_.colours();
        auto colour = volumes_.colours().begin();
        for (const auto &t : energy_.tetrahedra())
            orders.tetrahedron_colour.push_back(has_volume(t) ? *colour++ : -1);
        return orders;
    }

  protected:
    void add_constraint_forces(const Field &x, double time_step, std::span<const kernels::ConstraintRows> sets,
                               Field &f) const override {
        distances_.add_forces(x, time_step, sets[0], f);
        volumes_.add_forces(x, time_step, sets[1], f);
        fibres_.add_forces(x, time_step, sets[2], f);
    }

  private:
    static core::EdgeTable edges_of(const Scene &scene) {
        return scene.orders && !scene.orders->edges.edges.empty() ? scene.orders->edges
                                                                  : core::edge_table(scene.body->mesh.tetrahedra);
    }

    /// As the scene knows them.
    std::vector<int> colours_of_volumes() const {
        std::vector<int> result;
        if (scene().orders)
            for (const int colour : scene().orders->tetrahedron_colour)
                if (colour >= 0)
                    result.push_back(colour);
        return result;
    }

    core::EdgeTable edges_;
    WithSprings<SpringAndVolumeEnergy> energy_;
    ConstraintSet<Distance> distances_;
    ConstraintSet<Volume> volumes_;
    ConstraintSet<Fibre> fibres_; ///< of vessels
};

} // namespace

/// Soft bodies as in games, with compliances of the material: springs on edges, and the volume of each tetrahedron.
Method xpbd_springs() {
    return {.summary = "extended position-based dynamics: springs on edges and volumes of tetrahedra as constraints",
            .source = "Macklin, Mueller, Chentanez 2016, XPBD: position-based simulation of compliant constrained "
                      "dynamics, MIG",
            .energy = "k / 2 (|x_a - x_b| - l)^2 on edges by Lloyd's formula for mu, (lambda - mu) / 2 (J - 1)^2",
            .converges_to = "the step of backward Euler, up to turns of constraint gradients during a step, which "
                            "vanish with h",
            .objection =
                "One step with many iterations is less effective than as many small steps with one each (Macklin et "
                "al. 2019, Small steps, SCA): 'livermark arena --mesh 1 --iterations 1 3 10 30 100 --method "
                "xpbd_springs' has both. Its iterations stall on fine meshes of stiff materials (Li et al. 2025, "
                "MGPBD, SIGGRAPH): --mesh 1 3 in the same command. Programs that do not keep its multipliers get "
                "stiffer with each iteration (newton-physics/newton#2933); here they are kept.",
            .implementation = "vector units over constraints of one colour, single precision",
            .knows_contact = true,
            .prepare = [](const Scene &scene) { return std::make_unique<XpbdSprings>(scene); }};
}

} // namespace livermark::interactive::methods
