#include "meshes/io/vessel_files.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <locale>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

namespace livermark::meshes {

namespace {

/// One line of an SWC file.
struct SwcPoint {
    std::int64_t number = 0, parent = 0;
    core::Vector3 place = core::Vector3::Zero(); ///< in the unit of the file
    double radius = 0.0;
};

/// @return nothing for what is no such line
std::optional<SwcPoint> point_of(const std::string &line) {
    std::istringstream words(line);
    words.imbue(std::locale::classic());
    SwcPoint point;
    double kind = 0.0;
    std::string rest;
    if (!(words >> point.number >> kind >> point.place[0] >> point.place[1] >> point.place[2] >> point.radius >>
          point.parent) ||
        words >> rest)
        return std::nullopt;
    return point.place.allFinite() && std::isfinite(point.radius) ? std::optional(point) : std::nullopt;
}

/// The numbers of lines, for messages, and the points there.
std::vector<std::pair<std::size_t, SwcPoint>> lines_of(const std::filesystem::path &file) {
    std::istringstream text(support::read_text(file));
    std::vector<std::pair<std::size_t, SwcPoint>> points;
    std::size_t number = 0;
    for (std::string line; std::getline(text, line);) {
        ++number;
        const auto first = line.find_first_not_of(" \t\r");
        if (first == std::string::npos || line[first] == '#')
            continue;
        const auto point = point_of(line);
        if (!point)
            throw support::InputError("{}: line {} is '{}'; give number, kind, x, y, z, radius and the number of the "
                                      "point before, as SWC files have them",
                                      file.string(), number, support::shown(line));
        if (!(point->radius > 0.0))
            throw support::InputError("{}: the radius in line {} is {:g}; it has to be positive", file.string(), number,
                                      point->radius);
        points.emplace_back(number, *point);
    }
    return points;
}

} // namespace

core::VesselTree read_swc(const std::filesystem::path &file, double metres) {
    const auto lines = lines_of(file);
    core::VesselTree tree{
        .points = {}, .radius = {}, .segments = {}, .wall_ratio = usual_wall_ratio, .wall_modulus = usual_wall_modulus};
    std::map<std::int64_t, int> place;
    for (const auto &[line, point] : lines) {
        if (!place.emplace(point.number, static_cast<int>(tree.points.size())).second)
            throw support::InputError("{}: line {} is the second of a point {}; number each once", file.string(), line,
                                      point.number);
        tree.points.emplace_back(metres * point.place);
        tree.radius.push_back(metres * point.radius);
    }
    for (const auto &[line, point] : lines) {
        if (point.parent < 0)
            continue;
        const auto before = place.find(point.parent);
        if (before == place.end() || point.parent == point.number)
            throw support::InputError("{}: line {} says that point {} is behind point {}; name another one of the "
                                      "file, or -1 for a root",
                                      file.string(), line, point.number, point.parent);
        tree.segments.push_back({before->second, place.at(point.number)});
        if (!(tree.length(tree.segments.size() - 1) > 0.0))
            throw support::InputError("{}: line {} has its point where the one before it is; leave it out",
                                      file.string(), line);
    }
    if (tree.segments.empty())
        throw support::InputError("{}: it has no two points that a vessel joins; give the last number of each line",
                                  file.string());
    return tree;
}

double length_of(const core::VesselTree &tree) {
    double length = 0.0;
    for (std::size_t s = 0; s < tree.segments.size(); ++s)
        length += tree.length(s);
    return length;
}

std::string swc_text(const core::VesselTree &tree, const std::string &comment) {
    std::vector<int> parent(tree.points.size(), -1);
    for (const auto &[a, b] : tree.segments) {
        if (parent[static_cast<std::size_t>(b)] >= 0)
            throw std::invalid_argument("a point of the vessels ends two segments");
        parent[static_cast<std::size_t>(b)] = a;
    }
    auto text = fmt::format("# {}\n# number, kind, x, y, z, radius [m], number of the point before\n", comment);
    for (std::size_t p = 0; p < parent.size(); ++p)
        text += fmt::format("{} 0 {:.6g} {:.6g} {:.6g} {:.6g} {}\n", p + 1, tree.points[p].x(), tree.points[p].y(),
                            tree.points[p].z(), tree.radius[p], parent[p] < 0 ? -1 : parent[p] + 1);
    return text;
}

namespace {

/// Modulus of a wall that is believed [Pa].
constexpr double softest_wall = 100.0, stiffest_wall = 1e9;
constexpr double least_part_inside = 0.5;

std::string sentence_on(const core::VesselTree &tree, double inside, const std::string &file) {
    const auto [thin, thick] = std::ranges::minmax(tree.radius);
    auto sentence =
        fmt::format("vessels of {} are lines of {:.2g} to {:.2g} mm radius, {:.3g} m together, with walls "
                    "of {:g} of that and {:g} kPa",
                    file, 1e3 * thin, 1e3 * thick, length_of(tree), tree.wall_ratio, 1e-3 * tree.wall_modulus);
    if (inside < 0.9995)
        sentence +=
            fmt::format("; {:.1f} % of their length is outside the body and does nothing", 100.0 * (1.0 - inside));
    return sentence;
}

} // namespace

void read_vessels(const std::filesystem::path &body_file, const toml::table &table, double metres, core::Body &body) {
    support::refuse_unknown_keys(table, {"file", "unit", "wall_ratio", "wall_modulus", "source"});
    if (table.contains("source"))
        support::required_string(table, "source");
    const auto file = body_file.parent_path() / support::required_string(table, "file");
    auto tree = read_swc(file, table.contains("unit") ? support::metres_per_unit(table) : metres);
    if (table.contains("wall_ratio"))
        tree.wall_ratio = support::required_number(table, "wall_ratio");
    if (table.contains("wall_modulus"))
        tree.wall_modulus = support::required_number(table, "wall_modulus");
    if (!(tree.wall_ratio > 0.0 && tree.wall_ratio <= 1.0))
        support::refuse(table,
                        "'wall_ratio' is {:g}; give the thickness of the wall over the radius, above 0 and 1 at "
                        "most",
                        tree.wall_ratio);
    if (!(tree.wall_modulus >= softest_wall && tree.wall_modulus <= stiffest_wall))
        support::refuse(table, "'wall_modulus' is {:g} Pa; give one from {:g} to {:g} Pa", tree.wall_modulus,
                        softest_wall, stiffest_wall);
    body.vessels = std::move(tree);
    const double inside = core::part_inside(body);
    if (!(inside >= least_part_inside))
        throw support::InputError("{}: {:.0f} % of the length of its vessels is outside the body; give 'unit' in "
                                  "[vessels] if they are in another one, or vessels in the axes of the mesh",
                                  file.string(), 100.0 * (1.0 - inside));
    body.assumptions.push_back(sentence_on(*body.vessels, inside, file.filename().string()));
}

} // namespace livermark::meshes
