#include "msm/statics/load_path.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace livermark::msm {

namespace {

using Field = std::vector<core::Vector3>;

/// Halvings of a step between two points of the path before it gives up.
constexpr int most_halvings = 4;

/// Along the path nobody looks at more digits, and large forces leave fewer.
constexpr EquilibriumOptions path_options{.tolerance = 1e-9, .max_iterations = 300};

/// How little the surface may move, over its displacement, when pressures are turned with it once more.
constexpr double turning_tolerance = 1e-7;
constexpr int most_turns = 30;

/// How little forces on nodes may change, over all of them, when what touches a body is taken from an equilibrium.
constexpr double contact_tolerance = 1e-6;
constexpr int most_updates = 100;

/// |u - v| / |u|
double relative_difference(const Field &u, const Field &v) {
    double difference = 0.0, size = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
        difference += (u[i] - v[i]).squaredNorm();
        size += u[i].squaredNorm();
    }
    return size > 0.0 ? std::sqrt(difference / size) : 0.0;
}

Field difference(const Field &a, const Field &b) {
    Field result(a.size());
    std::ranges::transform(a, b, result.begin(), [](const auto &x, const auto &y) -> core::Vector3 { return x - y; });
    return result;
}

/// The way of one body.
class Follower {
  public:
    Follower(const ElasticBody &body, const core::Problem &problem, const std::vector<double> &node_mass,
             const RestStiffness &rest, double contact_stiffness)
        : body_(body), problem_(problem), node_mass_(node_mass), rest_(rest),
          has_followers_(!SurfacePressure(problem).is_empty()), contact_(problem, contact_stiffness) {
        linear_ = linear_solution(rest, nodal_conditions(problem, node_mass), &memory_);
        last_.displacement.assign(linear_.size(), core::Vector3::Zero());
    }

    /// @return whether there is an equilibrium there
    bool go_to(double fraction, int halvings = 0) {
        if (auto found = equilibrium_at(fraction);
            found.status == core::SolutionStatus::ok || halvings == most_halvings) {
            const bool is_there = found.status == core::SolutionStatus::ok;
            if (is_there) {
                last_step_ = difference(found.displacement, last_.displacement);
                last_part_ = fraction - fraction_;
                fraction_ = fraction;
                contact_.end_step(positions(found.displacement));
            }
            last_ = std::move(found);
            return is_there;
        }
        return go_to(0.5 * (fraction_ + fraction), halvings + 1) && go_to(fraction, halvings + 1);
    }

    core::PathPoint point() const {
        const auto problem = at(fraction_);
        core::PathPoint point;
        for (const auto &displacement : last_.displacement)
            point.displacement.push_back(displacement.cast<float>());
        point.reaction = constraint_forces(problem, nodal_conditions(problem, node_mass_), last_.constraint_force,
                                           last_.press, last_.touch);
        point.strain_energy = elastic_energy(body_, positions(last_.displacement));
        return point;
    }

    /// What the last equilibrium was, with the work of all.
    Equilibrium end() {
        last_.num_iterations = num_iterations_;
        last_.num_factors = num_factors_;
        last_.linear_displacement = linear_;
        return std::move(last_);
    }

    int num_steps() const { return num_steps_; }

  private:
    core::Problem at(double fraction) const { return {problem_.body, core::scaled(problem_.load_case, fraction)}; }

    Field positions(const Field &displacement) const {
        auto result = problem_.body->mesh.points;
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] += displacement[i];
        return result;
    }

    /// As the linear solution goes on; where a ball touches, which that knows nothing of, as the last step went.
    Field predicted(double fraction, const NodalConditions &conditions) const {
        auto start = last_.displacement;
        const bool goes_on = !contact_.is_empty() && !last_step_.empty();
        for (std::size_t i = 0; i < start.size(); ++i) {
            start[i] += (fraction - fraction_) * (goes_on ? last_step_[i] / last_part_ : linear_[i]);
            for (int c = 0; c < 3; ++c)
                if (!std::isnan(conditions.displacement[i][c]))
                    start[i][c] = conditions.displacement[i][c]; // to the last bit
        }
        return start;
    }

    Equilibrium find(const NodalConditions &conditions, Field start, const SurfacePressure *pressure,
                     const SurfaceContact *contact = nullptr) {
        auto options = path_options;
        options.pressure = pressure;
        options.contact = contact;
        options.memory = &memory_;
        auto found = find_equilibrium(body_, problem_.body->mesh.points, conditions, rest_, options, std::move(start));
        ++num_steps_;
        num_iterations_ += found.num_iterations;
        num_factors_ += found.num_factors;
        return found;
    }

    Equilibrium equilibrium_at(double fraction) {
        const auto problem = at(fraction);
        const auto as_at_rest = nodal_conditions(problem, node_mass_);
        auto start = predicted(fraction, as_at_rest);
        if (!contact_.is_empty())
            return touched_at(fraction, as_at_rest, std::move(start));
        if (!has_followers_)
            return find(as_at_rest, std::move(start), nullptr);
        const SurfacePressure pressure(problem);
        const auto at_rest = pressure.force(problem_.body->mesh.points);
        Equilibrium found;
        for (int turn = 0; turn < most_turns; ++turn) {
            auto conditions = as_at_rest;
            const auto at_rim = pressure.rim_force(positions(start));
            for (std::size_t i = 0; i < at_rest.size(); ++i)
                conditions.force[i] += at_rim[i] - at_rest[i];
            found = find(conditions, start, &pressure);
            if (found.status != core::SolutionStatus::ok ||
                relative_difference(found.displacement, start) < turning_tolerance)
                return found;
            start = found.displacement;
        }
        found.status = core::SolutionStatus::not_converged;
        found.message = "pressures that follow the surface and the body find no rest; lower the load";
        return found;
    }

    /// Under the ball where it is at this part of its way. Where none is found, what touches is as it was.
    Equilibrium touched_at(double fraction, const NodalConditions &conditions, Field start) {
        const auto before = contact_;
        contact_.move_ball(fraction);
        Equilibrium found;
        for (int update = 0; update < most_updates; ++update) {
            found = find(conditions, std::move(start), nullptr, &contact_);
            if (found.status != core::SolutionStatus::ok)
                break;
            if (contact_.update(positions(found.displacement)) < contact_tolerance)
                return found;
            start = found.displacement;
        }
        contact_ = before;
        if (found.status == core::SolutionStatus::ok) {
            found.status = core::SolutionStatus::not_converged;
            found.message = "the body and the ball that touches it find no rest; press less, or with less friction";
        }
        return found;
    }

    const ElasticBody &body_;
    const core::Problem &problem_;
    const std::vector<double> &node_mass_;
    const RestStiffness &rest_;
    bool has_followers_;
    SurfaceContact contact_;
    LimitedMemory memory_{most_remembered};
    Field linear_; ///< solution linearised at rest to the whole load
    Equilibrium last_;
    double fraction_ = 0.0;  ///< where it has come to
    Field last_step_;        ///< by which it came there; empty before the first
    double last_part_ = 1.0; ///< of the load, in that step
    int num_steps_ = 0, num_iterations_ = 0, num_factors_ = 0;
};

} // namespace

FollowedPath follow_path(const ElasticBody &body, const core::Problem &problem, const std::vector<double> &node_mass,
                         const RestStiffness &rest, double contact_stiffness) {
    Follower follower(body, problem, node_mass, rest, contact_stiffness);
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
