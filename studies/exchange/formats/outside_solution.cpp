#include "studies/exchange/formats/outside_solution.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <sstream>
#include <string_view>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"

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
