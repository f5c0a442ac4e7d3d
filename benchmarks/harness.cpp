#include "benchmarks/harness.hpp"

#include <algorithm>
#include <array>
#include <benchmark/benchmark.h>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string_view>

#include "benchmarks/limits.hpp"
#include "core/mesh/refinement.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/springs/springs.hpp"
#include "results/one_reference.hpp"
#include "results/records/result.hpp"
#include "results/records/timings.hpp"

namespace livermark::benchmarks {

namespace {

/// Lets the reporter of --benchmark_format print, and keeps what it is told.
class Collector : public benchmark::BenchmarkReporter {
  public:
    Collector() : printer_(benchmark::CreateDefaultDisplayReporter()) {}

    bool ReportContext(const Context &context) override { return printer_->ReportContext(context); }

    void ReportRuns(const std::vector<Run> &runs) override {
        printer_->ReportRuns(runs);
        for (const auto &run : runs)
            if (run.error_occurred)
                has_failed = true;
            else if (run.run_type == Run::RT_Iteration)
                keep(run);
    }

    void Finalize() override { printer_->Finalize(); }

    /// The medians of the repetitions.
    std::vector<results::Timing> timings() const {
        auto timings = timings_;
        for (auto &timing : timings)
            for (const auto &[name, values] : counters_.at(timing.name))
                timing.counters[name] = results::median(values);
        return timings;
    }

    bool has_failed = false;

  private:
    void keep(const Run &run) {
        const auto &name = run.run_name.function_name;
        if (timings_.empty() || timings_.back().name != name)
            timings_.push_back({.name = name, .seconds = {}, .counters = {}});
        auto &timing = timings_.back();
        timing.is_wall_clock = !run.run_name.time_type.empty();
        timing.iterations = run.iterations;
        timing.seconds.push_back((timing.is_wall_clock ? run.real_accumulated_time : run.cpu_accumulated_time) /
                                 static_cast<double>(run.iterations));
        for (const auto &[counter, value] : run.counters)
            counters_[name][counter].push_back(value.value);
        counters_.try_emplace(name);
    }

    std::unique_ptr<benchmark::BenchmarkReporter> printer_;
    std::vector<results::Timing> timings_;
    std::map<std::string, std::map<std::string, std::vector<double>>> counters_;
};

/// Takes --hdf5=FILE out of the arguments, which Google Benchmark does not know.
std::optional<std::filesystem::path> take_hdf5(int &argc, char **argv) {
    constexpr std::string_view option = "--hdf5=";
    for (int i = 1; i < argc; ++i)
        if (const std::string_view argument = argv[i]; argument.starts_with(option)) {
            const auto path = std::filesystem::absolute(argument.substr(option.size()));
            if (path.filename().empty() || !std::filesystem::is_directory(path.parent_path()))
                throw support::InputError(fmt::format("{}: name a file in a folder that exists", argument));
            std::copy(argv + i + 1, argv + argc, argv + i);
            --argc;
            return path;
        }
    return std::nullopt;
}

void add_context(const results::Provenance &provenance) {
    benchmark::AddCustomContext("livermark", provenance.software_version);
    benchmark::AddCustomContext("git_commit", provenance.git_commit);
    benchmark::AddCustomContext("cpu", provenance.cpu);
    benchmark::AddCustomContext("compiler", provenance.compiler);
    benchmark::AddCustomContext("build_type", provenance.build_type);
}

void print_help() {
    benchmark::PrintDefaultHelp();
    fmt::print("          [--hdf5=<file>]\n");
}

/// Google Benchmark asks for the help, and ends with 0, where one of its flags has none of the values to choose from.
void refuse_value() {
    throw support::InputError(
        "--benchmark_format, --benchmark_out_format, --benchmark_color or --benchmark_time_unit has a "
        "value that it does not take; --help names those that it does");
}

/// Takes the flags of Google Benchmark out of the arguments.
void initialize(int argc, char **argv) {
    const auto arguments = std::span(argv, argc).subspan(1);
    const bool is_help = std::ranges::find(arguments, std::string_view("--help")) != arguments.end();
    benchmark::Initialize(&argc, argv, is_help ? print_help : refuse_value);
    if (argc > 1)
        throw support::InputError(
            fmt::format("'{}' is no flag, or has a value that it does not take; --help names all flags", argv[1]));
}

int run(int argc, char **argv, const std::function<void()> &register_all) {
    const auto provenance = results::current_provenance(fmt::format("{}", fmt::join(std::span(argv, argc), " ")));
    const auto hdf5 = take_hdf5(argc, argv);
    register_all();
    initialize(argc, argv);
    add_context(provenance);
    Collector collector;
    if (benchmark::RunSpecifiedBenchmarks(&collector) == 0)
        throw support::InputError("no benchmark matches; --benchmark_list_tests names all");
    const auto timings = collector.timings();
    if (hdf5 && timings.empty() && !collector.has_failed)
        throw support::InputError("--hdf5 keeps single times, and there are none; leave --benchmark_list_tests, "
                                  "--benchmark_report_aggregates_only and --benchmark_display_aggregates_only out");
    if (hdf5)
        results::write_timings(*hdf5, {.provenance = provenance, .timings = timings});
    return collector.has_failed ? 1 : 0;
}

} // namespace

int run_program(int argc, char **argv, const std::function<void()> &register_all) {
    try {
        return run(argc, argv, register_all);
    } catch (const support::InputError &error) {
        fmt::print(stderr, "{}: {}\n", argv[0], error.what());
        return 2;
    } catch (const std::exception &error) {
        fmt::print(stderr, "{}: {}\n", argv[0], error.what());
        return 1;
    }
}

namespace {

struct Recipe {
    std::string file; ///< stem of the .toml
    int num_refinements;
};

const std::array<std::string, 4> names{"liver_healthy", "liver_tumours", "liver_refined_once", "liver_refined_twice"};
const std::array<Recipe, names.size()> recipes{
    {{"liver_healthy", 0}, {"liver_tumours", 0}, {"liver_healthy", 1}, {"liver_healthy", 2}}};

const Recipe &find_recipe(const std::string &name) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end())
        throw support::InputError(
            fmt::format("there is no body {} for benchmarks; take {}", name, fmt::join(names, ", ")));
    return recipes[found - names.begin()];
}

/// The same body with its nodes in another order.
/// @param order  shape (N), the old number of each new node
core::Body renumbered(core::Body body, std::span<const int> order) {
    auto &mesh = body.mesh;
    std::vector<int> number(order.size());
    std::vector<core::Vector3> points(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        number[order[i]] = static_cast<int>(i);
        points[i] = mesh.points[order[i]];
    }
    mesh.points = std::move(points);
    for (auto &tetrahedron : mesh.tetrahedra)
        for (auto &node : tetrahedron)
            node = number[node];
    for (auto &triangle : mesh.boundary_triangles)
        for (auto &node : triangle)
            node = number[node];
    return body;
}

core::LoadCase constrained_at_back(const core::Body &body) {
    const auto &mesh = body.mesh;
    const auto patch = std::ranges::find(mesh.patch_names, "posterior");
    if (patch == mesh.patch_names.end())
        throw support::InputError(fmt::format("{} has no patch 'posterior' to constrain", body.name));
    std::vector<int> facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.boundary_patch[f] == patch - mesh.patch_names.begin())
            facets.push_back(f);
    auto load_case = core::with_free_surface({}, mesh);
    load_case.name = "constrained";
    load_case.title = "Constrained at the back, no loads";
    load_case.put({*patch}, facets, core::Vector3::Zero());
    return load_case;
}

constexpr double stretch = 0.01;

double largest_frequency(const Scene &scene) {
    return msm::largest_angular_frequency(scene.springs, scene.problem.body->mesh.points, scene.conditions);
}

} // namespace

std::span<const std::string> body_names() {
    return names;
}

std::shared_ptr<const core::Body> make_body(const std::string &name) {
    const auto &recipe = find_recipe(name);
    auto body = meshes::read_body(support::root_folder() / "meshes" / (recipe.file + ".toml"));
    for (int r = 0; r < recipe.num_refinements; ++r)
        body = core::refine(body);
    if (recipe.num_refinements > 0) {
        const auto edges = core::edge_table(body.mesh.tetrahedra).edges;
        const auto order = msm::reverse_cuthill_mckee(edges, body.mesh.num_nodes());
        body = renumbered(std::move(body), order);
    }
    body.name = name;
    return std::make_shared<const core::Body>(std::move(body));
}

int num_refinements(const std::string &name) {
    return find_recipe(name).num_refinements;
}

Scene make_scene(std::shared_ptr<const core::Body> body) {
    Scene scene;
    scene.problem = {.body = std::move(body), .load_case = {}};
    scene.problem.load_case = constrained_at_back(*scene.problem.body);
    scene.springs = msm::spring_network(*scene.problem.body, msm::all_spring_laws().front());
    scene.conditions = msm::nodal_conditions(scene.problem, scene.springs.node_mass);
    for (const auto &displacement : scene.conditions.displacement)
        scene.is_constrained.push_back(!std::isnan(displacement.x()));
    scene.start = scene.problem.body->mesh.points;
    for (auto &x : scene.start)
        x.x() *= 1.0 + stretch;
    scene.largest_angular_frequency = largest_frequency(scene);
    return scene;
}

Scene with_mean_stiffness(Scene scene) {
    auto &stiffness = scene.springs.stiffness;
    const double sum = std::accumulate(stiffness.begin(), stiffness.end(), 0.0);
    stiffness.assign(stiffness.size(), sum / static_cast<double>(stiffness.size()));
    scene.largest_angular_frequency = largest_frequency(scene);
    return scene;
}

double critical_time_step(const Scene &scene, const std::string &integrator) {
    const double highest = scene.largest_angular_frequency;
    return msm::critical_time_step(msm::find_integrator(integrator), {}, highest, highest);
}

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
