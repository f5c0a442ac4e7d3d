#pragma once

#include <cmath>

#include "core/problem.hpp"
#include "core/tool/touching_tool.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

/// A column that a rigid flat presses and shears by Coulomb friction, with a closed form in finite strains: its sides
/// are held where they are in
///     u = (gamma z, 0, -eps z),
/// so that it deforms like that everywhere. Of a neo-Hookean material, the traction on the top at rest is
///     tau = mu gamma,   p = mu (1 / (1 - eps) - (1 - eps)) - lambda ln(1 - eps) / (1 - eps).
/// It sticks where tau < f p, and slips with tau = f p where the flat goes further. The flat is a ball of so large a
/// radius that it is 1.3e-7 m higher at its rim, where penalties let it in by a hundred times that.
class SimpleShear {
  public:
    static constexpr double width = 0.004, height = 0.02; ///< [m]
    static constexpr double young_modulus = 5e3, poisson_ratio = 0.3, friction = 0.3, strain = 0.1;
    static constexpr double ball_radius = 30.0; ///< [m]

    /// @param part_of_slip  tau over f p
    explicit SimpleShear(double part_of_slip) : shear_(part_of_slip * friction * pressure() / shear_modulus()) {}

    static double shear_modulus() { return 0.5 * young_modulus / (1.0 + poisson_ratio); }
    static double modulus() { return lambda() + 2.0 * shear_modulus(); } ///< of compression between held sides [Pa]
    static double pressure() {
        const double left = 1.0 - strain;
        return shear_modulus() * (1.0 / left - left) - lambda() * std::log(left) / left;
    }
    double normal_force() const { return width * width * pressure(); }              ///< [N]
    double shear_force() const { return width * width * shear_modulus() * shear_; } ///< [N]

    core::Vector3 displacement(const core::Vector3 &x) const { return {shear_ * x.z(), 0.0, -strain * x.z()}; }
    /// At the bottom and the sides.
    bool is_held(const core::Vector3 &x) const {
        constexpr double rounding = 1e-9;
        const auto at_side = [](double way) { return way < rounding || way > width - rounding; };
        return x.z() < rounding || at_side(x.x()) || at_side(x.y());
    }

    /// @param bricks   with one of them along z, sides are held as the closed form has it; else they have to be
    /// @param law      with the penalties that the contact has
    /// @param beyond   the way of the flat along the top over that which the closed form needs
    core::Problem problem(const std::array<int, 3> &bricks, const core::ContactLaw &law, double beyond) const {
        const auto body = make_body(box_mesh({width, width, height}, bricks), {1060.0, young_modulus, poisson_ratio});
        auto load_case = empty_load_case(body->mesh);
        load_case.name = "sheared_column";
        load_case.regime = core::Regime::large;
        load_case.path = {0.5, 1.0};
        prescribe(load_case, body->mesh, "z_min", core::Vector3::Zero()); // first: it has the nodes below the sides
        for (const auto *patch : {"x_min", "x_max", "y_min", "y_max"})
            prescribe(load_case, body->mesh, patch, displacement({0.0, 0.0, height}));
        const double along = beyond * (shear_ * height + shear_modulus() * shear_ / law.tangential_penalty);
        load_case.touching = core::TouchingTool{.shape = ball_radius,
                                                .start = {0.5 * width, 0.5 * width, height + ball_radius},
                                                .press = {along, 0.0, -(strain * height + pressure() / law.penalty)},
                                                .friction = friction,
                                                .constraint = load_case.num_constraints()};
        load_case.conditions.push_back({"touch", core::ConditionKind::touch});
        return {body, load_case};
    }

  private:
    static double lambda() {
        return young_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
    }

    double shear_; ///< gamma
};

} // namespace livermark::tests
