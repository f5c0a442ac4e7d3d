#include "msm/statics/load_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "msm/springs/springs.hpp"

namespace livermark::msm {

namespace {

/// Largest motion of the surface, over its displacement, when pressures are turned with it once more.
constexpr double turning_tolerance = 1e-7;
constexpr int most_turns = 30;

/// |u - v| / |u|
double relative_difference(const Field &u, const Field &v) {
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
        difference += (u[i] - v[i]).squaredNorm();
        size += u[i].squaredNorm();
    }
    return size > 0.0 ? std::sqrt(difference / size) : 0.0;
}

/// To the last bit.
void put_to_place(Field &displacement, const NodalConditions &conditions) {
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

Field EquilibriumSearch::positions(const Field &displacement) const {
    return moved(problem_.body->mesh.points, displacement);
}

Equilibrium EquilibriumSearch::find(const ElasticBody &body, const RestStiffness &rest, double fraction, Field start,
                                    const Touch &touch) {
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

Field EquilibriumSearch::reaction(const Equilibrium &found, double fraction) const {
    return constraint_forces(at(fraction), conditions_at(fraction), found.constraint_force, found.press, found.touch);
}

Equilibrium EquilibriumSearch::find(const ElasticBody &body, const RestStiffness &rest,
                                    const NodalConditions &conditions, Field start, const SurfacePressure *pressure,
                                    const Touch &touch) {
    EquilibriumOptions options;
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

namespace {

/// Halvings of a step between two points of the path before it gives up.
constexpr int most_halvings = 4;

/// Largest change of forces on nodes, over all of them, when what touches a body is taken from an equilibrium.
constexpr double contact_tolerance = 1e-6;
constexpr int most_updates = 100;
/// Tolerances of the equilibria that follow one another: at first, and as a part of the change before.
constexpr double first_tolerance = 1e-5, part_of_change = 1e-2;
/// Fall of the change below which bounds of friction follow pressures by half as much, down to a part.
constexpr double least_fall = 0.9, least_part = 1.0 / 8.0;

Field difference(const Field &a, const Field &b) {
    Field result(a.size());
    std::ranges::transform(a, b, result.begin(), [](const auto &x, const auto &y) -> core::Vector3 { return x - y; });
    return result;
}

/// The way of one body.
class Follower {
  public:
    /// @param tissue  the body without what it stands on
    Follower(const ElasticBody &tissue, const ElasticBody &body, const core::Problem &problem,
             const std::vector<double> &node_mass, const RestStiffness &rest)
        : tissue_(tissue), body_(body), rest_(rest), search_(problem, node_mass), contact_(problem, body.softness),
          linear_(linear_solution(rest, nodal_conditions(problem, node_mass), &search_.memory())) {
        last_.displacement.assign(linear_.size(), core::Vector3::Zero());
    }

    /// @return whether there is an equilibrium there
    bool go_to(double fraction, int halvings = 0) {
        if (auto found =
                contact_.is_empty() ? search_.find(body_, rest_, fraction, predicted(fraction)) : touched_at(fraction);
            found.status == core::SolutionStatus::ok || halvings == most_halvings) {
            const bool is_there = found.status == core::SolutionStatus::ok;
            if (is_there && !contact_.is_empty()) {
                last_step_ = difference(found.displacement, last_.displacement);
                last_part_ = fraction - fraction_;
                contact_.end_step(search_.positions(found.displacement));
            }
            if (is_there)
                fraction_ = fraction;
            last_ = std::move(found);
            return is_there;
        }
        return go_to(0.5 * (fraction_ + fraction), halvings + 1) && go_to(fraction, halvings + 1);
    }

    core::PathPoint point() const {
        core::PathPoint point;
        for (const auto &displacement : last_.displacement)
            point.displacement.push_back(displacement.cast<float>());
        point.reaction = search_.reaction(last_, fraction_);
        point.strain_energy = elastic_energy(tissue_, search_.positions(last_.displacement));
        return point;
    }

    /// The last equilibrium, with the work of all.
    Equilibrium end() {
        last_.num_iterations = search_.num_iterations();
        last_.num_factors = search_.num_factors();
        last_.linear_displacement = linear_;
        return std::move(last_);
    }

    int num_steps() const { return search_.num_equilibria(); }

  private:
    /// As the linear solution goes on; where a ball touches, which that knows nothing of, as the last step went.
    Field predicted(double fraction) const {
        auto start = last_.displacement;
        const bool goes_on = !last_step_.empty();
        for (std::size_t i = 0; i < start.size(); ++i)
            start[i] += (fraction - fraction_) * (goes_on ? last_step_[i] / last_part_ : linear_[i]);
        return start;
    }

    /// Under the ball where it is at this part of its way. Where none is found, what touches is as it was.
    Equilibrium touched_at(double fraction) {
        constexpr double usual = path_tolerance;
        const auto before = contact_;
        contact_.move_ball(fraction);
        auto start = predicted(fraction);
        Equilibrium found;
        double part = 1.0, last_change = std::numeric_limits<double>::infinity(), tolerance = first_tolerance;
        for (int update = 0; update < most_updates; ++update) {
            found =
                search_.find(body_, rest_, fraction, std::move(start), {.contact = &contact_, .tolerance = tolerance});
            if (found.status != core::SolutionStatus::ok)
                break;
            const double change = contact_.update(search_.positions(found.displacement), part);
            if (change < contact_tolerance && tolerance == usual)
                return found;
            // What still changes is not worth more digits than that.
            tolerance =
                change < 10.0 * contact_tolerance ? usual : std::clamp(part_of_change * change, usual, first_tolerance);
            if (change > least_fall * last_change)
                part = std::max(0.5 * part, least_part);
            last_change = change;
            start = found.displacement;
        }
        contact_ = before;
        if (found.status == core::SolutionStatus::ok) {
            found.status = core::SolutionStatus::not_converged;
            found.message = "the body and the ball that touches it find no rest; press less, or with less friction";
        }
        return found;
    }

    const ElasticBody &tissue_, &body_;
    const RestStiffness &rest_;
    EquilibriumSearch search_;
    SurfaceContact contact_;
    Field linear_; ///< solution linearised at rest to the whole load
    Equilibrium last_;
    double fraction_ = 0.0;  ///< where it has come to
    Field last_step_;        ///< by which it came there under a ball; empty before the first, and without one
    double last_part_ = 1.0; ///< of the load, in that step
};

} // namespace

ElasticBody on_foundation(ElasticBody body, const core::Problem &problem) {
    if (!problem.load_case.foundation)
        return body;
    body.add(foundation_springs(problem.body->mesh, *problem.load_case.foundation));
    return body;
}

namespace {

/// A body with what bears it, and the stiffness of both at rest; without a foundation those that are given.
class BorneBody {
  public:
    BorneBody(const ElasticBody &tissue, const core::Problem &problem, const std::vector<double> &node_mass,
              const RestStiffness &rest_of_tissue)
        : tissue_(tissue), rest_of_tissue_(rest_of_tissue) {
        if (!problem.load_case.foundation)
            return;
        body_ = on_foundation(tissue, problem);
        rest_.emplace(*body_, problem.body->mesh.points, nodal_conditions(problem, node_mass).displacement);
    }

    const ElasticBody &body() const { return body_ ? *body_ : tissue_; }
    const RestStiffness &rest() const { return rest_ ? *rest_ : rest_of_tissue_; }

  private:
    const ElasticBody &tissue_;
    const RestStiffness &rest_of_tissue_;
    std::optional<ElasticBody> body_;
    std::optional<RestStiffness> rest_;
};

} // namespace

Equilibrium find_equilibrium(const ElasticBody &body, const core::Problem &problem,
                             const std::vector<double> &node_mass, const RestStiffness &rest,
                             const EquilibriumOptions &options) {
    const BorneBody borne(body, problem, node_mass, rest);
    return find_equilibrium(borne.body(), problem.body->mesh.points, nodal_conditions(problem, node_mass), borne.rest(),
                            options);
}

FollowedPath follow_path(const ElasticBody &body, const core::Problem &problem, const std::vector<double> &node_mass,
                         const RestStiffness &rest) {
    const BorneBody borne(body, problem, node_mass, rest);
    Follower follower(body, borne.body(), problem, node_mass, borne.rest());
    FollowedPath result;
    for (const double fraction : problem.load_case.path) {
        if (!follower.go_to(fraction))
            break;
        result.points.push_back(follower.point());
    }
    result.end = follower.end();
    result.num_steps = follower.num_steps();
    return result;
}

} // namespace livermark::msm
