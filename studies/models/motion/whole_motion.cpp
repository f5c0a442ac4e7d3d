#include "studies/models/motion/whole_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/stopwatch.hpp"
#include "fem_reference/hyperelastic/motion.hpp"
#include "interactive/method.hpp"
#include "studies/models/motion/moving_method.hpp"

namespace livermark::models {

namespace {

constexpr double farthest = 10.0; ///< times the size of the body; what is further away is lost

/// Root mean square of the distances of all nodes from where they are at rest [m]; NaN where it is lost.
double mean_motion(const std::vector<core::Vector3> &displacement) {
    double sum = 0.0;
    for (const auto &u : displacement)
        sum += u.squaredNorm();
    return std::sqrt(sum / static_cast<double>(displacement.size()));
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
    const auto let_go = on_nodes({problem.body, core::without_tractions(problem.load_case)});
    const auto stepper = method_stepper(method, let_go, let_go.conditions, {.mass_damping = release.damping.alpha});
    stepper->start_from(displacement);
    const double step = release.output_interval;
    const auto least = least_effort(*stepper, step);
    const int iterations = least ? least->iterations : method.iterations;
    core::History history;
    history.integrator = method.name;
    history.critical_time_step = stepper->critical_time_step();
    history.time_step = least ? step / iterations : step;
    stepper->prepare(step);
    history.setup_seconds = core::seconds_since(start);
    const auto motion = core::Clock::now();
    const double bound = farthest * core::extent(problem.body->mesh.points);
    for (int record = 0; record <= release.num_steps; ++record) {
        if (record > 0 && std::isnan(history.diverged_at)) {
            stepper->step(step, iterations);
            if (!(mean_motion(stepper->displacement()) < bound))
                history.diverged_at = record * step;
        }
        history.time.push_back(record * step);
        for (const auto &probe : release.probes) {
            auto &found =
                history.displacement.emplace_back(core::Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
            if (std::isnan(history.diverged_at))
                stepper->displacements(std::span(&probe.node, 1), std::span(&found, 1));
        }
    }
    history.solve_seconds = core::seconds_since(motion);
    return history;
}

core::ToolHistory reference_motion(const core::Problem &problem, int level, int steps_per_frame) {
    const auto refined = core::refine_at_rims(problem, level);
    auto history = hyperelastic::move_tool(refined, hyperelastic::material_law("neo_hookean"), 2, steps_per_frame);
    const auto num_nodes = static_cast<std::ptrdiff_t>(problem.body->mesh.points.size());
    const auto num_refined = static_cast<std::ptrdiff_t>(refined.body->mesh.points.size());
    std::vector<Eigen::Vector3f> on_mesh; // whose nodes come first
    for (auto field = history.displacement.begin(); field != history.displacement.end(); field += num_refined)
        on_mesh.insert(on_mesh.end(), field, field + num_nodes);
    history.displacement = std::move(on_mesh);
    return history;
}

} // namespace livermark::models
