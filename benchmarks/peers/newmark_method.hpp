#pragma once

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "benchmarks/harness.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/dynamics/release.hpp"
#include "fem_reference/linear/conditions.hpp"

namespace livermark::benchmarks {

/// A scene in steps of fem_reference::Newmark.
struct NewmarkRun {
    NewmarkRun(const Scene &scene, int degree, double time_step)
        : rest(scene.problem.body->mesh.points), h(time_step),
          system(fem_reference::assemble(*scene.problem.body, degree)),
          mass(fem_reference::consistent_mass(*scene.problem.body, system)),
          prescribed(fem_reference::dof_conditions(scene.problem.load_case, system).prescribed),
          no_load(prescribed.size(), 0.0), motion{no_load, no_load},
          newmark(system.stiffness, mass, {}, time_step, prescribed) {
        const double stretch = scene.start.back().x() / rest.back().x() - 1.0;
        for (int i = 0; i < system.num_nodes(); ++i)
            motion.displacement[3 * static_cast<std::size_t>(i)] = stretch * system.points[i].x();
    }

    std::vector<core::Vector3> positions() const {
        auto positions = rest; // the first nodes are those of the mesh
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i] += core::Vector3::Map(&motion.displacement[3 * i]);
        return positions;
    }

    /// Residual of M (v_1 - v_0) / h + K (u_0 + u_1) / 2 = 0 and (v_0 + v_1) / 2 = (u_1 - u_0) / h.
    double residual() {
        const auto before = motion;
        auto after = motion;
        newmark.advance(after, no_load);
        const std::size_t size = no_load.size();
        std::vector<double> change(size), mean(size), inertia(size), force(size);
        double kinematic = 0.0, largest_motion = 0.0;
        for (std::size_t i = 0; i < size; ++i) {
            change[i] = (after.velocity[i] - before.velocity[i]) / h;
            mean[i] = 0.5 * (before.displacement[i] + after.displacement[i]);
            const double moved = after.displacement[i] - before.displacement[i];
            largest_motion = std::max(largest_motion, std::abs(moved));
            kinematic = std::max(kinematic, std::abs(moved - 0.5 * h * (before.velocity[i] + after.velocity[i])));
        }
        fem_reference::multiply_mass(mass, change, inertia);
        system.stiffness.multiply(mean, force);
        double largest = 0.0, imbalance = 0.0;
        for (std::size_t i = 0; i < size; ++i)
            if (std::isnan(prescribed[i])) {
                largest = std::max(largest, std::abs(force[i]));
                imbalance = std::max(imbalance, std::abs(inertia[i] + force[i]));
            }
        return std::max(imbalance / largest, kinematic / largest_motion);
    }

    std::vector<core::Vector3> rest;
    double h; ///< [s]
    fem_reference::ElasticSystem system;
    fem_reference::SymmetricMatrix mass;
    std::vector<double> prescribed; ///< NaN where free
    std::vector<double> no_load;
    fem_reference::Motion motion;
    fem_reference::Newmark newmark;
};

/// Newmark's average acceleration of linear elasticity with a factor that is kept, of the scene's body; the springs do
/// not matter.
/// @param degree  of the elements, 1 or 2
inline Method newmark_method(int degree, int max_refinements) {
    Method method;
    method.integrator = "newmark";
    method.critical_time_step = [](const Scene &) { return std::numeric_limits<double>::infinity(); };
    method.make = [degree](const Scene &scene, double time_step) {
        const auto body = std::make_shared<NewmarkRun>(scene, degree, time_step);
        return Run{.step = [body] { body->newmark.advance(body->motion, body->no_load); },
                   .positions = [body] { return body->positions(); },
                   .residual = [body] { return body->residual(); }};
    };
    method.check = [](const Scene &, double, Run &run) -> std::string {
        constexpr double tolerance = 1e-9; // rounding of a residual that was solved for by sparse Cholesky
        run.step();                        // with a velocity, so that every term counts
        if (const double residual = run.residual(); !(residual < tolerance))
            return fmt::format("the residual of a step is {:.3g}, and {:.3g} is allowed", residual, tolerance);
        return {};
    };
    method.max_refinements = max_refinements;
    return method;
}

} // namespace livermark::benchmarks
