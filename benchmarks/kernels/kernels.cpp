#include "benchmarks/kernels/kernels.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>

#include "benchmarks/kernels/oracle.hpp"
#include "core/mesh/bounding_box.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"

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

/// What a kernel moves.
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
            .bytes = steps->working_set()};
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
        method.forces_per_step = forces_per_step(integrator);
        method.num_threads = options ? options->num_threads : 1;
        method.max_refinements = matter.max_refinements;
        method.critical_time_step = [matter, integrator](const Scene &scene) {
            const double highest = matter.largest_angular_frequency(scene);
            return msm::critical_time_step(msm::find_integrator(integrator), {}, highest, highest);
        };
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

} // namespace

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
    }
    return kernels;
}

} // namespace livermark::benchmarks
