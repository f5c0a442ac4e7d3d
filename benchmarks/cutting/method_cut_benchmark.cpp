// Interactive methods move a body that is cut: how long it is from the cut body to the next step, beside a set-up of
// the cut body from nothing, and by how much the next step of both differs.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "benchmarks/bodies.hpp"
#include "benchmarks/cutting/blade.hpp"
#include "core/processor_time.hpp"
#include "interactive/cutting/cut_motion.hpp"
#include "msm/elastic_body.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"

namespace livermark {
namespace {

using interactive::Field;
using interactive::SceneCut;
using interactive::Simulation;

struct Options {
    std::string body = "liver_healthy";
    std::vector<std::string> methods; ///< all if none
    int tetrahedra = 500, cuts = 20;
};

constexpr double milliseconds = 1e3;
/// Cuts after which the body is made whole again.
constexpr int cuts_in_turn = 4;

/// What is left without the tetrahedra that are nearest to a node.
SceneCut without_ball(const core::Body &body, int count, std::mt19937 &random) {
    const auto &mesh = body.mesh;
    const auto &centre = mesh.points[random() % mesh.points.size()];
    std::vector<int> numbers(mesh.tetrahedra.size());
    std::vector<double> distance;
    for (std::size_t t = 0; t < numbers.size(); ++t) {
        numbers[t] = static_cast<int>(t);
        core::Vector3 middle = core::Vector3::Zero();
        for (const int node : mesh.tetrahedra[t])
            middle += 0.25 * mesh.points[node];
        distance.push_back((middle - centre).squaredNorm());
    }
    std::ranges::sort(numbers, {}, [&](int t) { return distance[t]; });
    SceneCut cut;
    cut.parent_tetrahedron.assign(numbers.begin() + std::min<std::ptrdiff_t>(count, std::ssize(numbers) - 1),
                                  numbers.end());
    std::ranges::sort(cut.parent_tetrahedron);
    core::Body left{.name = body.name, .mesh = {}, .materials = body.materials};
    left.mesh.region_names = mesh.region_names;
    left.mesh.patch_names = {"surface"};
    std::vector<int> number(mesh.points.size(), -1);
    for (const int t : cut.parent_tetrahedron)
        for (const int node : mesh.tetrahedra[t])
            number[node] = 0;
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] == 0) {
            number[i] = left.mesh.num_nodes();
            left.mesh.points.push_back(mesh.points[i]);
        }
    for (const int t : cut.parent_tetrahedron) {
        auto &nodes = left.mesh.tetrahedra.emplace_back(mesh.tetrahedra[t]);
        for (int &node : nodes)
            node = number[node];
        left.mesh.region.push_back(mesh.region[t]);
    }
    left.mesh.boundary_triangles = core::outer_faces(left.mesh.tetrahedra);
    left.mesh.boundary_patch.assign(left.mesh.boundary_triangles.size(), 0);
    cut.body = std::make_shared<const core::Body>(std::move(left));
    return cut;
}

SceneCut parted(const core::Body &body) {
    auto found = benchmarks::parted_by_blade(body);
    return {.body = std::make_shared<const core::Body>(std::move(found.body)),
            .node_mass = {},
            .parent_tetrahedron = std::move(found.parents.front())};
}

struct Times {
    std::vector<double> fresh, continued; ///< [s]
    double difference = 0.0;              ///< of the next step, over its length
};

double percentile(std::vector<double> values, double part) {
    std::ranges::sort(values);
    return values[static_cast<std::size_t>(std::lround(part * static_cast<double>(values.size() - 1)))];
}

/// A method on a body, and its steps here: of a frame, or a short explicit one.
struct Case {
    const interactive::Method &method;
    std::shared_ptr<const core::Body> body;

    double time_step() const { return method.is_explicit ? 1e-4 : method.time_step; }
    int iterations() const { return method.is_explicit ? 1 : method.iterations; }

    std::unique_ptr<Simulation> moving() const {
        const auto load_case = benchmarks::constrained(*body);
        interactive::Scene scene{
            .body = body, .node_mass = msm::lumped_masses(*body), .constrained_nodes = {}, .mass_damping = 7.0};
        std::vector<bool> is_held(body->mesh.points.size(), false);
        for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f)
            if (load_case.is_constrained(f))
                for (const int node : body->mesh.boundary_triangles[f])
                    is_held[node] = true;
        for (std::size_t i = 0; i < is_held.size(); ++i)
            if (is_held[i])
                scene.constrained_nodes.push_back(static_cast<int>(i));
        auto simulation = method.prepare(scene);
        const auto is_free = interactive::free_nodes(simulation->scene());
        Field x = simulation->positions(), v = Field::Zero(3, x.cols());
        constexpr double bend = 2e-3, length = 0.1; // [m]
        for (Eigen::Index i = 0; i < x.cols(); ++i)
            if (is_free[i]) {
                const double phase = 2.0 * std::numbers::pi / length * x(0, i);
                v.col(i) = 10.0 * bend * core::Vector3(std::cos(phase), 0.0, std::sin(phase));
                x.col(i).y() += bend * std::sin(phase);
            }
        simulation->set_state(x, v);
        simulation->prepare(time_step());
        simulation->step(time_step(), iterations());
        return simulation;
    }

    /// @return the simulation that went on, before its next step
    std::unique_ptr<Simulation> time(const Simulation &before, SceneCut cut, Times &times) const {
        double start = core::processor_seconds();
        cut.node_mass = msm::lumped_masses(*cut.body);
        auto after = interactive::continue_after_cut(method, before, cut);
        after->prepare(time_step());
        times.continued.push_back(core::processor_seconds() - start);
        start = core::processor_seconds();
        auto scene = after->scene();
        scene.orders = nullptr;
        scene.own_nodes.clear();
        scene.followers.clear();
        scene.node_mass = msm::lumped_masses(*cut.body);
        const auto fresh = method.prepare(scene);
        fresh->set_external_forces(after->external_forces());
        fresh->set_targets(after->targets());
        fresh->set_state(after->positions(), after->velocities());
        fresh->prepare(time_step());
        times.fresh.push_back(core::processor_seconds() - start);
        const Field was = after->positions();
        after->step(time_step(), iterations());
        fresh->step(time_step(), iterations());
        times.difference = std::max(times.difference, (after->positions() - fresh->positions()).norm() /
                                                          (fresh->positions() - was).norm());
        return after;
    }
};

void print(const Times &times) {
    fmt::print(" {:.1f} | {:.1f} | {:.1f} | {:.0e} |", milliseconds * percentile(times.fresh, 0.5),
               milliseconds * percentile(times.continued, 0.5), milliseconds * percentile(times.continued, 0.95),
               times.difference);
}

int run(const Options &options) {
    const auto body = benchmarks::make_body(options.body);
    std::vector<std::string> names = options.methods;
    for (const auto &method : interactive::all_methods())
        if (options.methods.empty())
            names.push_back(method.name);
    for (const auto &name : names)
        support::find_named(interactive::all_methods(), name, "method");
    const auto in_two = parted(*body);
    fmt::print("{}: {} tetrahedra, of which {} go; and a blade parts {} nodes\n\n"
               "| method | removed: from nothing [ms] | cut to next step [ms] | 95 % [ms] | differ by | parted: from "
               "nothing [ms] | cut to next step [ms] | 95 % [ms] | differ by |\n"
               "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
               options.body, body->mesh.num_tetrahedra(), options.tetrahedra,
               in_two.body->mesh.num_nodes() - body->mesh.num_nodes());
    for (const auto &name : names) {
        const Case of_method{interactive::find_method(name), body};
        const auto whole = of_method.moving();
        Times removed, of_blade;
        std::mt19937 random(1);
        std::unique_ptr<Simulation> last;
        for (int k = 0; k < options.cuts; ++k) {
            const Simulation &before = k % cuts_in_turn == 0 ? *whole : *last;
            last = of_method.time(before, without_ball(*before.scene().body, options.tetrahedra, random), removed);
            of_method.time(*whole, in_two, of_blade);
        }
        fmt::print("| `{}` |", name);
        print(removed);
        print(of_blade);
        fmt::print("\n");
    }
    return 0;
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    CLI::App app("How long a cut takes until the next step of an interactive method");
    livermark::Options options;
    app.add_option("--body", options.body, "As in benchmarks/bodies.hpp")->capture_default_str();
    app.add_option("--method", options.methods, "Names of interactive methods; all if left out");
    app.add_option("--tetrahedra", options.tetrahedra, "How many go in a cut")
        ->capture_default_str()
        ->check(CLI::PositiveNumber);
    app.add_option("--cuts", options.cuts, "Of each method")->capture_default_str()->check(CLI::PositiveNumber);
    CLI11_PARSE(app, argc, argv);
    try {
        return livermark::run(options);
    } catch (const livermark::support::InputError &error) {
        fmt::print(stderr, "{}\n", error.what());
        return 2;
    }
}
