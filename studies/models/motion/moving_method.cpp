#include "studies/models/motion/moving_method.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "fem_reference/hyperelastic/motion.hpp"
#include "interactive/method.hpp"
#include "msm/dynamics/spring_stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/springs.hpp"

namespace livermark::models {

namespace {

using livermark::msm::ElasticBody;

/// Texts of a method with scaled masses beside those of the same without them.
constexpr const char *scaled_name = "_mass_scaled",
                     *scaled_source = "; Olovsson, Simonsson, Unosson 2005, IJNME 63(10)",
                     *scaled_implementation = ", stiff parts heavier against deformation",
                     *scaled_limit = "; in motion, that of a body whose stiff parts are heavier";

void make_scaled(MovingMethod &method) {
    method.is_scaled = true;
    method.name += scaled_name;
    method.source += scaled_source;
    method.implementation += scaled_implementation;
    method.converges_to += scaled_limit;
}

const livermark::msm::SpringLaw &spring_law(const char *name) {
    return support::find_named(livermark::msm::all_spring_laws(), name, "spring law");
}

ElasticBody lloyd(const core::Body &body) {
    return livermark::msm::spring_network(body, spring_law("lloyd"));
}

ElasticBody patch_with_volume(const core::Body &body) {
    const auto &law = spring_law("patch");
    return livermark::msm::springs_with_volume(body, livermark::msm::springs_beside_volume(body, law),
                                               livermark::msm::find_volume_term("nodal_volume"))
        .body;
}

std::optional<livermark::msm::SpringSource> source_of_lloyd(const core::Body &body) {
    return livermark::msm::SpringSource{spring_law("lloyd"), body};
}

std::optional<livermark::msm::SpringSource> source_of_patch(const core::Body &body) {
    return livermark::msm::SpringSource{spring_law("patch"), livermark::msm::for_springs_beside_volume(body)};
}

std::optional<livermark::msm::SpringSource> no_source(const core::Body & /*body*/) {
    return std::nullopt;
}

ElasticBody coupled_springs(const core::Body &body, const char *name) {
    return livermark::msm::coupled_springs_with_volume(body, livermark::msm::find_coupled_springs(name));
}

ElasticBody nodal_springs(const core::Body &body) {
    return coupled_springs(body, "nodal_springs");
}

ElasticBody nodal_neo_hookean(const core::Body &body) {
    return coupled_springs(body, "nodal_neo_hookean");
}

ElasticBody nodal_neo_hookean_f(const core::Body &body) {
    return coupled_springs(body, "nodal_neo_hookean_f");
}

ElasticBody edge_neo_hookean(const core::Body &body) {
    return coupled_springs(body, "edge_neo_hookean");
}

ElasticBody edge_neo_hookean_f(const core::Body &body) {
    return coupled_springs(body, "edge_neo_hookean_f");
}

} // namespace

std::span<const MovingSpringModel> moving_spring_models() {
    static const std::vector<MovingSpringModel> models{
        {"lloyd", "Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5)",
         "Springs alone have Poisson's ratio 1/4, so they cannot be nearly incompressible tissue (Golec et al. 2020, "
         "Hybrid 3D mass-spring system, The Visual Computer 36): 'livermark run --load-case pneumoperitoneum --model "
         "lloyd fem_p2 --poisson 0.25 0.45' shows it.",
         lloyd, source_of_lloyd},
        {"patch_nodal_volume", "Livermark",
         "Those who calibrate springs fit each body and load anew; here one fit to affine strains serves all loads, "
         "and hard parts need short steps.",
         patch_with_volume, source_of_patch, true},
        {"nodal_springs", "Livermark",
         "Forces act between springs around a node, so it is no network of two-node springs; nothing keeps tetrahedra "
         "from turning inside out.",
         nodal_springs, no_source, true},
        {"nodal_neo_hookean", "Livermark",
         "It is a nodally averaged finite element (Puso, Solberg 2006, IJNME 67) with another name, and its constant a "
         "was chosen on the livers that ship.",
         nodal_neo_hookean, no_source, true},
        {"nodal_neo_hookean_f", "Livermark",
         "It is a nodally averaged finite element (Puso, Solberg 2006, IJNME 67) with another name, and its constant a "
         "was chosen on the livers that ship.",
         nodal_neo_hookean_f, no_source, true},
        {"edge_neo_hookean", "Livermark",
         "It is an edge-based smoothed finite element with another name, and was not tuned for speed as those around "
         "nodes were.",
         edge_neo_hookean, no_source, false, true},
        {"edge_neo_hookean_f", "Livermark",
         "It is an edge-based smoothed finite element with another name, and was not tuned for speed as those around "
         "nodes were.",
         edge_neo_hookean_f, no_source, false, true}};
    return models;
}

namespace {

/// Parameters as of MovingMethod::prepare.
std::unique_ptr<core::Stepper> spring_stepper(const MovingSpringModel &model, const core::NodalProblem &problem,
                                              const core::NodalConditions &once_released,
                                              const StepperOptions &options) {
    namespace msm = livermark::msm;
    const auto &body = *problem.body;
    const auto springs = msm::with_vessel_lines(model.make(body), body);
    msm::MassScaling scaling;
    if (options.scales_masses)
        scaling = msm::scale_masses(body, springs, once_released);
    const auto highest_frequency = [&](const core::NodalConditions &conditions) {
        return msm::largest_angular_frequency(springs, body.mesh.points, conditions,
                                              msm::constrained(scaling, conditions));
    };
    // One step for the whole motion: what is held less has the higher frequencies, but where held nodes leave a scaled
    // part.
    double highest = highest_frequency(once_released);
    if (!scaling.parts.empty())
        highest = std::max(highest, highest_frequency(problem.conditions));
    msm::MovingSprings moving{.springs = springs,
                              .damping = {.alpha = options.mass_damping, .beta = 0.0},
                              .options = {.scaling = std::move(scaling), .may_be_cut = options.may_be_cut},
                              .critical_time_step = 2.0 / highest};
    if (options.may_be_cut)
        moving.source = model.spring_source(body);
    return std::make_unique<msm::SpringStepper>(problem.body, std::move(moving), problem.conditions);
}

void add_springs(std::vector<MovingMethod> &methods) {
    for (const auto &model : moving_spring_models()) {
        methods.push_back(
            {.name = model.name,
             .source = model.source,
             .implementation = "vector units, single precision with a state of twice the digits",
             .converges_to = "the motion of its springs as h goes to 0; at rest the equilibrium of their energy",
             .objection = model.objection,
             .prepare =
                 [&model](const NodalProblem &problem, const msm::NodalConditions &once_released,
                          const StepperOptions &options) {
                     return spring_stepper(model, problem, once_released, options);
                 },
             .only_when_named = model.only_when_named,
             .knows_contact = true});
        if (model.is_scaled) {
            methods.push_back(methods.back());
            make_scaled(methods.back());
        }
    }
}

void add_interactive(std::vector<MovingMethod> &methods) {
    for (const auto &method : livermark::interactive::all_methods()) {
        methods.push_back({.name = method.name,
                           .source = method.source,
                           .implementation = method.implementation,
                           .converges_to = method.converges_to,
                           .objection = method.objection,
                           .prepare =
                               [&method](const NodalProblem &problem, const msm::NodalConditions &once_released,
                                         const StepperOptions &options) {
                                   return method_stepper(method, problem, once_released, options);
                               },
                           .knows_contact = method.knows_contact});
        // On the liver with tumours quadratic elements with scaled masses diverge, and it is not known why.
        if (method.is_explicit && method.name != "tled_quadratic") {
            methods.push_back(methods.back());
            make_scaled(methods.back());
        }
    }
}

} // namespace

const char *to_string(Setting setting) {
    if (setting == Setting::one_step)
        return "one step";
    return setting == Setting::ten_iterations ? "ten iterations" : "one iteration";
}

std::unique_ptr<FrameBody> MovingMethod::under_tool(const core::Problem &problem) const {
    const auto &motion = problem.load_case.tool.value();
    NodalProblem at_rest{problem.body, msm::lumped_masses(*problem.body), {}};
    auto place = tool_place(problem, at_rest.node_mass);
    at_rest.conditions = place.while_held;
    auto body = std::make_unique<FrameBody>(
        prepare(at_rest, place.let_go, {.mass_damping = motion.mass_damping, .scales_masses = is_scaled}),
        motion.frame_interval);
    body->take_tool(std::move(place), problem);
    return body;
}

std::unique_ptr<FrameBody> MovingMethod::with_needle(const core::Problem &problem, const core::Needle &needle,
                                                     const NeedlePlan &plan) const {
    const auto at_rest = on_nodes(problem);
    auto body = std::make_unique<FrameBody>(prepare(at_rest, at_rest.conditions, {.mass_damping = plan.mass_damping}),
                                            plan.frame_interval);
    body->take_needle(needle, problem.body->mesh);
    return body;
}

std::unique_ptr<FrameBody> MovingMethod::under_blade(const NodalProblem &problem,
                                                     const FramesUnderBlade &frames) const {
    return std::make_unique<FrameBody>(
        prepare(problem, problem.conditions, {.mass_damping = frames.mass_damping, .may_be_cut = true}),
        frames.interval);
}

std::vector<MovingMethod> all_moving_methods() {
    std::vector<MovingMethod> methods;
    add_springs(methods);
    add_interactive(methods);
    return methods;
}

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
