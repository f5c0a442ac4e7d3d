#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "interactive/elements/constraint_set.hpp"
#include "interactive/elements/energies/element_energy.hpp"
#include "interactive/elements/position_based.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

/// Two constraints of a tetrahedron: C_D = |F|, alpha_D = 1 / (mu V), and C_H = J - 1 - mu / k, alpha_H = 1 / (k V)
/// with k = lambda + mu. Solved together they leave a body at rest in its shape; one after the other they do not before
/// they have converged.
struct NeoHookeanPair {
    static constexpr int num_nodes = 4, num_constraints = 2;
    static constexpr auto constraint = kernels::Constraint::pair;
    std::array<int, 4> nodes;
    Eigen::Vector2d compliance; ///< [1/J]
    Matrix3 inverse_edges;
    double rest; ///< 1 + mu / k

    void evaluate(const Field &x, Eigen::Vector2d &c, Eigen::Matrix<double, 12, 2> &g) const {
        Matrix3 edges;
        for (int e = 0; e < 3; ++e)
            edges.col(e) = x.col(nodes[e + 1]) - x.col(nodes[0]);
        const Matrix3 f = edges * inverse_edges;
        const double size = f.norm();
        c << size, f.determinant() - rest;
        const Matrix3 deviatoric = f / size * inverse_edges.transpose();
        const Matrix3 hydrostatic = cofactors(f) * inverse_edges.transpose();
        g.col(0) << -deviatoric.rowwise().sum(), deviatoric.col(0), deviatoric.col(1), deviatoric.col(2);
        g.col(1) << -hydrostatic.rowwise().sum(), hydrostatic.col(0), hydrostatic.col(1), hydrostatic.col(2);
    }

    std::array<double, 12> numbers(const Field & /*rest*/) const {
        const Matrix3 gradients = inverse_edges.transpose(); // by columns
        std::array<double, 12> numbers{};
        *std::copy_n(gradients.data(), gradients.size(), numbers.begin()) = rest - 1.0;
        numbers[10] = compliance[0];
        numbers[11] = compliance[1];
        return numbers;
    }
};

class XpbdNeoHookean : public PositionBased {
  public:
    explicit XpbdNeoHookean(Scene given)
        : PositionBased(std::move(given)), energy_(tetrahedra_at_rest(*scene().body)),
          pairs_(pairs(), static_cast<int>(positions().cols()),
                 scene().orders ? scene().orders->tetrahedron_colour : std::vector<int>{}) {
        if (is_in_single_precision())
            use_vectors({pairs_.rows(positions())});
    }

    const Energy &energy() const override { return energy_; }
    Orders orders() const override {
        Orders orders;
        orders.tetrahedron_colour = pairs_.colours();
        return orders;
    }

  protected:
    void clear_multipliers() override { pairs_.clear(); }
    void project(Field &x, const std::vector<double> &inverse_mass, double time_step) override {
        pairs_.project(x, inverse_mass, time_step);
    }
    void add_constraint_forces(const Field &x, double time_step, std::span<const kernels::ConstraintRows> sets,
                               Field &f) const override {
        pairs_.add_forces(x, time_step, f, sets.empty() ? nullptr : &sets[0]);
    }
    std::size_t bytes_of_constraints() const override { return pairs_.bytes(); }

  private:
    std::vector<NeoHookeanPair> pairs() const {
        std::vector<NeoHookeanPair> result;
        for (const auto &t : energy_.tetrahedra()) {
            const double k = t.lambda + t.mu;
            result.push_back({.nodes = t.nodes,
                              .compliance = {1.0 / (t.mu * t.volume), 1.0 / (k * t.volume)},
                              .inverse_edges = t.inverse_edges,
                              .rest = 1.0 + t.mu / k});
        }
        return result;
    }

    ElementEnergy<densities::StableNeoHookean> energy_;
    ConstraintSet<NeoHookeanPair> pairs_;
};

} // namespace

/// A neo-Hookean material as constraints.
Method xpbd_neo_hookean() {
    return {.name = {},
            .summary = "extended position-based dynamics: stable neo-Hookean tetrahedra as pairs of constraints",
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
            .in_double = "plain loop over tetrahedra in the order of colours, double",
            .time_step = frame_time,
            .iterations = 10,
            .knows_contact = true,
            .prepare = [](const Scene &scene) { return std::make_unique<XpbdNeoHookean>(scene); }};
}

} // namespace livermark::interactive::methods
