#include "results/hdf5/tool_group.hpp"

#include <cstdint>
#include <fmt/format.h>
#include <vector>

namespace livermark::results {

void write_tools(hdf5::OutputFile &file, const core::Problem &problem) {
    const auto places = core::tool_places(problem.body->mesh, problem.load_case);
    if (places.empty())
        return;
    std::vector<std::string> names;
    std::vector<std::uint8_t> drive;
    std::vector<core::Vector3> middle;
    std::vector<double> radius, edge_length;
    for (const auto &place : places) {
        names.push_back(place.name);
        drive.push_back(static_cast<std::uint8_t>(place.drive));
        middle.push_back(place.middle);
        radius.push_back(place.radius);
        edge_length.push_back(place.edge_length);
    }
    const std::string group = "/load_case/tool";
    file.group(group);
    file.number(group, "radius_in_edges", core::radius_in_edges(places).value());
    file.dataset(group + "/drive", drive, "");
    file.texts(group + "/drive", "places", names);
    file.dataset(group + "/middle", middle, "m");
    file.dataset(group + "/radius", radius, "m");
    file.dataset(group + "/edge_length", edge_length, "m");
}

void write_tool_comparison(hdf5::OutputFile &file, const std::string &group, const core::ToolComparison &tool) {
    std::vector<std::string> names;
    std::vector<double> stiffness, relative_l2, path;
    for (const auto &place : tool.places) {
        names.push_back(place.name);
        stiffness.push_back(place.stiffness);
        relative_l2.push_back(place.relative_l2);
    }
    for (std::size_t k = 0; k < tool.places.front().path.size(); ++k)
        for (const auto &place : tool.places)
            path.push_back(place.path[k]);
    file.number(group, "stiffness_at_tool", tool.stiffness());
    file.number(group, "relative_l2_at_tool", tool.worst_place().relative_l2);
    file.text(group, "tool", tool.worst_place().name);
    file.group(group + "/tool");
    file.dataset(group + "/tool/stiffness", stiffness, "");
    file.texts(group + "/tool/stiffness", "places", names);
    file.dataset(group + "/tool/relative_l2", relative_l2, "");
    if (path.empty())
        return;
    file.number(group, "worst_stiffness_at_tool", tool.worst_stiffness());
    file.blocks(group + "/tool/path", path, tool.places.size(), "");
}

core::ToolComparison read_tool_comparison(const hdf5::InputFile &file, const std::string &group,
                                          const core::LoadCase &load_case) {
    const auto names = file.texts(group + "/tool/stiffness", "places");
    if (names.empty())
        file.refuse(group + "/tool/stiffness", "attribute places is empty");
    const auto stiffness = file.dataset<double>(group + "/tool/stiffness", names.size());
    const auto relative_l2 = file.dataset<double>(group + "/tool/relative_l2", names.size());
    std::vector<double> path;
    if (file.has(group + "/tool/path"))
        path = file.blocks<double>(group + "/tool/path", names.size());
    const auto num_points = path.size() / names.size();
    if (num_points > load_case.num_path_points())
        file.refuse(group + "/tool/path",
                    fmt::format("has {} points, and /load_case/path {}", num_points, load_case.num_path_points()));
    core::ToolComparison tool;
    for (std::size_t g = 0; g < names.size(); ++g) {
        auto &place = tool.places.emplace_back();
        place.name = names[g];
        place.stiffness = stiffness[g];
        place.relative_l2 = relative_l2[g];
        for (std::size_t k = 0; k < num_points; ++k)
            place.path.push_back(path[k * names.size() + g]);
    }
    return tool;
}

} // namespace livermark::results
