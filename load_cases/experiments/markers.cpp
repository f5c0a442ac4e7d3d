#include "load_cases/experiments/markers.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <set>
#include <sstream>
#include <string_view>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "load_cases/places/selector.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

constexpr std::size_t first_state_column = 5;
constexpr const char *expected_header = "marker,drives,x,y,z and <state>_x,<state>_y,<state>_z for each state";

std::string trimmed(const std::string &cell) {
    constexpr const char *blanks = " \t\r\"";
    const auto first = cell.find_first_not_of(blanks);
    return first == std::string::npos ? "" : cell.substr(first, cell.find_last_not_of(blanks) - first + 1);
}

} // namespace

std::vector<CsvRow> read_csv(const std::filesystem::path &file) {
    std::istringstream text(support::read_text(file));
    std::vector<CsvRow> rows;
    std::string line, cell;
    for (int number = 1; std::getline(text, line); ++number) {
        CsvRow row{fmt::format("{}:{}", file.string(), number), {}};
        std::istringstream cells(line + ",");
        while (std::getline(cells, cell, ','))
            row.cells.push_back(trimmed(cell));
        if (!std::ranges::all_of(row.cells, &std::string::empty))
            rows.push_back(std::move(row));
    }
    return rows;
}

double number_in(const CsvRow &row, std::size_t column) {
    double number = 0.0;
    std::string_view text = row.cells.at(column);
    if (text.starts_with('+') && !text.starts_with("+-"))
        text.remove_prefix(1); // which from_chars does not know
    const auto [next, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || next != text.data() + text.size() || !std::isfinite(number))
        throw support::InputError("{}: '{}' in column {} is not a finite number; correct the line", row.place,
                                  support::shown(text), column + 1);
    return number;
}

namespace {

/// The states that a header names.
std::vector<std::string> states_of(const CsvRow &header) {
    const auto refuse = [&] {
        throw support::InputError("{}: the first line of a table of markers is {}; correct it", header.place,
                                  expected_header);
    };
    const auto &cells = header.cells;
    if (cells.size() < first_state_column + 3 || (cells.size() - first_state_column) % 3 != 0 ||
        !std::ranges::equal(std::vector<std::string>{"marker", "drives", "x", "y", "z"},
                            std::vector(cells.begin(), cells.begin() + first_state_column)))
        refuse();
    std::vector<std::string> states;
    for (std::size_t c = first_state_column; c < cells.size(); c += 3) {
        const auto name = cells[c].substr(0, std::max<std::size_t>(cells[c].size(), 2) - 2);
        for (std::size_t i = 0; i < 3; ++i)
            if (name.empty() || cells[c + i] != fmt::format("{}_{}", name, "xyz"[i]))
                refuse();
        if (std::ranges::find(states, name) != states.end())
            throw support::InputError("{}: state '{}' occurs twice; rename one", header.place, name);
        states.push_back(name);
    }
    return states;
}

Vector3 position_in(const CsvRow &row, std::size_t column, double metres) {
    return metres * Vector3(number_in(row, column), number_in(row, column + 1), number_in(row, column + 2));
}

bool is_empty(const CsvRow &row, std::size_t column) {
    return row.cells[column].empty() && row.cells[column + 1].empty() && row.cells[column + 2].empty();
}

constexpr std::size_t fewest_rows = 16;
constexpr double rounding_of_intervals = 0.01; ///< of an interval, that a time may be off

/// The column of each marker's x.
std::vector<std::size_t> columns_of(const CsvRow &header, std::span<const Marker> markers) {
    const auto refuse = [&](const std::string &fault) {
        throw support::InputError(
            "{}: {}; the first line is time, and <marker>_x, <marker>_y, <marker>_z of each marker", header.place,
            fault);
    };
    if (header.cells.front() != "time" || header.cells.size() != 1 + 3 * markers.size())
        refuse(fmt::format("there are {} columns of {} markers over time", header.cells.size(), markers.size()));
    std::vector<std::size_t> columns;
    for (const auto &marker : markers) {
        const auto at = std::ranges::find(header.cells, marker.name + "_x");
        const auto column = static_cast<std::size_t>(at - header.cells.begin());
        if (column + 2 >= header.cells.size() || header.cells[column + 1] != marker.name + "_y" ||
            header.cells[column + 2] != marker.name + "_z")
            refuse(fmt::format("marker '{}' has no columns", marker.name));
        columns.push_back(column);
    }
    return columns;
}

} // namespace

MarkerTable read_markers(const std::filesystem::path &file, double metres_per_unit) {
    const auto rows = read_csv(file);
    if (rows.size() < 2)
        throw support::InputError("{}: there are no markers; give a line of {}, and a line for each marker",
                                  file.string(), expected_header);
    MarkerTable table;
    table.states = states_of(rows.front());
    table.displacement.resize(table.states.size());
    std::set<std::string> names;
    for (auto row = rows.begin() + 1; row != rows.end(); ++row) {
        if (row->cells.size() != rows.front().cells.size())
            throw support::InputError("{}: the line has {} cells and the first line {}; correct it", row->place,
                                      row->cells.size(), rows.front().cells.size());
        const auto &name = row->cells[0];
        if (name.empty() || !names.insert(name).second)
            throw support::InputError("{}: marker '{}' has an empty or repeated name; give each line its own",
                                      row->place, support::shown(name));
        table.names.push_back(name);
        table.drives.push_back(row->cells[1]);
        table.rest.push_back(position_in(*row, 2, metres_per_unit));
        for (std::size_t s = 0; s < table.states.size(); ++s) {
            const std::size_t column = first_state_column + 3 * s;
            const bool is_seen = !is_empty(*row, column);
            if (!is_seen && !table.drives.back().empty())
                throw support::InputError("{}: marker '{}' drives a place and has no position in state '{}'; give it, "
                                          "or leave the marker out",
                                          row->place, support::shown(name), table.states[s]);
            table.displacement[s].push_back(
                is_seen ? Vector3(position_in(*row, column, metres_per_unit) - table.rest.back())
                        : Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
        }
    }
    return table;
}

MarkerMotion read_motion(const std::filesystem::path &file, std::span<const Marker> markers, double metres_per_unit) {
    const auto rows = read_csv(file);
    if (rows.size() < 1 + fewest_rows)
        throw support::InputError("{}: a motion has at least {} records, and here are {}; record for longer",
                                  file.string(), fewest_rows, rows.empty() ? 0 : rows.size() - 1);
    const auto columns = columns_of(rows.front(), markers);
    MarkerMotion motion{0.0, static_cast<int>(markers.size()), {}};
    double start = 0.0;
    for (std::size_t r = 1; r < rows.size(); ++r) {
        const auto &row = rows[r];
        if (row.cells.size() != rows.front().cells.size())
            throw support::InputError("{}: the line has {} cells and the first line {}; correct it", row.place,
                                      row.cells.size(), rows.front().cells.size());
        const double time = number_in(row, 0);
        const auto steps = static_cast<double>(r - 1);
        if (r == 1)
            start = time;
        else if (r == 2)
            motion.interval = time - start;
        if (r >= 2 && !(motion.interval > 0.0 && std::abs(time - start - steps * motion.interval) <
                                                     rounding_of_intervals * motion.interval * steps))
            throw support::InputError("{}: times are not evenly spaced; interpolate the records to equal intervals",
                                      row.place);
        for (std::size_t k = 0; k < markers.size(); ++k)
            motion.displacement.emplace_back(metres_per_unit * Vector3(number_in(row, columns[k]),
                                                                       number_in(row, columns[k] + 1),
                                                                       number_in(row, columns[k] + 2)) -
                                             markers[k].position);
    }
    const auto last = static_cast<double>(rows.size() - 2);
    motion.interval = (number_in(rows.back(), 0) - start) / last; // of many, so that rounding of one does not count
    return motion;
}

namespace {

using Gradient = Eigen::Matrix3d;

Vector3 point_in(const core::TetraMesh &mesh, const std::array<int, 4> &nodes, const Eigen::Vector4d &coordinates) {
    Vector3 point = Vector3::Zero();
    for (int k = 0; k < 4; ++k)
        point += coordinates[k] * mesh.points[nodes[k]];
    return point;
}

/// (N) gradient of the displacement at each node: row i is the gradient of component i
std::vector<Gradient> nodal_gradients(const core::TetraMesh &mesh, std::span<const Vector3> displacement) {
    std::vector<Gradient> sum(mesh.points.size(), Gradient::Zero());
    std::vector<double> volume(mesh.points.size(), 0.0);
    for (const auto &nodes : mesh.tetrahedra) {
        Gradient differences;
        for (int k = 0; k < 3; ++k)
            differences.col(k) = displacement[nodes[k + 1]] - displacement[nodes[0]];
        const Gradient gradient = differences * core::coordinate_gradients(mesh, nodes).transpose();
        const double size = core::signed_volume(mesh.points[nodes[0]], mesh.points[nodes[1]], mesh.points[nodes[2]],
                                                mesh.points[nodes[3]]);
        for (const int node : nodes) {
            sum[node] += size * gradient;
            volume[node] += size;
        }
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] /= volume[i];
    return sum;
}

} // namespace

MarkerField::MarkerField(const core::TetraMesh &mesh, std::span<const Vector3> points) : mesh_(&mesh) {
    for (const auto &point : points) {
        places_.push_back(find(point));
        outside_.push_back(places_.back().peg.norm());
    }
}

MarkerField::Place MarkerField::find(const Vector3 &point) const {
    if (const auto at = core::locate(*mesh_, point); at.is_inside())
        return {at, Vector3::Zero()};
    const Vector3 base = load_cases::nearest_point(load_cases::all_facets(*mesh_), *mesh_, point).point;
    return {core::locate(*mesh_, base), point - base};
}

std::vector<int> MarkerField::nodes() const {
    std::set<int> corners, all; // gradients are of all tetrahedra at a corner
    for (const auto &place : places_)
        corners.insert(mesh_->tetrahedra[place.at.tetrahedron].begin(), mesh_->tetrahedra[place.at.tetrahedron].end());
    for (const auto &nodes : mesh_->tetrahedra)
        if (std::ranges::any_of(nodes, [&](int node) { return corners.contains(node); }))
            all.insert(nodes.begin(), nodes.end());
    return {all.begin(), all.end()};
}

std::vector<Vector3> MarkerField::at_points(std::span<const Vector3> displacement) const {
    const auto gradients = nodal_gradients(*mesh_, displacement);
    std::vector<Vector3> result;
    for (const auto &place : places_) {
        const auto &nodes = mesh_->tetrahedra[place.at.tetrahedron];
        const Vector3 point = point_in(*mesh_, nodes, place.at.coordinates);
        Vector3 &u = result.emplace_back(Vector3::Zero());
        for (int k = 0; k < 4; ++k) {
            const auto &gradient = gradients[nodes[k]];
            u += place.at.coordinates[k] *
                 (displacement[nodes[k]] + 0.5 * gradient * (point - mesh_->points[nodes[k]]) + gradient * place.peg);
        }
    }
    return result;
}

} // namespace livermark::experiments
