#include "studies/exchange/formats/export_format.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <sstream>
#include <string_view>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"

namespace livermark::exchange {

namespace {

/// The corners of each midpoint of a C3D10, in CalculiX's order.
constexpr std::array<std::array<int, 2>, 6> midpoint_corners{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};

} // namespace

using core::Vector3;

Discretisation discretise(const core::TetraMesh &mesh, int degree) {
    Discretisation fem{mesh.points, {}, {}};
    const auto table = core::edge_table(mesh.tetrahedra);
    const auto midpoint = [&](int a, int b) {
        const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
        return mesh.num_nodes() + static_cast<int>(std::ranges::lower_bound(table.edges, edge) - table.edges.begin());
    };
    if (degree == 2)
        for (const auto &[a, b] : table.edges)
            fem.points.emplace_back(0.5 * (mesh.points[a] + mesh.points[b]));
    for (const auto &corners : mesh.tetrahedra) {
        auto &nodes = fem.elements.emplace_back(corners.begin(), corners.end());
        if (degree == 2)
            for (const auto &[a, b] : midpoint_corners)
                nodes.push_back(midpoint(corners[a], corners[b]));
    }
    for (const auto &corners : mesh.boundary_triangles) {
        auto &nodes = fem.facets.emplace_back(corners.begin(), corners.end());
        if (degree == 2)
            for (int v = 0; v < 3; ++v)
                nodes.push_back(midpoint(corners[v], corners[(v + 1) % 3]));
    }
    return fem;
}

std::vector<Vector3> prescribed_displacement(const core::LoadCase &load_case, const Discretisation &fem) {
    std::vector<Vector3> value(fem.points.size(), Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    for (int constraint = 0; constraint < load_case.num_constraints(); ++constraint)
        for (int f = 0; f < load_case.num_facets(); ++f)
            if (load_case.constraint_on(f) == constraint && !load_case.presses(f))
                for (std::size_t k = 0; k < fem.facets[f].size(); ++k) {
                    const auto &nodes = fem.facets[f];
                    const int a = nodes[k % 3], b = k < 3 ? a : nodes[(k + 1) % 3];
                    const Vector3 prescribed = 0.5 * (load_case.prescribed_at(f, a) + load_case.prescribed_at(f, b));
                    for (int i = 0; i < 3; ++i)
                        if (std::isnan(value[nodes[k]][i]))
                            value[nodes[k]][i] = prescribed[i];
                }
    return value;
}

std::vector<Vector3> traction_forces(const core::TetraMesh &mesh, const core::LoadCase &load_case,
                                     const Discretisation &fem) {
    std::vector<Vector3> force(fem.points.size(), Vector3::Zero());
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f)) {
            const Vector3 whole = core::area_vector(mesh, f).norm() * load_case.value[f];
            const auto *load = load_case.round_load_on(f);
            const auto corners = core::corners_of(mesh, f);
            const auto &nodes = fem.facets[f];
            const auto share = [&](const auto &parts) {
                for (std::size_t k = 0; k < parts.size(); ++k)
                    for (int i = 0; i < 3; ++i)
                        if (!std::isnan(whole[i]))
                            force[nodes[k]][i] += parts[k] * whole[i];
            };
            nodes.size() == 3 ? share(core::linear_parts(load, corners)) : share(core::quadratic_parts(load, corners));
        }
    return force;
}

std::vector<Vector3> nodal_forces(const core::Problem &problem, const Discretisation &fem) {
    const auto &mesh = problem.body->mesh;
    auto force = traction_forces(mesh, problem.load_case, fem);
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        for (const int node : mesh.tetrahedra[t])
            force[node] +=
                0.25 * problem.body->materials[mesh.region[t]].density * volumes[t] * problem.load_case.acceleration;
    return force;
}

} // namespace livermark::exchange

namespace livermark::studies {

namespace {

using core::Vector3;

constexpr std::string_view header = "x,y,z,ux,uy,uz";
/// Distance of a point from its node, over the size of the mesh: coordinates may have been written with six digits.
/// Nodes are a thousand times as far apart.
constexpr double largest_distance = 1e-5;

std::string without_blanks(std::string line) {
    std::erase_if(line, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; });
    return line;
}

std::array<double, 6> six_numbers(const std::string &line, const std::string &place) {
    std::array<double, 6> numbers{};
    const char *at = line.data();
    const char *const end = line.data() + line.size();
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        if (end - at > 1 && at[0] == '+' && at[1] != '-')
            ++at; // which from_chars does not know
        const auto [next, error] = std::from_chars(at, end, numbers[k]);
        const bool is_last = k + 1 == numbers.size();
        if (error != std::errc{} || !std::isfinite(numbers[k]) || (is_last ? next != end : next == end || *next != ','))
            throw support::InputError(fmt::format("{}: '{}' is not six finite numbers x,y,z,ux,uy,uz; correct the line",
                                                  place, support::shown(line)));
        at = next + (is_last ? 0 : 1);
    }
    return numbers;
}

std::string guess_of_fault(const OutsideSolution &solution, const core::TetraMesh &mesh) {
    const double ratio = core::extent(solution.points) / core::extent(mesh.points);
    constexpr double close = 0.05;
    for (const auto &[factor, unit] : {std::pair{1000.0, "millimetres"}, {100.0, "centimetres"}})
        if (std::abs(ratio / factor - 1.0) < close)
            return fmt::format("it seems to be in {}; give metres", unit);
    return "it belongs to another mesh; take the one of `livermark export`";
}

} // namespace

OutsideSolution parse_outside_solution(const std::string &text, const std::string &file) {
    std::istringstream stream(text);
    std::string line;
    if (!std::getline(stream, line) || without_blanks(line) != header)
        throw support::InputError(fmt::format("{}:1: the first line has to be {}; add it", file, header));
    OutsideSolution solution;
    for (int number = 2; std::getline(stream, line); ++number) {
        line = without_blanks(line);
        if (line.empty())
            continue;
        const auto values = six_numbers(line, fmt::format("{}:{}", file, number));
        solution.points.emplace_back(values[0], values[1], values[2]);
        solution.displacement.emplace_back(values[3], values[4], values[5]);
    }
    if (solution.points.empty())
        throw support::InputError(fmt::format("{}: there are no nodes in it; give a line for each", file));
    return solution;
}

OutsideSolution read_outside_solution(const std::filesystem::path &file) {
    support::check_readable(file);
    if (support::file_ending(file) == ".csv")
        return parse_outside_solution(support::read_text(file), file.string());
    const auto converted = support::convert_by_script("convert_solution", file,
                                                      "give CSV, HDF5 or VTU with the displacement of the nodes");
    return parse_outside_solution(converted.text, file.string());
}

std::vector<Vector3> displacement_at_nodes(const OutsideSolution &solution, const core::TetraMesh &mesh,
                                           const std::string &file) {
    std::vector<int> by_x(solution.points.size());
    std::iota(by_x.begin(), by_x.end(), 0);
    const auto x_of = [&](int i) { return solution.points[i].x(); };
    std::ranges::sort(by_x, {}, x_of);
    const double reach = largest_distance * core::extent(mesh.points);
    std::vector<Vector3> displacement;
    displacement.reserve(mesh.points.size());
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        const auto &point = mesh.points[node];
        int found = -1;
        for (auto at = std::ranges::lower_bound(by_x, point.x() - reach, {}, x_of);
             at != by_x.end() && x_of(*at) <= point.x() + reach; ++at) {
            if ((solution.points[*at] - point).norm() > reach)
                continue;
            if (found >= 0 && solution.displacement[found] != solution.displacement[*at])
                throw support::InputError(
                    fmt::format("{}: there are two displacements for the node at ({:g}, {:g}, {:g}) m; "
                                "keep one",
                                file, point.x(), point.y(), point.z()));
            found = *at;
        }
        if (found < 0)
            throw support::InputError(
                fmt::format("{}: there is no displacement for node {} at ({:g}, {:g}, {:g}) m; {}", file, node,
                            point.x(), point.y(), point.z(), guess_of_fault(solution, mesh)));
        displacement.push_back(solution.displacement[found]);
    }
    return displacement;
}

} // namespace livermark::studies
