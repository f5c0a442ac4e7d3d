// Time of one step of everything that moves a body, as step/<integrator>/<competitor>/<body>; see README.md.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "benchmarks/harness.hpp"
#include "benchmarks/limits.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/springs/springs.hpp"

namespace livermark::benchmarks {

namespace {

/// Springs with a volume term have a wide spectrum, and 1.2 million take minutes until it is found.
constexpr int max_refinements_with_volume = 1;

/// Rows in single precision round positions to 2^-24 of half the size of the body, against the extension of a spring at
/// the start: 2e-4 on liver_healthy, twice as much with every refinement.
double tolerance_of_single(const Scene &scene) {
    const auto &springs = scene.springs;
    double extension = 0.0;
    for (std::size_t s = 0; s < springs.edges.size(); ++s) {
        const auto [i, j] = springs.edges[s];
        extension += std::abs((scene.start[j] - scene.start[i]).norm() - springs.rest_length[s]);
    }
    extension /= static_cast<double>(springs.edges.size());
    return 0x1p-24 * 0.5 * core::extent(scene.start) / extension;
}

/// Nothing but the order of operations is different.
constexpr double tolerance_of_double = 1e-10;

/// Springs that a kernel moves.
struct Matter {
    std::string suffix; ///< to the name of a kernel
    std::string summary;
    int max_refinements;
    std::function<msm::ElasticBody(const Scene &)> make;
    std::function<double(const Scene &)> largest_angular_frequency;
};

msm::ElasticBody springs_with_nodal_volume(const Scene &scene) {
    const auto &body = *scene.problem.body;
    return msm::springs_with_volume(body, msm::springs_beside_volume(body, msm::all_spring_laws().front()),
                                    msm::find_volume_term("nodal_volume"))
        .body;
}

double frequency_of(const msm::ElasticBody &body, const Scene &scene) {
    return msm::largest_angular_frequency(body, scene.problem.body->mesh.points, scene.conditions);
}

/// The model of that name.
Matter coupled_springs(const std::string &name, std::string summary) {
    const auto make = [name](const Scene &scene) {
        return msm::coupled_springs_with_volume(*scene.problem.body, msm::find_coupled_springs(name));
    };
    return {.suffix = "_" + name,
            .summary = std::move(summary),
            .max_refinements = max_refinements_with_volume,
            .make = make,
            .largest_angular_frequency = [make](const Scene &scene) { return frequency_of(make(scene), scene); }};
}

std::vector<Matter> all_matter() {
    return {
        {.suffix = {},
         .summary = "springs",
         .max_refinements = std::numeric_limits<int>::max(),
         .make = [](const Scene &scene) { return msm::ElasticBody(scene.springs); },
         .largest_angular_frequency = [](const Scene &scene) { return scene.largest_angular_frequency; }},
        {.suffix = "_nodal_volume",
         .summary = "springs, the volume around nodes, and the inversion guard",
         .max_refinements = max_refinements_with_volume,
         .make = springs_with_nodal_volume,
         .largest_angular_frequency =
             [](const Scene &scene) { return frequency_of(springs_with_nodal_volume(scene), scene); }},
        coupled_springs("nodal_springs", "springs coupled around nodes, the volume there, and the inversion guard"),
        coupled_springs("nodal_neo_hookean",
                        "springs coupled around nodes with a neo-Hookean energy, and the volume there"),
        coupled_springs("nodal_neo_hookean_f", "the same with means of the deformation gradient"),
        coupled_springs("edge_neo_hookean",
                        "springs coupled around edges with a neo-Hookean energy, and means of volumes around nodes"),
        coupled_springs("edge_neo_hookean_f", "the same with means of the deformation gradient")};
}

msm::State start_of(const Scene &scene) {
    const Eigen::VectorXd rest = msm::to_unknowns(scene.problem.body->mesh.points);
    return {msm::to_unknowns(scene.start) - rest, Eigen::VectorXd::Zero(rest.size())};
}

std::vector<core::Vector3> positions(const Scene &scene, const msm::State &state) {
    return msm::to_field(msm::to_unknowns(scene.problem.body->mesh.points) + state.displacement);
}

Run run_scalar(const Scene &scene, const msm::ElasticBody &body, const std::string &integrator, double time_step) {
    struct Motion {
        msm::EquationOfMotion equation;
        msm::Step step;
        msm::State state;
    };
    auto motion = std::make_shared<Motion>();
    motion->equation = msm::elastic_motion(body, scene.problem.body->mesh.points, scene.conditions, {});
    motion->step = msm::find_integrator(integrator).prepare(motion->equation, time_step);
    motion->state = start_of(scene);
    return {.step = [motion] { motion->step(motion->state); },
            .positions = [motion, &scene] { return positions(scene, motion->state); }};
}

Run run_fast(const Scene &scene, const msm::ElasticBody &body, const std::string &integrator, double time_step,
             const msm::FastStepOptions &options) {
    auto steps =
        std::make_shared<msm::FastSteps>(msm::FastSteps::prepare(body, scene.problem.body->mesh.points,
                                                                 scene.conditions, {}, integrator, time_step, options)
                                             .value());
    steps->set_state(start_of(scene));
    return {.step = [steps] { steps->take(1); },
            .positions = [steps, &scene] { return positions(scene, steps->state()); },
            .bytes = steps->working_set(),
            .held_steps = options.relaxation.is_elastic() ? 0 : steps->steps_between_relaxations()};
}

/// Longest stable step of such springs [s].
std::function<double(const Scene &)> longest_step(const Matter &matter, const std::string &integrator) {
    return [matter, integrator](const Scene &scene) {
        const double highest = matter.largest_angular_frequency(scene);
        return msm::critical_time_step(msm::find_integrator(integrator), {}, highest, highest);
    };
}

/// @param options  nothing for the slow kernel
Competitor kernel(std::string name, std::string precision, const Matter &matter,
                  const std::optional<msm::FastStepOptions> &options) {
    Competitor competitor{.name = std::move(name),
                          .summary = matter.summary + ", " + std::move(precision),
                          .source = "msm/kernels",
                          .methods = {}};
    for (const auto *integrator : {"runge_kutta_4", "symplectic_euler"}) {
        Method method;
        method.integrator = integrator;
        method.forces_per_step = msm::find_integrator(integrator).forces_per_step;
        method.num_threads = options ? options->num_threads : 1;
        method.max_refinements = matter.max_refinements;
        method.critical_time_step = longest_step(matter, integrator);
        method.make = [matter, integrator, options](const Scene &scene, double time_step) {
            const auto body = matter.make(scene);
            return options ? run_fast(scene, body, integrator, time_step, *options)
                           : run_scalar(scene, body, integrator, time_step);
        };
        const bool is_single = options && options->precision == msm::ForcePrecision::single_precision;
        method.check = [matter, integrator, is_single](const Scene &scene, double time_step, Run &run) {
            const double tolerance = is_single ? tolerance_of_single(scene) : tolerance_of_double;
            return differs_from_oracle(scene, matter.make(scene), integrator, time_step, run, tolerance);
        };
        competitor.methods.push_back(std::move(method));
    }
    return competitor;
}

/// Springs whose stresses fade as in load_cases/relaxation/liver_perfused.toml. They are compared with those in double
/// precision whose branches move in each step.
/// @param error  FastStepOptions::relaxation_error, 0 to move branches in each step
Competitor relaxing_kernel(std::string name, std::string how, const Matter &matter, double error) {
    using enum msm::ForcePrecision;
    const std::string integrator = "symplectic_euler";
    const auto make = [matter, integrator](const Scene &scene, double time_step, msm::ForcePrecision precision,
                                           double relaxation_error) {
        const core::PronySeries series{.name = {}, .moduli = {0.3, 0.3}, .times = {1.86, 51.3}};
        return run_fast(scene, matter.make(scene), integrator, time_step,
                        {.precision = precision, .relaxation = series, .relaxation_error = relaxation_error});
    };
    Method method;
    method.integrator = integrator;
    method.max_refinements = 0;
    method.critical_time_step = longest_step(matter, integrator);
    method.make = [make, error](const Scene &scene, double time_step) {
        return make(scene, time_step, single_precision, error);
    };
    method.check = [make, error](const Scene &scene, double time_step, Run &run) {
        const auto exact = make(scene, time_step, double_precision, 0.0);
        for (int s = 0; s < num_checked_steps; ++s) {
            exact.step();
            run.step();
        }
        return differs_from(exact.positions(), scene, run, error + tolerance_of_single(scene));
    };
    return {.name = std::move(name),
            .summary = matter.summary + ", single precision forces, vectors, stresses that fade, " + std::move(how),
            .source = "msm/kernels",
            .methods = {method}};
}

/// The kernels of msm/, each on springs alone and on springs with the volume around nodes and the inversion guard, on
/// one thread and, the fast ones, on as many as the machine runs at a time; and on one thread springs that relax.
std::vector<Competitor> our_kernels() {
    using enum msm::ForcePrecision;
    const int num_cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    std::vector<Competitor> kernels;
    for (const auto &matter : all_matter()) {
        const auto add = [&](const std::string &name, const std::string &precision,
                             const std::optional<msm::FastStepOptions> &options) {
            kernels.push_back(kernel(name + matter.suffix, precision, matter, options));
        };
        add("scalar", "double precision, one after the other", std::nullopt);
        add("simd_double", "double precision, vectors", msm::FastStepOptions{double_precision, 1});
        add("simd_float", "single precision forces, vectors", msm::FastStepOptions{single_precision, 1});
        if (num_cores > 1)
            add("simd_float_all_threads", "single precision forces, vectors and threads",
                msm::FastStepOptions{single_precision, num_cores});
        const auto name = "simd_float" + matter.suffix + "_relaxing";
        kernels.push_back(
            relaxing_kernel(name, "branches that are held", matter, msm::FastStepOptions{}.relaxation_error));
        kernels.push_back(relaxing_kernel(name + "_each_step", "branches that move in each step", matter, 0.0));
    }
    return kernels;
}

/// Step where every one is stable: the interval of the load case `release` [s].
constexpr double step_of_implicit = 0.004;

/// Memory that is touched for the first time makes the first steps slow.
constexpr int num_warm_up_steps = 3;

/// A scene, and the least time that one evaluation of its spring forces can take here, per spring [s].
struct Stage {
    Scene scene;
    double limit = 0.0;
};

/// Makes nothing twice that takes seconds: Google Benchmark calls a benchmark several times to find out how long it
/// takes, and asks for all competitors of a body one after the other.
const Stage &stage_of(const std::string &body) {
    static std::optional<Stage> stage;
    if (!stage || stage->scene.problem.body->name != body) {
        stage = Stage{.scene = make_scene(make_body(body))};
        const auto &scene = stage->scene;
        const auto num_nodes = static_cast<int>(scene.start.size());
        stage->limit = spring_limit(neighbours(scene.springs.edges, num_nodes)).longest();
    }
    return *stage;
}

/// A run that has been checked.
struct Checked {
    std::string name;
    double time_step = 0.0; ///< [s]
    Run run;
    std::string fault; ///< what is wrong with its steps, empty if nothing is
};

Checked check(const std::string &name, const Method &method, const Scene &scene) {
    const double critical = method.critical_time_step(scene);
    Checked checked{.name = name, .run = {}, .fault = {}};
    checked.time_step = std::isfinite(critical) ? msm::default_safety_factor * critical : step_of_implicit;
    checked.run = method.make(scene, checked.time_step);
    checked.fault = method.check(scene, checked.time_step, checked.run);
    for (int s = 0; s < num_warm_up_steps; ++s)
        checked.run.step();
    return checked;
}

void time_steps(benchmark::State &state, const std::string &name, const Method &method, const std::string &body) {
    static std::optional<Checked> last;
    const auto &[scene, limit] = stage_of(body);
    if (!last || last->name != name) {
        last.reset(); // frees the memory of the one before first
        last = check(name, method, scene);
    }
    if (!last->fault.empty()) {
        state.SkipWithError(last->fault.c_str());
        return;
    }
    for (auto _ : state)
        last->run.step();
    // Kept: after a first repetition that fails, Google Benchmark 1.7 crashes if others do not.
    last->fault = has_left(scene, last->run);
    if (!last->fault.empty()) {
        state.SkipWithError(last->fault.c_str());
        return;
    }

    using benchmark::Counter;
    const auto num_springs = static_cast<double>(scene.springs.edges.size());
    const double forces = method.forces_per_step;
    state.counters["springs"] = num_springs;
    state.counters["time_per_spring"] =
        Counter(num_springs * forces, Counter::kIsIterationInvariantRate | Counter::kInvert);
    state.counters["of_limit"] = Counter(limit * num_springs * forces, Counter::kIsIterationInvariantRate);
    if (last->run.bytes > 0)
        state.counters["bytes_per_spring"] = static_cast<double>(last->run.bytes) / num_springs;
    if (last->run.held_steps > 0)
        state.counters["held_steps"] = last->run.held_steps;
    state.counters["steps_per_second"] = Counter(1.0, Counter::kIsIterationInvariantRate);
    state.counters["time_step"] = last->time_step;
    state.counters["real_time_factor"] = Counter(last->time_step, Counter::kIsIterationInvariantRate);
}

/// One competitor on one body. Bodies are the outer loop, so that each is made once.
void add(const Competitor &competitor, const std::string &body) {
    for (const auto &method : competitor.methods) {
        if (num_refinements(body) > method.max_refinements)
            continue;
        const auto name = fmt::format("step/{}/{}/{}", method.integrator, competitor.name, body);
        auto *added = benchmark::RegisterBenchmark(
            name.c_str(), [name, method, body](benchmark::State &state) { time_steps(state, name, method, body); });
        if (method.num_threads > 1)
            added->UseRealTime(); // the processor time of one thread says nothing
        added->Unit(benchmark::kMicrosecond);
    }
}

void register_all() {
    const auto kernels = our_kernels();
    for (const auto &body : body_names()) {
        for (const auto &kernel : kernels)
            add(kernel, body);
        for (const auto &peer : all_peers())
            add(peer, body);
    }
}

} // namespace
} // namespace livermark::benchmarks

int main(int argc, char **argv) {
    return livermark::benchmarks::run_program(argc, argv, livermark::benchmarks::register_all);
}
