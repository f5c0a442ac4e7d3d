// Tetrahedra are taken away from a body that moves, and a blade without thickness parts it: how long it is until the
// next step.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "benchmarks/bodies.hpp"
#include "benchmarks/cutting/blade.hpp"
#include "core/processor_time.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/cutting/frequency_around.hpp"
#include "msm/cutting/kept_numbers.hpp"
#include "msm/dynamics/highest_frequency.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/springs/springs_with_volume.hpp"
#include "support/input_error.hpp"

namespace livermark {
namespace {

struct Options {
    std::string body = "liver_healthy";
    std::vector<std::string> springs; ///< all if none
    int tetrahedra = 500, cuts = 40;
    bool has_frequencies = false, has_partings = false;
};

/// What moves, and where the stiffness of its springs comes from.
struct Springs {
    std::string name;
    std::function<msm::ElasticBody(const core::Body &)> make;
    std::optional<msm::SpringSource> source;
};

std::vector<Springs> all_springs(const core::Body &body) {
    std::vector<Springs> all;
    for (const auto &law : msm::all_spring_laws()) {
        msm::SpringSource source{law, msm::for_springs_beside_volume(body)};
        all.push_back({law.name,
                       [law](const core::Body &of) {
                           return msm::springs_with_volume(of, msm::springs_beside_volume(of, law),
                                                           msm::find_volume_term("nodal_volume"))
                               .body;
                       },
                       std::move(source)});
    }
    for (const auto &coupled : msm::all_coupled_springs())
        if (msm::are_in_kernels(coupled))
            all.push_back({coupled.name,
                           [coupled](const core::Body &of) { return msm::coupled_springs_with_volume(of, coupled); },
                           std::nullopt});
    return all;
}

/// Balls of so many tetrahedra that are still there.
class Balls {
  public:
    explicit Balls(const core::TetraMesh &mesh) : mesh_(mesh), is_gone_(mesh.tetrahedra.size(), false) {
        for (const auto &nodes : mesh.tetrahedra) {
            middle_.emplace_back(core::Vector3::Zero());
            for (const int node : nodes)
                middle_.back() += 0.25 * mesh.points[node];
        }
    }

    std::vector<int> take(int count, std::mt19937 &random) {
        const auto &centre = mesh_.points[random() % mesh_.points.size()];
        std::vector<int> near;
        for (int t = 0; t < mesh_.num_tetrahedra(); ++t)
            if (!is_gone_[t])
                near.push_back(t);
        std::ranges::sort(near, {}, [&](int t) { return (middle_[t] - centre).squaredNorm(); });
        near.resize(std::min<std::size_t>(near.size(), count));
        for (const int t : near)
            is_gone_[t] = true;
        return near;
    }

  private:
    const core::TetraMesh &mesh_;
    std::vector<bool> is_gone_;
    std::vector<core::Vector3> middle_;
};

double percentile(std::vector<double> values, double part) {
    std::ranges::sort(values);
    return values[static_cast<std::size_t>(std::lround(part * static_cast<double>(values.size() - 1)))];
}

msm::NodalConditions held_where(const core::Body &body, const std::vector<bool> &is_held) {
    msm::NodalConditions conditions;
    for (std::size_t i = 0; i < body.mesh.points.size(); ++i) {
        conditions.displacement.emplace_back(core::Vector3::Constant(is_held[i] ? 0.0 : std::nan("")));
        conditions.constraint.push_back({-1, -1, -1});
        conditions.force.emplace_back(core::Vector3::Zero());
    }
    return conditions;
}

std::vector<bool> held_nodes(const core::Body &body) {
    const auto load_case = benchmarks::constrained(body);
    std::vector<bool> is_held(body.mesh.points.size(), false);
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.is_constrained(f))
            for (const int node : body.mesh.boundary_triangles[f])
                is_held[node] = true;
    return is_held;
}

constexpr double milliseconds = 1e3, step = 1e-4;
/// Cuts after which the body is made whole again: an eighth of the tetrahedra of 16,000 is gone then.
constexpr int cuts_in_turn = 4;

void time_updates(const core::Body &body, const Springs &springs, const Options &options) {
    const auto conditions = held_where(body, held_nodes(body));
    std::mt19937 random(1);
    std::vector<double> whole, parts_times, steps_times, ready, around, all;
    double largest_miss = 0.0;
    const msm::FastStepOptions step_options{.may_be_cut = true};
    for (int done = 0; done < options.cuts;) {
        double start = core::processor_seconds();
        const auto elastic = springs.make(body);
        auto steps = msm::FastSteps::prepare(elastic, body.mesh.points, conditions, {.alpha = 7.0, .beta = 0.0},
                                             "symplectic_euler", step, step_options);
        whole.push_back(core::processor_seconds() - start);
        auto parts = msm::CutParts::prepare(body, elastic, springs.source).value();
        double highest = 0.0;
        Balls balls(body.mesh);
        for (int turn = 0; turn < cuts_in_turn; ++turn, ++done) {
            const auto ball = balls.take(options.tetrahedra, random);
            steps->take(1); // what a step reads and writes is in the caches
            start = core::processor_seconds();
            const auto &changes = parts.remove(ball);
            const double between = core::processor_seconds();
            steps->cut(parts.parts(), parts.node_mass(), changes);
            const double end = core::processor_seconds();
            parts_times.push_back(between - start);
            steps_times.push_back(end - between);
            ready.push_back(end - start);
            if (!options.has_frequencies || turn > 0)
                continue;
            constexpr double tolerance = 1e-3;
            const auto &points = body.mesh.points;
            highest = msm::largest_angular_frequency(elastic, points, conditions, {}, tolerance);
            start = core::processor_seconds();
            const double local = msm::frequency_around(body, parts.parts().is_removed, changes.nodes, springs.make,
                                                       conditions, tolerance);
            around.push_back(core::processor_seconds() - start);
            core::Body rest{.name = {}, .mesh = body.mesh, .materials = body.materials};
            rest.mesh.tetrahedra.clear();
            rest.mesh.region.clear();
            for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
                if (parts.parts().is_there(t)) {
                    rest.mesh.tetrahedra.push_back(body.mesh.tetrahedra[t]);
                    rest.mesh.region.push_back(body.mesh.region[t]);
                }
            auto held = held_nodes(body);
            for (std::size_t i = 0; i < held.size(); ++i)
                held[i] = held[i] || parts.node_mass()[i] == 0.0;
            start = core::processor_seconds();
            auto elastic_of_rest = springs.make(rest);
            for (double &mass : elastic_of_rest.node_mass)
                mass = std::max(mass, 1e-12);
            const double expected =
                msm::largest_angular_frequency(elastic_of_rest, points, held_where(body, held), {}, tolerance);
            all.push_back(core::processor_seconds() - start);
            largest_miss = std::max(largest_miss, std::abs(std::max(local, highest) / expected - 1.0));
        }
    }
    fmt::print("| `{}` | {:.1f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |", springs.name,
               milliseconds * percentile(whole, 0.5), milliseconds * percentile(parts_times, 0.5),
               milliseconds * percentile(steps_times, 0.5), milliseconds * percentile(ready, 0.5),
               milliseconds * percentile(ready, 0.95));
    if (options.has_frequencies)
        fmt::print(" {:.0f} | {:.0f} | {:.2f} |", milliseconds * percentile(around, 0.5),
                   milliseconds * percentile(all, 0.5), 100.0 * largest_miss);
    fmt::print("\n");
}

/// A blade parts a body that moves, beside a set-up of the parted body.
void time_partings(const core::Body &body, const Springs &springs, const Options &options) {
    const auto cut_body = benchmarks::parted_by_blade(body);
    const auto &after = cut_body.body;
    const auto conditions = held_where(body, held_nodes(body)), conditions_after = held_where(after, held_nodes(after));
    constexpr core::RayleighDamping damping{.alpha = 7.0, .beta = 0.0};
    const auto elastic = springs.make(body);
    const auto time_steps = [](msm::FastSteps &steps) {
        constexpr int num_steps = 20;
        steps.take(1);
        const double start = core::processor_seconds();
        steps.take(num_steps);
        return (core::processor_seconds() - start) / num_steps;
    };
    std::vector<double> whole, numbers_times, parts_times, steps_times, ready, step_of_parted, step_of_anew;
    double difference = 0.0;
    for (int done = 0; done < options.cuts; ++done) {
        auto steps = msm::FastSteps::prepare(elastic, body.mesh.points, conditions, damping, "symplectic_euler", step,
                                             {.may_be_cut = true})
                         .value();
        auto parts = msm::CutParts::prepare(body, elastic, springs.source).value();
        msm::KeptNumbers numbers(body.mesh);
        auto state = steps.state();
        for (std::size_t i = 0; i < body.mesh.points.size(); ++i)
            if (std::isnan(conditions.displacement[i].x()))
                msm::of_node(state.velocity, static_cast<int>(i)) =
                    core::Vector3(0.0, 0.1 * std::sin(100.0 * body.mesh.points[i].x()), 0.0);
        steps.set_state(state);
        steps.take(10);
        double start = core::processor_seconds();
        const auto cut = numbers.follow(after.mesh, cut_body.parents.front());
        const double with_numbers = core::processor_seconds();
        if (!cut.removed.empty()) // crumbs
            steps.cut(parts.parts(), parts.node_mass(), parts.remove(cut.removed));
        const auto &changes = parts.part(cut.parting);
        const double between = core::processor_seconds();
        steps.part(parts.parts(), parts.node_mass(), changes);
        const double end = core::processor_seconds();
        numbers_times.push_back(with_numbers - start);
        parts_times.push_back(between - with_numbers);
        steps_times.push_back(end - between);
        ready.push_back(end - start);
        start = core::processor_seconds();
        auto anew = msm::FastSteps::prepare(springs.make(after), after.mesh.points, conditions_after, damping,
                                            "symplectic_euler", step)
                        .value();
        whole.push_back(core::processor_seconds() - start);
        const auto before = steps.state();
        auto of_anew = anew.state();
        for (int i = 0; i < after.mesh.num_nodes(); ++i) {
            msm::of_node(of_anew.displacement, i) = msm::of_node(before.displacement, numbers.nodes()[i]);
            msm::of_node(of_anew.velocity, i) = msm::of_node(before.velocity, numbers.nodes()[i]);
        }
        anew.set_state(of_anew);
        steps.take(1);
        anew.take(1);
        const auto is = steps.state(), should = anew.state();
        double largest = 0.0, miss = 0.0;
        for (int i = 0; i < after.mesh.num_nodes(); ++i) {
            const core::Vector3 expected = msm::of_node(should.velocity, i);
            largest = std::max(largest, (expected - msm::of_node(of_anew.velocity, i)).norm());
            miss = std::max(miss, (expected - msm::of_node(is.velocity, numbers.nodes()[i])).norm());
        }
        difference = std::max(difference, miss / largest);
        step_of_parted.push_back(time_steps(steps));
        step_of_anew.push_back(time_steps(anew));
    }
    fmt::print("| `{}` | {:.1f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.0e} | {:.0f} |\n", springs.name,
               milliseconds * percentile(whole, 0.5), milliseconds * percentile(numbers_times, 0.5),
               milliseconds * percentile(parts_times, 0.5), milliseconds * percentile(steps_times, 0.5),
               milliseconds * percentile(ready, 0.5), milliseconds * percentile(ready, 0.95), difference,
               100.0 * (percentile(step_of_parted, 0.5) / percentile(step_of_anew, 0.5) - 1.0));
}

int run(const Options &options) {
    const auto body = benchmarks::make_body(options.body);
    fmt::print("{}: {} tetrahedra, of which {} go\n\n| springs | set-up [ms] | parts [ms] | layout [ms] | ready [ms] | "
               "95 % of cuts [ms] |{}\n| --- | ---: | ---: | ---: | ---: | ---: |{}\n",
               options.body, body->mesh.num_tetrahedra(), options.tetrahedra,
               options.has_frequencies ? " frequency around [ms] | of all [ms] | off by [%] |" : "",
               options.has_frequencies ? " ---: | ---: | ---: |" : "");
    std::vector<Springs> chosen;
    for (auto &springs : all_springs(*body))
        if (options.springs.empty() || std::ranges::find(options.springs, springs.name) != options.springs.end())
            chosen.push_back(std::move(springs));
    for (const auto &springs : chosen)
        time_updates(*body, springs, options);
    if (!options.has_partings)
        return 0;
    const auto parted = benchmarks::parted_by_blade(*body);
    fmt::print("\n{}: a blade parts {} nodes\n\n| springs | set-up [ms] | numbers [ms] | parts [ms] | layout [ms] | "
               "ready [ms] | 95 % of cuts [ms] | differ by | a step takes longer by [%] |\n"
               "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
               options.body, parted.body.mesh.num_nodes() - body->mesh.num_nodes());
    for (const auto &springs : chosen)
        time_partings(*body, springs, options);
    return 0;
}

} // namespace
} // namespace livermark

int main(int argc, char **argv) {
    CLI::App app("How long a cut takes until the next step");
    livermark::Options options;
    app.add_option("--body", options.body, "As in benchmarks/bodies.hpp")->capture_default_str();
    app.add_option("--springs", options.springs, "Names of laws and of coupled springs; all if left out");
    app.add_option("--tetrahedra", options.tetrahedra, "How many go in a cut")->capture_default_str();
    app.add_option("--cuts", options.cuts, "Of each springs")->capture_default_str();
    app.add_flag("--frequencies", options.has_frequencies, "Find the highest frequency after every fourth cut as well");
    app.add_flag("--parted", options.has_partings, "Part the body by a blade as well");
    CLI11_PARSE(app, argc, argv);
    try {
        return livermark::run(options);
    } catch (const livermark::support::InputError &error) {
        fmt::print(stderr, "{}\n", error.what());
        return 2;
    }
}
