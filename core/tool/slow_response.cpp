#include "core/tool/slow_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/tool/tool_stiffness.hpp"

namespace livermark::core {

namespace {

constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

/// Along which a place is moved: the mean of what its facets prescribe, weighted with their areas.
Vector3 way_of_place(const TetraMesh &mesh, const LoadCase &load_case, const ToolPlace &place) {
    Vector3 way = Vector3::Zero();
    for (const int facet : place.facets)
        way += area_vector(mesh, facet).norm() *
               load_case.value[facet].array().isNaN().select(0.0, load_case.value[facet].array()).matrix();
    return way.normalized();
}

std::vector<double> forces_along(const Vector3 &way, int constraint, const Solution &solution) {
    std::vector<double> values;
    for (const auto &point : solution.path)
        values.push_back(point.reaction[constraint].dot(way));
    return values;
}

std::vector<double> mean_displacements(const TetraMesh &mesh, const LoadCase &load_case, const ToolPlace &place,
                                       const Solution &solution) {
    const auto forces = nodal_forces(mesh, load_case, place);
    double sum = 0.0;
    for (const auto &[node, force] : forces)
        sum += force.norm();
    std::vector<double> values;
    for (const auto &point : solution.path)
        values.push_back(work_of(forces, point.displacement) / sum);
    return values;
}

double median_of(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
}

} // namespace

std::vector<SlowResponse> slow_responses(const TetraMesh &mesh, const LoadCase &load_case, const Solution &solution) {
    std::vector<SlowResponse> responses;
    for (const auto &place : tool_places(mesh, load_case)) {
        auto &response = responses.emplace_back();
        response.place = place.name;
        response.is_force = place.drive != ToolDrive::traction;
        response.values = response.is_force
                              ? forces_along(way_of_place(mesh, load_case, place), place.constraint, solution)
                              : mean_displacements(mesh, load_case, place, solution);
    }
    return responses;
}

namespace {

/// Below this part of what is stored at most, heat is rounding.
constexpr double smallest_heat = 1e-9;

using PathEnergy = double (*)(const PathPoint &);

/// Summed by the model itself, exactly for strains that are linear in time over its steps.
double dissipated_at(const PathPoint &point) {
    return point.dissipated_energy;
}

/// Heat where that is not known: the work of what drives the body less what it stores.
double balance_at(const PathPoint &point) {
    return point.work - point.strain_energy;
}

/// Gain of an energy in the last cycle; NaN without cycles, and where the way ended early.
double gain_in_last_cycle(const SlowHistory &history, const Solution &solution, PathEnergy energy) {
    if (!history.last_cycle || static_cast<int>(solution.path.size()) != history.num_records())
        return not_known;
    return energy(solution.path.back()) - energy(solution.path[*history.last_cycle]);
}

/// Ratio of the heat of both, by the same rule, minus one.
double heat_error(const SlowHistory &history, const Solution &solution, const Solution &reference) {
    const bool is_summed = !std::isnan(gain_in_last_cycle(history, solution, dissipated_at)) &&
                           !std::isnan(gain_in_last_cycle(history, reference, dissipated_at));
    const auto energy = is_summed ? dissipated_at : balance_at;
    const double expected = gain_in_last_cycle(history, reference, energy);
    double most_stored = 0.0;
    for (const auto &point : reference.path)
        most_stored = std::max(most_stored, std::abs(point.strain_energy));
    return std::abs(expected) > smallest_heat * most_stored
               ? gain_in_last_cycle(history, solution, energy) / expected - 1.0
               : not_known;
}

} // namespace

double lost_energy(const SlowHistory &history, const Solution &solution) {
    const double summed = gain_in_last_cycle(history, solution, dissipated_at);
    return std::isnan(summed) ? gain_in_last_cycle(history, solution, balance_at) : summed;
}

std::optional<SlowComparison> compare_slow_histories(const TetraMesh &mesh, const LoadCase &load_case,
                                                     const Solution &solution, const Solution &reference) {
    if (!load_case.slow_history || reference.path.size() != load_case.slow_history->times.size())
        return std::nullopt;
    const auto found = slow_responses(mesh, load_case, solution);
    const auto expected = slow_responses(mesh, load_case, reference);
    if (found.empty())
        return std::nullopt;
    SlowComparison result{.median_error = not_known, .worst_error = not_known, .place = found.front().place};
    result.lost_energy = heat_error(*load_case.slow_history, solution, reference);
    if (solution.path.size() != reference.path.size())
        return result;
    for (std::size_t g = 0; g < found.size(); ++g) {
        double largest = 0.0;
        std::vector<double> errors;
        for (std::size_t k = 0; k < found[g].values.size(); ++k) {
            largest = std::max(largest, std::abs(expected[g].values[k]));
            errors.push_back(std::abs(found[g].values[k] - expected[g].values[k]));
        }
        const bool is_known =
            largest > 0.0 && std::ranges::none_of(errors, [](double error) { return std::isnan(error); });
        const double worst = is_known ? *std::ranges::max_element(errors) / largest : not_known;
        if (std::isnan(result.worst_error) || worst > result.worst_error) {
            result.worst_error = worst;
            result.median_error = is_known ? median_of(errors) / largest : not_known;
            result.place = found[g].place;
        }
    }
    return result;
}

} // namespace livermark::core
