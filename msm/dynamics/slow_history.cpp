#include "msm/dynamics/histories.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "msm/dynamics/stepper.hpp"
#include "msm/statics/load_path.hpp"

namespace livermark::msm {

namespace {

using Unknowns = Eigen::VectorXd;

/// The stiffness at rest of a body of which a part of the relaxing stresses is left, with its factor, until another
/// part is asked for.
class RelaxedStiffness {
  public:
    RelaxedStiffness(const ElasticBody &body, const core::Problem &problem, const NodalConditions &conditions,
                     double tolerance)
        : body_(body), problem_(problem), prescribed_(conditions.displacement), tolerance_(tolerance) {}

    const RestStiffness &with(double part) {
        if (!rest_ || std::abs(part - part_) > tolerance_ * part_) {
            const auto relaxed_body = relaxed(body_, part);
            rest_ = std::make_unique<RestStiffness>(relaxed_body, problem_.body->mesh.points, prescribed_);
            part_ = part;
            ++num_factors_;
        }
        return *rest_;
    }
    int num_factors() const { return num_factors_; }

  private:
    const ElasticBody &body_;
    const core::Problem &problem_;
    Field prescribed_;
    double tolerance_;
    std::unique_ptr<RestStiffness> rest_;
    double part_ = 0.0;
    int num_factors_ = 0;
};

/// Records of each time, and the work since the last one.
class Records {
  public:
    /// @param force  on each node from outside, constraints included, shape (3N) [N]
    void add(const Unknowns &displacement, const Unknowns &force, Field reaction, double stored, double dissipated) {
        if (last_displacement_.size() > 0)
            work_ += 0.5 * (force + last_force_).dot(displacement - last_displacement_);
        last_displacement_ = displacement;
        last_force_ = force;
        core::PathPoint point;
        for (const auto &node : to_field(displacement))
            point.displacement.push_back(node.cast<float>());
        point.reaction = std::move(reaction);
        point.strain_energy = stored;
        point.work = work_;
        point.dissipated_energy = dissipated;
        points.push_back(std::move(point));
    }

    std::vector<core::PathPoint> points;

  private:
    Unknowns last_displacement_, last_force_;
    double work_ = 0.0;
};

/// Steps of equal length differ in their last digits.
constexpr double same_step = 1e-10;

/// A body linearised at rest. With K_s u the relaxing forces, branches hold the displacements y of which K_s y are
/// their forces.
class LinearHistory {
  public:
    LinearHistory(const ElasticBody &body, const core::Problem &problem, const std::vector<double> &node_mass)
        : problem_(problem), history_(*problem.load_case.slow_history), search_(problem, node_mass),
          stiffness_(body, problem, search_.conditions_at(1.0), same_step), all_(body, problem.body->mesh.points),
          staying_(relaxed(body, 0.0), problem.body->mesh.points), remaining_(history_.relaxation.remaining()) {
        const auto size = static_cast<Eigen::Index>(3 * problem.body->mesh.points.size());
        displacement_ = staying_force_ = relaxing_force_ = force_ = Unknowns::Zero(size);
        branches_.assign(history_.relaxation.moduli.size(), {displacement_, displacement_});
        result_.end.constraint_force.assign(problem.body->mesh.points.size(), core::Vector3::Zero());
        result_.end.displacement = result_.end.constraint_force;
    }

    FollowedHistory follow() {
        record(0);
        for (int k = 1; k < history_.num_records(); ++k) {
            if (!step(history_.times[k] - history_.times[k - 1], history_.factors[k]))
                break;
            record(k);
        }
        result_.points = std::move(records_.points);
        result_.end.num_factors = stiffness_.num_factors() - 1; // that at rest is none
        result_.end.num_iterations = result_.num_steps;
        return std::move(result_);
    }

  private:
    struct Branch {
        Unknowns displacement, force; ///< y and K_s y
    };

    /// @return whether the body is stiff in every direction
    bool step(double length, double factor) {
        const auto branch_steps = core::branch_steps(history_.relaxation, length);
        const auto &rest = stiffness_.with(core::instant_part(history_.relaxation, branch_steps));
        if (!rest.is_definite()) {
            result_.end.status = core::SolutionStatus::not_converged;
            result_.end.message = "the body at rest is not stiff in every direction; constrain more facets";
            return false;
        }
        Unknowns from_before = Unknowns::Zero(displacement_.size());
        for (std::size_t b = 0; b < branches_.size(); ++b)
            from_before += branch_steps[b].fade * branches_[b].force - branch_steps[b].gain * relaxing_force_;
        const auto conditions = search_.conditions_at(factor);
        const Unknowns displacement = solution(rest, conditions, from_before);
        const Unknowns change = displacement - displacement_;
        staying_force_ = staying_.times(displacement);
        const Unknowns relaxing = all_.times(displacement) - staying_force_;
        const Unknowns force_change = relaxing - relaxing_force_;
        force_ = staying_force_ + remaining_ * relaxing;
        for (std::size_t b = 0; b < branches_.size(); ++b) {
            const auto &branch_step = branch_steps[b];
            auto &[branch, force] = branches_[b];
            dissipated_ +=
                branch_step.dissipated(branch.dot(force), branch.dot(force_change), change.dot(force_change));
            branch = branch_step.fade * branch + branch_step.gain * change;
            force = branch_step.fade * force + branch_step.gain * force_change;
            force_ += force;
        }
        displacement_ = displacement;
        relaxing_force_ = relaxing;
        ++result_.num_steps;
        return true;
    }

    /// Solution of K u + from_before = load, and the amount of the load where a place presses.
    Unknowns solution(const RestStiffness &rest, const NodalConditions &conditions, const Unknowns &from_before) {
        auto load = to_field(-from_before);
        if (conditions.press_depth == 0.0) {
            amount_ = 1.0;
            for (std::size_t i = 0; i < load.size(); ++i)
                load[i] += conditions.force[i];
            return to_unknowns(rest.solve(conditions.displacement, load, &search_.memory()));
        }
        if (num_factors_of_unit_ != stiffness_.num_factors()) {
            unit_ = to_unknowns(rest.solve(conditions.displacement, conditions.force, &search_.memory()));
            num_factors_of_unit_ = stiffness_.num_factors();
        }
        const Unknowns direction = to_unknowns(conditions.force);
        const Unknowns left = to_unknowns(rest.solve(conditions.displacement, load, &search_.memory()));
        amount_ = (conditions.press_depth - direction.dot(left)) / direction.dot(unit_);
        return left + amount_ * unit_;
    }

    void record(int number) {
        const double factor = history_.factors[static_cast<std::size_t>(number)];
        const auto conditions = search_.conditions_at(factor);
        Equilibrium here = result_.end; // its status and sizes
        here.displacement = to_field(displacement_);
        here.press = conditions.press_depth != 0.0 ? amount_ : 0.0;
        const auto forces = to_field(force_);
        for (std::size_t i = 0; i < forces.size(); ++i)
            for (int c = 0; c < 3; ++c)
                here.constraint_force[i][c] =
                    std::isnan(conditions.displacement[i][c]) ? 0.0 : forces[i][c] - amount_ * conditions.force[i][c];
        const double stored = stored_energy();
        if (number <= history_.whole_load_record()) {
            result_.end = here;
            result_.stored_energy = stored;
        }
        records_.add(displacement_, force_, search_.reaction(here, factor), stored, dissipated_);
    }

    double stored_energy() const {
        double energy = 0.5 * displacement_.dot(staying_force_ + remaining_ * relaxing_force_);
        const auto steps = core::branch_steps(history_.relaxation, 0.0);
        for (std::size_t b = 0; b < branches_.size(); ++b)
            energy += steps[b].stored(branches_[b].displacement.dot(branches_[b].force));
        return energy;
    }

    const core::Problem &problem_;
    const core::SlowHistory &history_;
    EquilibriumSearch search_; // of which only the conditions are used
    RelaxedStiffness stiffness_;
    StiffnessProduct all_, staying_; // K_e + K_s, K_e
    double remaining_;
    Unknowns displacement_, staying_force_, relaxing_force_; // u, K_e u and K_s u
    Unknowns force_;                                         // on the nodes from outside
    std::vector<Branch> branches_;
    Unknowns unit_; // what one newton of what presses moves
    int num_factors_of_unit_ = 0;
    double amount_ = 0.0;
    double dissipated_ = 0.0;
    Records records_;
    FollowedHistory result_;
};

/// Halvings of a step between two times before it gives up.
constexpr int most_halvings_in_time = 4;

/// Largest difference of the part that is left from that of the factor: it is the first guess of a tangent only.
constexpr double similar_part = 0.15;

/// A body that is as nonlinear as it is.
class LargeHistory {
  public:
    LargeHistory(const ElasticBody &body, const core::Problem &problem, const std::vector<double> &node_mass)
        : history_(*problem.load_case.slow_history), body_(body, history_.relaxation),
          search_(problem, node_mass, true), stiffness_(body, problem, search_.conditions_at(1.0), similar_part),
          rest_(problem.body->mesh.points) {
        last_.displacement.assign(rest_.size(), core::Vector3::Zero());
        last_.constraint_force = last_.displacement;
    }

    FollowedHistory follow() {
        record(0);
        for (int k = 1; k < history_.num_records(); ++k) {
            if (!go_to(history_.times[k], history_.factors[k])) {
                result_.end.status = core::SolutionStatus::not_converged;
                result_.end.message = last_.message;
                break;
            }
            record(k);
        }
        result_.points = std::move(records_.points);
        result_.end.num_iterations = search_.num_iterations();
        result_.end.num_factors = search_.num_factors() + stiffness_.num_factors() - 1; // that at rest is none
        return std::move(result_);
    }

  private:
    /// @return whether there is an equilibrium there
    bool go_to(double time, double factor, int halvings = 0) {
        const double length = time - time_;
        const auto part = core::instant_part(history_.relaxation, core::branch_steps(history_.relaxation, length));
        const auto &rest = stiffness_.with(part);
        if (linear_.empty())
            linear_ = linear_solution(rest, search_.conditions_at(1.0), &search_.memory());
        auto start = last_.displacement;
        for (std::size_t i = 0; i < start.size(); ++i)
            start[i] += (factor - factor_) * linear_[i];
        const auto body = body_.after(length);
        auto found = search_.find(body, rest, factor, std::move(start));
        if (found.status == core::SolutionStatus::ok) {
            last_ = std::move(found);
            body_.go_on(to_unknowns(search_.positions(last_.displacement)), length);
            time_ = time;
            factor_ = factor;
            ++result_.num_steps;
            return true;
        }
        last_.message = found.message;
        if (halvings == most_halvings_in_time)
            return false;
        return go_to(0.5 * (time_ + time), 0.5 * (factor_ + factor), halvings + 1) && go_to(time, factor, halvings + 1);
    }

    void record(int number) {
        const double factor = history_.factors[static_cast<std::size_t>(number)];
        const Unknowns x = to_unknowns(search_.positions(last_.displacement));
        const double stored = body_.stored_energy(x);
        if (number <= history_.whole_load_record()) {
            result_.end = last_;
            result_.stored_energy = stored;
        }
        Unknowns inner = Unknowns::Zero(x.size());
        body_.add_force(x, x, 0.0, inner);
        records_.add(to_unknowns(last_.displacement), -inner, search_.reaction(last_, factor), stored,
                     body_.dissipated_energy());
    }

    const core::SlowHistory &history_;
    RelaxingBody body_;
    EquilibriumSearch search_;
    RelaxedStiffness stiffness_;
    const Field &rest_;
    Field linear_; // solution linearised at rest to the whole load
    Equilibrium last_;
    double time_ = 0.0, factor_ = 0.0; // where it has come to
    Records records_;
    FollowedHistory result_;
};

} // namespace

FollowedHistory follow_history(const ElasticBody &body, const core::Problem &problem,
                               const std::vector<double> &node_mass) {
    return problem.load_case.regime == core::Regime::small ? LinearHistory(body, problem, node_mass).follow()
                                                           : LargeHistory(body, problem, node_mass).follow();
}

} // namespace livermark::msm
