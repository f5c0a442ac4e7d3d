#include "benchmarks/competitor.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/integrator.hpp"

namespace livermark::benchmarks {

std::string differs_from_oracle(const Scene &scene, const msm::ElasticBody &body, const std::string &integrator,
                                double time_step, Run &run, double tolerance) {
    const auto &rest = scene.problem.body->mesh.points;
    const auto equation = msm::elastic_motion(body, rest, scene.conditions, {});
    const auto step = msm::find_integrator(integrator).prepare(equation, time_step);
    const Eigen::VectorXd at_rest = msm::to_unknowns(rest);
    msm::State state{msm::to_unknowns(scene.start) - at_rest, Eigen::VectorXd::Zero(at_rest.size())};
    for (int s = 0; s < num_checked_steps; ++s) {
        step(state);
        run.step();
    }
    return differs_from(msm::to_field(at_rest + state.displacement), scene, run, tolerance);
}

std::string differs_from(const std::vector<core::Vector3> &wanted, const Scene &scene, const Run &run,
                         double tolerance) {
    const auto positions = run.positions();
    double largest_motion = 0.0, largest_error = 0.0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const double error = (positions[i] - wanted[i]).norm();
        if (!std::isfinite(error))
            return fmt::format("node {} is nowhere", i);
        largest_motion = std::max(largest_motion, (wanted[i] - scene.start[i]).norm());
        largest_error = std::max(largest_error, error);
    }
    if (largest_error <= tolerance * largest_motion && largest_motion > 0.0)
        return {};
    return fmt::format("a node is {:.3g} of the largest motion from where it should be, and {:.3g} is allowed",
                       largest_error / largest_motion, tolerance);
}

std::string has_left(const Scene &scene, const Run &run) {
    const auto positions = run.positions();
    const double bound = core::extent(scene.start);
    for (std::size_t i = 0; i < positions.size(); ++i)
        if (const double motion = (positions[i] - scene.start[i]).norm(); !(motion < bound))
            return fmt::format("node {} has gone {:.3g} m", i, motion);
    return {};
}

Method spring_method(const std::string &integrator, std::function<Run(const Scene &, double)> make, double tolerance) {
    Method method;
    method.integrator = integrator;
    method.forces_per_step = msm::find_integrator(integrator).forces_per_step;
    method.critical_time_step = [integrator](const Scene &scene) { return critical_time_step(scene, integrator); };
    method.make = std::move(make);
    method.check = [integrator, tolerance](const Scene &scene, double time_step, Run &run) {
        return differs_from_oracle(scene, scene.springs, integrator, time_step, run, tolerance);
    };
    return method;
}

} // namespace livermark::benchmarks
