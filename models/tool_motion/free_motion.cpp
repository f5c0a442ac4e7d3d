#include "models/tool_motion/free_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/mesh/bounding_box.hpp"
#include "core/stopwatch.hpp"
#include "interactive/method.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/mass_lumping.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::models {

namespace {

using livermark::interactive::Field;

constexpr double farthest = 10.0; ///< times the size of the body; what is further away is lost

Field field_of(const std::vector<core::Vector3> &vectors) {
    Field field(3, static_cast<Eigen::Index>(vectors.size()));
    for (std::size_t i = 0; i < vectors.size(); ++i)
        field.col(static_cast<Eigen::Index>(i)) = vectors[i];
    return field;
}

} // namespace

bool has_free_motion(std::string_view name) {
    return name != "tled_quadratic" && std::ranges::any_of(livermark::interactive::all_methods(),
                                                           [&](const auto &method) { return method.name == name; });
}

core::History free_motion(std::string_view name, const core::Problem &problem,
                          const std::vector<core::Vector3> &displacement) {
    const auto start = core::Clock::now();
    const auto &method = livermark::interactive::find_method(name);
    const auto &release = problem.load_case.release.value();
    const auto &points = problem.body->mesh.points;
    livermark::interactive::Scene scene{.body = problem.body,
                                        .node_mass = livermark::msm::lumped_masses(*problem.body),
                                        .constrained_nodes = {},
                                        .mass_damping = release.damping.alpha};
    const auto conditions =
        livermark::msm::nodal_conditions({problem.body, core::without_tractions(problem.load_case)}, scene.node_mass);
    auto positions = points;
    std::vector<core::Vector3> targets;
    for (std::size_t i = 0; i < points.size(); ++i) {
        positions[i] += displacement[i];
        if (conditions.displacement[i].array().isNaN().any())
            continue;
        scene.constrained_nodes.push_back(static_cast<int>(i));
        targets.emplace_back(points[i] + conditions.displacement[i]);
    }
    const auto simulation = method.prepare(scene);
    simulation->set_external_forces(field_of(conditions.force));
    simulation->set_targets(field_of(targets));
    simulation->set_state(field_of(positions), Field::Zero(3, static_cast<Eigen::Index>(points.size())));
    const double step = release.output_interval;
    int iterations = method.iterations;
    core::History history;
    history.integrator = method.name;
    history.critical_time_step = simulation->critical_time_step();
    if (method.is_explicit)
        iterations =
            static_cast<int>(std::ceil(step / (livermark::msm::default_safety_factor * history.critical_time_step)));
    history.time_step = method.is_explicit ? step / iterations : step;
    simulation->prepare(step);
    history.setup_seconds = core::seconds_since(start);
    const auto motion = core::Clock::now();
    const double bound = farthest * core::extent(points);
    for (int record = 0; record <= release.num_steps; ++record) {
        if (record > 0 && std::isnan(history.diverged_at)) {
            simulation->step(step, iterations);
            const double far = (simulation->positions().leftCols(static_cast<Eigen::Index>(points.size()))).norm();
            if (!(far < bound * std::sqrt(static_cast<double>(points.size()))))
                history.diverged_at = record * step;
        }
        history.time.push_back(record * step);
        for (const auto &probe : release.probes)
            history.displacement.emplace_back(
                std::isnan(history.diverged_at)
                    ? core::Vector3(simulation->positions().col(probe.node) - points[probe.node])
                    : core::Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    }
    history.solve_seconds = core::seconds_since(motion);
    return history;
}

} // namespace livermark::models
