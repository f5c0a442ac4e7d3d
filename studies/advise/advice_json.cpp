#include "studies/advise/advice_json.hpp"

#include <cmath>
#include <sstream>
#include <toml++/toml.h>

namespace livermark::studies {

namespace {

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

std::string to_json(const Advice &advice) {
    toml::array caveats;
    for (const auto &caveat : advice.caveats)
        caveats.push_back(toml::table{{"about", caveat.about}, {"weight", caveat.weight}, {"text", caveat.text}});
    toml::table all{{"body", json_of_body(advice.body)},
                    {"evidence", json_of_evidence(advice.evidence)},
                    {"touch", json_of_models(advice.touch)},
                    {"position", json_of_models(advice.position)},
                    {"uncoupled", json_of_models(advice.uncoupled)},
                    {"over_budget", json_array(advice.over_budget)},
                    {"caveats", std::move(caveats)}};
    if (advice.linear_tetrahedra)
        all.insert("linear_tetrahedra", json_of_error(*advice.linear_tetrahedra));
    if (advice.budget)
        all.insert("budget", *advice.budget);
    std::ostringstream stream;
    stream << toml::json_formatter(all);
    return stream.str();
}

} // namespace livermark::studies
