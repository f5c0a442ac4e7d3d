#include "results/hdf5/tool_group.hpp"

#include <fmt/format.h>
#include <vector>

#include "results/hdf5/io/columns.hpp"

namespace livermark::results {

void write_tools(hdf5::OutputFile &file, const core::Problem &problem) {
    using Place = core::ToolPlace;
    const auto places = core::tool_places(problem.body->mesh, problem.load_case);
    if (places.empty())
        return;
    const auto at = hdf5::GroupWriter(file, "/load_case").group("tool");
    at.number("radius_in_edges", core::radius_in_edges(places).value());
    auto columns = hdf5::columns_of(at, places);
    columns.column("drive", &Place::drive);
    hdf5::columns_of(at.on("drive"), places).texts("places", &Place::name);
    columns.column("middle", &Place::middle, "m");
    columns.column("radius", &Place::radius, "m");
    columns.column("edge_length", &Place::edge_length, "m");
    if (const auto contact = core::contact_radii_in_edges(problem.body->mesh, problem.load_case); !contact.empty())
        at.rows("contact_radius_in_edges", contact, "", contact.size());
}

namespace {

/// Of all places at one point of the path, then at the next.
std::vector<double> point_by_point(const std::vector<core::PlaceErrors> &places) {
    std::vector<double> path;
    for (std::size_t k = 0; !places.empty() && k < places.front().path.size(); ++k)
        for (const auto &place : places)
            path.push_back(place.path[k]);
    return path;
}

/// @param at  /comparisons/<model>/tool
template <class At>
void describe_tool_errors_of(At at, hdf5::Of<At, std::vector<core::PlaceErrors>> &places,
                             const core::LoadCase &load_case) {
    auto columns = hdf5::columns_of(at, places);
    columns.column("stiffness", &core::PlaceErrors::stiffness);
    hdf5::columns_of(at.on("stiffness"), places, places.size()).texts("places", &core::PlaceErrors::name);
    at.check(!places.empty(), "stiffness", "is empty");
    columns.column("relative_l2", &core::PlaceErrors::relative_l2);
    auto path = point_by_point(places);
    if (!at.has("path", !path.empty()))
        return;
    at.blocks("path", path, places.size());
    const auto num_points = path.size() / places.size();
    at.check(num_points <= load_case.num_path_points(), "path",
             fmt::format("has {} points, and /load_case/path {}", num_points, load_case.num_path_points()));
    if constexpr (At::reads)
        for (std::size_t n = 0; n < path.size(); ++n)
            places[n % places.size()].path.push_back(path[n]);
}

} // namespace

void write_tool_comparison(const hdf5::GroupWriter &at, const core::ToolComparison &tool,
                           const core::LoadCase &load_case) {
    at.number("stiffness_at_tool", tool.stiffness());
    at.number("relative_l2_at_tool", tool.worst_place().relative_l2);
    at.text("tool", tool.worst_place().name);
    if (!tool.places.front().path.empty())
        at.number("worst_stiffness_at_tool", tool.worst_stiffness());
    describe_tool_errors_of(at.group("tool"), tool.places, load_case);
}

core::ToolComparison read_tool_comparison(const hdf5::GroupReader &at, const core::LoadCase &load_case) {
    core::ToolComparison tool;
    describe_tool_errors_of(at.on("tool"), tool.places, load_case);
    return tool;
}

} // namespace livermark::results
