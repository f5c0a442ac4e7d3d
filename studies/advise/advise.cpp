#include "studies/advise/advise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <sstream>
#include <toml++/toml.h>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/springs/springs.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::studies {

namespace {

/// As many steps as fit into this time are taken, within these numbers [s].
constexpr double timing_seconds = 0.25;
constexpr int least_timed_steps = 5, most_timed_steps = 200;

double shortest_time(const std::function<void()> &step) {
    double shortest = std::numeric_limits<double>::infinity(), sum = 0.0;
    for (int s = 0; s < most_timed_steps && (s < least_timed_steps || sum < timing_seconds); ++s) {
        const double start = core::processor_seconds();
        step();
        const double seconds = core::processor_seconds() - start;
        shortest = std::min(shortest, seconds);
        sum += seconds;
    }
    return shortest;
}

/// Tetrahedra of one region that faces join.
std::vector<std::vector<int>> parts_of_regions(const core::TetraMesh &mesh) {
    const auto part =
        core::parts_by_faces(mesh.tetrahedra, [&](int t, int other) { return mesh.region[t] == mesh.region[other]; });
    std::vector<std::vector<int>> parts(part.empty() ? 0 : *std::ranges::max_element(part) + 1);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        parts[part[t]].push_back(t);
    return parts;
}

double mean_edge_of(const core::TetraMesh &mesh, const std::vector<int> &tetrahedra) {
    double sum = 0.0;
    for (const int t : tetrahedra)
        for (const auto &[a, b] : core::tetrahedron_edges)
            sum += (mesh.points[mesh.tetrahedra[t][b]] - mesh.points[mesh.tetrahedra[t][a]]).norm();
    return sum / (static_cast<double>(core::tetrahedron_edges.size()) * static_cast<double>(tetrahedra.size()));
}

double diameter_of_ball(double volume) {
    return std::cbrt(6.0 * volume / std::numbers::pi);
}

std::vector<RegionFigures> region_figures(const core::Body &body, const std::vector<double> &volumes) {
    const auto &mesh = body.mesh;
    std::vector<RegionFigures> regions(mesh.region_names.size());
    std::vector<double> smallest(regions.size(), 0.0);
    for (std::size_t r = 0; r < regions.size(); ++r) {
        regions[r].name = mesh.region_names[r];
        regions[r].material = body.materials[r];
    }
    for (const auto &part : parts_of_regions(mesh)) {
        const auto r = static_cast<std::size_t>(mesh.region[part.front()]);
        double volume = 0.0;
        for (const int t : part)
            volume += volumes[t];
        auto &region = regions[r];
        region.volume += volume;
        region.num_tetrahedra += static_cast<int>(part.size());
        if (++region.num_parts == 1 || volume < smallest[r]) {
            smallest[r] = volume;
            region.smallest_part_tetrahedra = static_cast<int>(part.size());
            region.smallest_part_in_edges = diameter_of_ball(volume) / mean_edge_of(mesh, part);
        }
    }
    return regions;
}

double mean_edge_of_surface(const core::TetraMesh &mesh, const std::vector<std::array<int, 3>> &faces) {
    double sum = 0.0; // each edge of a closed surface is there twice
    for (const auto &face : faces)
        for (std::size_t c = 0; c < 3; ++c)
            sum += (mesh.points[face[(c + 1) % 3]] - mesh.points[face[c]]).norm();
    return sum / (3.0 * static_cast<double>(faces.size()));
}

double part_with_one_layer(const core::TetraMesh &mesh, const std::vector<std::array<int, 3>> &faces,
                           const std::vector<double> &volumes) {
    std::vector<bool> is_outside(mesh.points.size(), false);
    for (const auto &face : faces)
        for (const int node : face)
            is_outside[node] = true;
    double thin = 0.0, whole = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        whole += volumes[t];
        if (std::ranges::all_of(mesh.tetrahedra[t], [&](int node) { return is_outside[node]; }))
            thin += volumes[t];
    }
    return thin / whole;
}

/// Springs of the suite on a body, of those models that errors are known of.
struct KnownSprings {
    ExpectedError error;
    std::string summary;
    msm::ElasticBody springs;
    bool is_coupled; ///< no spring has a stiffness of its own
};

std::vector<KnownSprings> known_springs(const core::Body &body, const Evidence &evidence) {
    const auto shared = std::make_shared<const core::Body>(body);
    std::vector<KnownSprings> known;
    for (const auto &model : models::all_models())
        if (const auto *error = evidence.find(model.name))
            if (auto springs = models::springs_of(model, shared))
                known.push_back({*error, model.summary, std::move(springs->body), springs->springs.stiffness.empty()});
    return known;
}

/// @param in_both  the error of both regimes, NaN where one is not known
/// @param small    that of small loads
template <class InBoth>
std::vector<std::size_t> ranked_by(const std::vector<KnownSprings> &known, InBoth in_both,
                                   double ExpectedError::*small) {
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < known.size(); ++k)
        if (!std::isnan(known[k].error.*small))
            order.push_back(k);
    std::ranges::stable_sort(order, {}, [&](std::size_t k) {
        const double both = std::invoke(in_both, known[k].error);
        return std::pair(std::isnan(both), std::isnan(both) ? known[k].error.*small : both);
    });
    return order;
}

/// Costs that were found, by number of the springs.
class Costs {
  public:
    Costs(const core::Body &body, const std::vector<KnownSprings> &known, const FindStepCost &find, Steps &steps)
        : body_(body), known_(known), find_(find), steps_(steps) {}

    const StepCost &of(std::size_t k) {
        const auto found = costs_.find(k);
        if (found != costs_.end())
            return found->second;
        steps_.next(fmt::format("{}: critical step, and time of a step", known_[k].error.model));
        return costs_.emplace(k, find_(body_, known_[k].springs)).first->second;
    }

  private:
    const core::Body &body_;
    const std::vector<KnownSprings> &known_;
    const FindStepCost &find_;
    Steps &steps_;
    std::map<std::size_t, StepCost> costs_;
};

std::vector<ModelAdvice> best_of(const std::vector<std::size_t> &order, const std::vector<KnownSprings> &known,
                                 Costs &costs, Advice &advice) {
    std::vector<ModelAdvice> best;
    for (const auto k : order) {
        if (best.size() == num_ranked)
            break;
        const auto &cost = costs.of(k);
        const auto &name = known[k].error.model;
        if (!advice.budget || cost.seconds_per_frame() <= *advice.budget)
            best.push_back({known[k].error, known[k].summary, cost});
        else if (std::ranges::find(advice.over_budget, name) == advice.over_budget.end())
            advice.over_budget.push_back(name);
    }
    return best;
}

void refuse_budget(const std::vector<KnownSprings> &known, Costs &costs, double budget) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < known.size(); ++k)
        least = std::min(least, costs.of(k).seconds_per_frame());
    throw support::InputError(
        fmt::format("--budget {:.3g} ms: every model takes longer for a frame of 1/60 s on this mesh, the cheapest one "
                    "{:.3g} ms; give more time, or mesh the body with fewer or larger tetrahedra",
                    1e3 * budget, 1e3 * least));
}

/// JSON has no NaN.
void insert_known(toml::table &table, const char *key, double value) {
    if (std::isfinite(value))
        table.insert(key, value);
}

toml::array json_array(const std::vector<std::string> &texts) {
    toml::array array;
    for (const auto &text : texts)
        array.push_back(text);
    return array;
}

toml::table json_of_error(const ExpectedError &error) {
    toml::table table{{"model", error.model},
                      {"num_at_tool", static_cast<std::int64_t>(error.num_at_tool)},
                      {"num_l2", static_cast<std::int64_t>(error.num_l2)},
                      {"num_large", static_cast<std::int64_t>(error.num_large)},
                      {"num_failed", static_cast<std::int64_t>(error.num_failed)},
                      {"num_large_failed", static_cast<std::int64_t>(error.num_large_failed)},
                      {"worst_load_case", error.worst_load_case}};
    insert_known(table, "at_tool", error.at_tool);
    insert_known(table, "worst_at_tool", error.worst_at_tool);
    insert_known(table, "relative_l2", error.relative_l2);
    insert_known(table, "worst_relative_l2", error.worst_relative_l2);
    insert_known(table, "large_at_tool", error.large_at_tool);
    insert_known(table, "large_relative_l2", error.large_relative_l2);
    return table;
}

toml::array json_of_models(const std::vector<ModelAdvice> &models) {
    toml::array array;
    for (const auto &[error, summary, cost] : models) {
        auto table = json_of_error(error);
        table.insert("summary", summary);
        table.insert("critical_time_step", cost.critical_time_step);
        table.insert("time_step", cost.safe_time_step());
        table.insert("steps_per_frame", cost.steps_per_frame());
        table.insert("seconds_per_step", cost.seconds_per_step);
        table.insert("seconds_per_frame", cost.seconds_per_frame());
        table.insert("is_on_vector_units", cost.is_on_vector_units);
        array.push_back(std::move(table));
    }
    return array;
}

toml::array json_of_regions(const std::vector<RegionFigures> &regions) {
    toml::array array;
    for (const auto &region : regions)
        array.push_back(toml::table{{"name", region.name},
                                    {"density", region.material.density},
                                    {"young_modulus", region.material.young_modulus},
                                    {"poisson_ratio", region.material.poisson_ratio},
                                    {"volume", region.volume},
                                    {"tetrahedra", region.num_tetrahedra},
                                    {"parts", region.num_parts},
                                    {"smallest_part_tetrahedra", region.smallest_part_tetrahedra},
                                    {"smallest_part_in_edges", region.smallest_part_in_edges}});
    return array;
}

toml::table json_of_body(const BodyFigures &body) {
    const auto &mesh = body.mesh;
    return toml::table{{"name", body.name},
                       {"tetrahedra", mesh.num_tetrahedra},
                       {"nodes", mesh.num_nodes},
                       {"volume", mesh.volume},
                       {"extent", toml::array{mesh.extent.x(), mesh.extent.y(), mesh.extent.z()}},
                       {"mean_edge", mesh.mean_edge},
                       {"shortest_edge", mesh.shortest_edge},
                       {"smallest_quality", mesh.smallest_quality},
                       {"surface_edge", body.surface_edge},
                       {"tool_radius", body.tool_radius},
                       {"tool_radius_in_edges", body.tool_radius_in_edges()},
                       {"thin_part", body.thin_part},
                       {"regions", json_of_regions(body.regions)}};
}

toml::table json_of_evidence(const Evidence &evidence) {
    toml::table table{{"poisson_ratio", evidence.poisson_ratio},
                      {"tetrahedra", evidence.tetrahedra},
                      {"bodies", static_cast<std::int64_t>(evidence.num_bodies)},
                      {"reference", evidence.reference},
                      {"sources", json_array(evidence.sources)}};
    if (!evidence.large_reference.empty()) {
        table.insert("large_reference", evidence.large_reference);
        table.insert("large_poisson_ratio", evidence.large_poisson_ratio);
    }
    insert_known(table, "least_radius_in_edges", evidence.least_radius);
    insert_known(table, "largest_radius_in_edges", evidence.largest_radius);
    return table;
}

} // namespace

double StepCost::safe_time_step() const {
    return msm::default_safety_factor * critical_time_step;
}

int StepCost::steps_per_frame() const {
    return static_cast<int>(std::ceil(frame / safe_time_step()));
}

double critical_time_step(const core::Body &body, const msm::ElasticBody &springs) {
    const auto &positions = body.mesh.points;
    return 2.0 / msm::largest_angular_frequency(springs, positions, msm::free_nodes(positions.size()));
}

StepCost step_cost(const core::Body &body, const msm::ElasticBody &springs) {
    const auto &positions = body.mesh.points;
    const auto conditions = msm::free_nodes(positions.size());
    StepCost cost;
    cost.critical_time_step = critical_time_step(body, springs);
    const auto parted = msm::part_terms(springs);
    auto steps = msm::FastSteps::prepare(parted.in_kernels, positions, conditions, {}, "symplectic_euler",
                                         cost.safe_time_step());
    cost.is_on_vector_units = steps.has_value();
    const Eigen::VectorXd rest = msm::to_unknowns(positions);
    const auto take_step = [&] {
        Eigen::VectorXd force = Eigen::VectorXd::Zero(rest.size());
        for (const auto &term : parted.beside)
            term->add_force(rest, rest, 0.0, force);
        steps->take(1);
    };
    cost.seconds_per_step =
        steps ? shortest_time(take_step) : shortest_time([&] { msm::elastic_gradient(springs, positions); });
    return cost;
}

double scaled_critical_time_step(const core::Body &body, const msm::ElasticBody &springs) {
    const auto conditions = msm::free_nodes(body.mesh.points.size());
    const auto scaling = msm::scale_masses(body, springs, conditions);
    return 2.0 / msm::largest_angular_frequency(springs, body.mesh.points, conditions, scaling);
}

BodyFigures body_figures(const core::Body &body, double tool_radius) {
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    const auto faces = core::outer_faces(body.mesh.tetrahedra);
    BodyFigures figures{.name = body.name,
                        .mesh = meshes::mesh_figures(body.mesh),
                        .regions = region_figures(body, volumes),
                        .surface_edge = mean_edge_of_surface(body.mesh, faces),
                        .tool_radius = tool_radius,
                        .thin_part = part_with_one_layer(body.mesh, faces, volumes)};
    const auto largest = std::ranges::max_element(figures.regions, {}, &RegionFigures::volume);
    figures.main_region = static_cast<std::size_t>(largest - figures.regions.begin());
    return figures;
}

Advice advise(const core::Body &body, const AdviceOptions &options, const ProgressReport &report) {
    Advice advice;
    advice.body = body_figures(body, options.tool_radius);
    advice.budget = options.budget;
    advice.evidence = shipped_evidence({.poisson_ratio = advice.body.material().poisson_ratio,
                                        .tool_radius_in_edges = advice.body.tool_radius_in_edges(),
                                        .tetrahedra = advice.body.mesh.num_tetrahedra});
    if (const auto *linear = advice.evidence.find(models::baseline_name()))
        advice.linear_tetrahedra = *linear;
    const auto known = known_springs(body, advice.evidence);
    if (known.empty())
        throw support::InputError("results/cohorts has errors of no model of springs; restore it from git");
    Steps steps(static_cast<int>(known.size()), report);
    Costs costs(body, known, options.find_cost, steps);
    advice.touch =
        best_of(ranked_by(known, &ExpectedError::in_both_at_tool, &ExpectedError::at_tool), known, costs, advice);
    auto uncoupled = ranked_by(known, &ExpectedError::in_both_at_tool, &ExpectedError::at_tool);
    std::erase_if(uncoupled, [&](std::size_t k) { return known[k].is_coupled; });
    advice.uncoupled = best_of(uncoupled, known, costs, advice);
    advice.position = best_of(ranked_by(known, &ExpectedError::in_both_relative_l2, &ExpectedError::relative_l2), known,
                              costs, advice);
    if (advice.position.empty())
        refuse_budget(known, costs, *options.budget);
    const auto &first = advice.touch.empty() ? advice.position.front() : advice.touch.front();
    const auto springs = std::ranges::find(known, first.error.model, [](const auto &k) { return k.error.model; });
    advice.caveats = find_caveats(body, options, advice, scaled_critical_time_step(body, springs->springs));
    if (advice.caveats.size() > num_ranked)
        advice.caveats.resize(num_ranked);
    advice.left_out = parts_left_out(body);
    return advice;
}

std::string to_json(const Advice &advice) {
    toml::array caveats;
    for (const auto &caveat : advice.caveats)
        caveats.push_back(toml::table{{"about", caveat.about}, {"weight", caveat.weight}, {"text", caveat.text}});
    toml::array left_out;
    for (const auto &part : advice.left_out)
        left_out.push_back(toml::table{{"part", part.part},
                                       {"words", part.words},
                                       {"remedy", part.remedy},
                                       {"body", part.body},
                                       {"load_cases", part.load_cases},
                                       {"at_tool", part.at_tool},
                                       {"worst_at_tool", part.worst_at_tool},
                                       {"relative_l2", part.relative_l2},
                                       {"worst_relative_l2", part.worst_relative_l2}});
    toml::table all{{"body", json_of_body(advice.body)},
                    {"evidence", json_of_evidence(advice.evidence)},
                    {"touch", json_of_models(advice.touch)},
                    {"position", json_of_models(advice.position)},
                    {"uncoupled", json_of_models(advice.uncoupled)},
                    {"over_budget", json_array(advice.over_budget)},
                    {"caveats", std::move(caveats)},
                    {"left_out", std::move(left_out)}};
    if (advice.linear_tetrahedra)
        all.insert("linear_tetrahedra", json_of_error(*advice.linear_tetrahedra));
    if (advice.budget)
        all.insert("budget", *advice.budget);
    std::ostringstream stream;
    stream << toml::json_formatter(all);
    return stream.str();
}

} // namespace livermark::studies
