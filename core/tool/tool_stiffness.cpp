#include "core/tool/tool_stiffness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace livermark::core {

namespace {

constexpr double no_stiffness = std::numeric_limits<double>::quiet_NaN();

/// Part of what its forces could do on the displacements of their nodes, below which the work of a traction is
/// rounding.
constexpr double smallest_work = 1e-6;

bool is_prescribed_to_move(const LoadCase &load_case, int facet) {
    return load_case.is_constrained(facet) &&
           std::ranges::any_of(load_case.value[facet], [](double value) { return value < 0.0 || value > 0.0; });
}

ToolDrive drive_by(ConditionKind kind) {
    switch (kind) {
    case ConditionKind::traction:
    case ConditionKind::pressure:
        return ToolDrive::traction;
    case ConditionKind::press:
    case ConditionKind::touch:
        return ToolDrive::depth;
    case ConditionKind::displacement:
        return ToolDrive::displacement;
    }
    throw std::logic_error("unknown kind of condition");
}

/// Middle, radius and edge length of a place from its facets.
void measure(const TetraMesh &mesh, const LoadCase &load_case, ToolPlace &place) {
    double area = 0.0, edges = 0.0;
    Vector3 moment = Vector3::Zero();
    for (const int facet : place.facets) {
        const auto [a, b, c] = corners_of(mesh, facet);
        const double part = area_vector(mesh, facet).norm();
        area += part;
        moment += part * (a + b + c) / 3.0;
        edges += (a - b).norm() + (b - c).norm() + (c - a).norm();
    }
    place.edge_length = edges / (3.0 * static_cast<double>(place.facets.size()));
    place.middle = moment / area;
    place.radius = std::sqrt(area / std::numbers::pi);
    if (const auto *round = load_case.round_load_on(place.facets.front())) {
        place.middle = round->middle;
        place.radius = round->radius;
    }
}

/// The place that a tool sinks into which touches.
ToolPlace touched_place(const TetraMesh &mesh, const LoadCase &load_case, const ExpectedContact &contact) {
    const auto &[constraint, first, radius, press, pressed_at, grows] = contact;
    ToolPlace place{
        .name = load_case.constraint_names()[constraint], .drive = ToolDrive::depth, .constraint = constraint};
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int f = 0; f < load_case.num_facets(); ++f) {
        if (!load_case.may_touch(f))
            continue;
        const double distance = (point_at(corners_of(mesh, f), Vector3::Constant(1.0 / 3.0)) - first).norm();
        if (distance < radius)
            place.facets.push_back(f);
        if (distance < least) {
            least = distance;
            nearest = f;
        }
    }
    if (place.facets.empty() && nearest >= 0)
        place.facets.push_back(nearest);
    if (place.facets.empty())
        return place;
    measure(mesh, load_case, place);
    place.middle = first;
    place.radius = radius;
    return place;
}

/// Errors at a place with a given traction.
/// @param ratio  of the corrections of the reference and of the solution
void compare_works(const TetraMesh &mesh, const LoadCase &load_case, const ToolPlace &place, const Solution &solution,
                   const Solution &reference, double ratio, PlaceErrors &errors) {
    const auto forces = nodal_forces(mesh, load_case, place);
    /// Work of the reference over that of the solution.
    const auto ratio_of = [&](const auto &reference_field, const auto &solution_field) {
        double possible = 0.0;
        for (const auto &[node, force] : forces)
            possible += force.norm() * static_cast<double>(reference_field[node].norm());
        const double work = work_of(forces, reference_field);
        return std::abs(work) > smallest_work * possible ? work / work_of(forces, solution_field) : no_stiffness;
    };
    const double at_end = ratio_of(reference.displacement, solution.displacement);
    errors.stiffness = ratio * at_end - 1.0;
    const auto num_points = load_case.slow_history ? 0 : std::min(solution.path.size(), reference.path.size());
    for (std::size_t k = 0; k < num_points; ++k)
        errors.path.push_back(std::isnan(at_end)
                                  ? no_stiffness
                                  : ratio_of(reference.path[k].displacement, solution.path[k].displacement) - 1.0);
}

/// Errors at a place whose force is a result.
void compare_forces(int constraint, std::size_t num_points, const Solution &solution, const Solution &reference,
                    double smallest_force, PlaceErrors &errors) {
    const auto along = [](const Vector3 &force, const Vector3 &reference_field) {
        return force.dot(reference_field) / reference_field.squaredNorm() - 1.0;
    };
    const auto has_force = [&](const Vector3 &reference_field) { return reference_field.norm() > smallest_force; };
    const bool ends_with_force = has_force(reference.reaction[constraint]);
    errors.stiffness =
        ends_with_force ? along(solution.reaction[constraint], reference.reaction[constraint]) : no_stiffness;
    for (std::size_t k = 0; k < num_points; ++k) {
        const Vector3 &expected = reference.path[k].reaction[constraint];
        errors.path.push_back(has_force(expected) ? along(solution.path[k].reaction[constraint], expected)
                                                  : no_stiffness);
    }
}

/// Relative L2 error over the nodes around a place.
double error_around(const TetraMesh &mesh, std::span<const double> volumes, const ToolPlace &place,
                    const Solution &solution, const Solution &reference) {
    double difference = 0.0, total = 0.0;
    for (std::size_t i = 0; i < volumes.size(); ++i)
        if ((mesh.points[i] - place.middle).norm() <= 2.0 * place.radius) {
            difference += volumes[i] * (solution.displacement[i] - reference.displacement[i]).squaredNorm();
            total += volumes[i] * reference.displacement[i].squaredNorm();
        }
    return total > 0.0 ? std::sqrt(difference / total) : no_stiffness;
}

/// The one of the largest absolute value; a NaN gives way to any number.
double larger_in_size(double a, double b) {
    return std::isnan(a) || std::abs(b) > std::abs(a) ? b : a;
}

} // namespace

std::vector<std::pair<int, Vector3>> nodal_forces(const TetraMesh &mesh, const LoadCase &load_case,
                                                  const ToolPlace &place) {
    std::vector<std::pair<int, Vector3>> forces;
    for (const int facet : place.facets) {
        const auto parts = linear_parts(load_case.round_load_on(facet), corners_of(mesh, facet));
        const Vector3 force = area_vector(mesh, facet).norm() * load_case.value[facet];
        for (std::size_t k = 0; k < 3; ++k)
            forces.emplace_back(mesh.boundary_triangles[facet][k], parts[k] * force);
    }
    return forces;
}

std::vector<ToolPlace> tool_places(const TetraMesh &mesh, const LoadCase &load_case) {
    std::vector<ToolPlace> places; // given loads first
    std::vector<int> place_of(load_case.conditions.size());
    const auto add = [&](bool (Condition::*is_of_kind)() const, bool has_unknown_force) {
        int number = 0;
        for (std::size_t c = 0; c < load_case.conditions.size(); ++c)
            if (const auto &condition = load_case.conditions[c]; (condition.*is_of_kind)()) {
                place_of[c] = static_cast<int>(places.size());
                places.push_back({.name = condition.place,
                                  .drive = drive_by(condition.kind),
                                  .constraint = has_unknown_force ? number++ : -1});
            }
    };
    add(&Condition::is_given_load, false);
    add(&Condition::is_constraint, true);
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.presses(f) || (load_case.is_loaded(f) && !load_case.value[f].isZero(0.0)) ||
            is_prescribed_to_move(load_case, f))
            places[place_of[load_case.condition_on[f]]].facets.push_back(f);
    std::erase_if(places, [](const ToolPlace &place) { return place.facets.empty(); });
    for (auto &place : places)
        measure(mesh, load_case, place);
    for (const auto &contact : load_case.contacts())
        places.push_back(touched_place(mesh, load_case, contact));
    std::erase_if(places, [](const ToolPlace &place) { return place.facets.empty(); });
    return places;
}

std::optional<double> radius_in_edges(std::span<const ToolPlace> places) {
    std::optional<double> smallest;
    for (const auto &place : places) {
        const double ratio = place.radius / place.edge_length;
        smallest = std::min(smallest.value_or(ratio), ratio);
    }
    return smallest;
}

std::vector<double> contact_radii_in_edges(const TetraMesh &mesh, const LoadCase &load_case) {
    std::vector<double> radii;
    for (const auto &contact : load_case.contacts()) {
        const auto place = touched_place(mesh, load_case, contact);
        if (place.facets.empty())
            continue;
        radii.resize(load_case.path.size(), std::numeric_limits<double>::infinity());
        for (std::size_t k = 0; k < radii.size(); ++k) { // Hertz: the radius grows with the root of the depth
            const double grown = contact.grows ? std::sqrt(std::min(1.0, load_case.path[k] / contact.pressed_at)) : 1.0;
            radii[k] = std::min(radii[k], place.radius * grown / place.edge_length);
        }
    }
    return radii;
}

const PlaceErrors &ToolComparison::worst_place() const {
    const auto size = [](const PlaceErrors &place) {
        return std::isnan(place.stiffness) ? -1.0 : std::abs(place.stiffness);
    };
    return *std::ranges::max_element(places, {}, size);
}

std::vector<double> ToolComparison::along_path() const {
    std::vector<double> worst(places.front().path.size(), no_stiffness);
    for (const auto &place : places)
        for (std::size_t k = 0; k < worst.size(); ++k)
            worst[k] = larger_in_size(worst[k], place.path[k]);
    return worst;
}

double ToolComparison::worst_stiffness() const {
    double worst = stiffness();
    if (!std::isnan(worst))
        for (const double value : along_path())
            worst = larger_in_size(worst, value);
    return worst;
}

std::optional<ToolComparison> compare_at_tool(const TetraMesh &mesh, const LoadCase &load_case,
                                              const Solution &solution, const Solution &reference,
                                              double smallest_force) {
    const auto places = tool_places(mesh, load_case);
    if (places.empty())
        return std::nullopt;
    const auto volumes = nodal_volumes(mesh);
    // Works of both are of their own, or those of both are summed at the nodes.
    const double ratio = std::isnan(reference.load_work) ? 1.0
                                                         : work_correction(mesh, load_case, places, reference) /
                                                               work_correction(mesh, load_case, places, solution);
    const auto num_points = load_case.slow_history ? 0 : std::min(solution.path.size(), reference.path.size());
    ToolComparison result;
    for (const auto &place : places) {
        auto &errors = result.places.emplace_back();
        errors.name = place.name;
        errors.relative_l2 = error_around(mesh, volumes, place, solution, reference);
        if (place.drive == ToolDrive::traction)
            compare_works(mesh, load_case, place, solution, reference, ratio, errors);
        else
            compare_forces(place.constraint, num_points, solution, reference, smallest_force, errors);
    }
    return result;
}

namespace {

Vector3 mean_prescribed(const TetraMesh &mesh, const LoadCase &load_case, const ToolPlace &place) {
    Vector3 sum = Vector3::Zero();
    double area = 0.0;
    for (const int facet : place.facets) {
        const double part = area_vector(mesh, facet).norm();
        area += part;
        for (const int node : mesh.boundary_triangles[facet]) {
            const Vector3 prescribed = load_case.prescribed_at(facet, node);
            sum += part / 3.0 * prescribed.array().isNaN().select(0.0, prescribed.array()).matrix();
        }
    }
    return sum / area;
}

} // namespace

double work_correction(const TetraMesh &mesh, const LoadCase &load_case, std::span<const ToolPlace> places,
                       const Solution &solution) {
    double at_nodes = 0.0;
    for (const auto &place : places)
        if (place.drive == ToolDrive::traction)
            at_nodes += work_of(nodal_forces(mesh, load_case, place), solution.displacement);
    return std::isnan(solution.load_work) || at_nodes == 0.0 ? 1.0 : solution.load_work / at_nodes;
}

double stiffness_at(const TetraMesh &mesh, const LoadCase &load_case, std::span<const ToolPlace> places,
                    std::size_t place, const Solution &solution) {
    const auto &tool = places[place];
    if (tool.drive == ToolDrive::depth)
        return solution.reaction[tool.constraint].norm() /
               std::max(load_case.contact_depth(), std::abs(load_case.press_depth));
    if (tool.drive == ToolDrive::displacement) {
        const Vector3 moved = mean_prescribed(mesh, load_case, tool);
        return moved.isZero(0.0) ? no_stiffness : solution.reaction[tool.constraint].dot(moved) / moved.squaredNorm();
    }
    Vector3 resultant = Vector3::Zero();
    double possible = 0.0;
    const auto forces = nodal_forces(mesh, load_case, tool);
    for (const auto &[node, force] : forces) {
        resultant += force;
        possible += force.norm();
    }
    const double work = work_correction(mesh, load_case, places, solution) * work_of(forces, solution.displacement);
    constexpr double least_resultant = 1e-6; // below this part of what it could be it is rounding, as under torsion
    return resultant.norm() > least_resultant * possible && work != 0.0 ? resultant.squaredNorm() / work : no_stiffness;
}

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
