#include "msm/statics/equilibrium_search.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace livermark::msm {

namespace {

using Displacements = std::vector<core::Vector3>;

constexpr EquilibriumOptions path_options{.max_iterations = 300};

/// How little the surface may move, over its displacement, when pressures are turned with it once more.
constexpr double turning_tolerance = 1e-7;
constexpr int most_turns = 30;

/// |u - v| / |u|
double relative_difference(const Displacements &u, const Displacements &v) {
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
        difference += (u[i] - v[i]).squaredNorm();
        size += u[i].squaredNorm();
    }
    return size > 0.0 ? std::sqrt(difference / size) : 0.0;
}

/// To the last bit.
void put_to_place(Displacements &displacement, const NodalConditions &conditions) {
    for (std::size_t i = 0; i < displacement.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (!std::isnan(conditions.displacement[i][c]))
                displacement[i][c] = conditions.displacement[i][c];
}

} // namespace

EquilibriumSearch::EquilibriumSearch(const core::Problem &problem, const std::vector<double> &node_mass,
                                     bool bears_rounding)
    : problem_(problem), node_mass_(node_mass), has_followers_(!SurfacePressure(problem).is_empty()),
      bears_rounding_(bears_rounding) {}

core::Problem EquilibriumSearch::at(double fraction) const {
    return {problem_.body, core::scaled(problem_.load_case, fraction)};
}

NodalConditions EquilibriumSearch::conditions_at(double fraction) const {
    auto conditions = nodal_conditions(at(fraction), node_mass_);
    if (problem_.load_case.press_depth != 0.0 && conditions.press_depth == 0.0)
        conditions.press_depth = std::numeric_limits<double>::min(); // at none, the unit force would be the load
    return conditions;
}

Displacements EquilibriumSearch::positions(const Displacements &displacement) const {
    auto result = problem_.body->mesh.points;
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] += displacement[i];
    return result;
}

Equilibrium EquilibriumSearch::find(const ElasticBody &body, const RestStiffness &rest, double fraction,
                                    Displacements start, const Touch &touch) {
    const auto as_at_rest = conditions_at(fraction);
    put_to_place(start, as_at_rest);
    if (!has_followers_ || touch.contact)
        return find(body, rest, as_at_rest, std::move(start), nullptr, touch);
    const SurfacePressure pressure(at(fraction));
    const auto at_rest = pressure.force(problem_.body->mesh.points);
    Equilibrium found;
    for (int turn = 0; turn < most_turns; ++turn) {
        auto conditions = as_at_rest;
        const auto at_rim = pressure.rim_force(positions(start));
        for (std::size_t i = 0; i < at_rest.size(); ++i)
            conditions.force[i] += at_rim[i] - at_rest[i];
        found = find(body, rest, conditions, start, &pressure, touch);
        if (found.status != core::SolutionStatus::ok ||
            relative_difference(found.displacement, start) < turning_tolerance)
            return found;
        start = found.displacement;
    }
    found.status = core::SolutionStatus::not_converged;
    found.message = "pressures that follow the surface and the body find no rest; lower the load";
    return found;
}

std::vector<core::Vector3> EquilibriumSearch::reaction(const Equilibrium &found, double fraction) const {
    return constraint_forces(at(fraction), conditions_at(fraction), found.constraint_force, found.press, found.touch);
}

Equilibrium EquilibriumSearch::find(const ElasticBody &body, const RestStiffness &rest,
                                    const NodalConditions &conditions, Displacements start,
                                    const SurfacePressure *pressure, const Touch &touch) {
    auto options = path_options;
    options.bears_rounding = bears_rounding_;
    options.pressure = pressure;
    options.tolerance = touch.tolerance;
    options.contact = touch.contact;
    options.memory = &memory_;
    auto found = find_equilibrium(body, problem_.body->mesh.points, conditions, rest, options, std::move(start));
    ++num_equilibria_;
    num_iterations_ += found.num_iterations;
    num_factors_ += found.num_factors;
    return found;
}

} // namespace livermark::msm
