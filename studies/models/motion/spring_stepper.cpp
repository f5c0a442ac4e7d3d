#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "msm/cutting/cut_parts.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/spring_energy.hpp"
#include "studies/models/motion/moving_method.hpp"

namespace livermark::models {

namespace {

/// Springs in steps of symplectic Euler on vector units, forces in single precision. Nodes and tetrahedra keep their
/// numbers when it is cut, and what a cut changes is made again around it.
class SpringStepper : public Stepper {
  public:
    SpringStepper(const MovingSpringModel &model, const NodalProblem &problem,
                  const msm::NodalConditions &once_released, const StepperOptions &options)
        : body_(problem.body), springs_(model.make(*body_)), options_(options), held_(problem.conditions),
          numbers_(body_->mesh) {
        if (options.scales_masses)
            scaling_ = msm::scale_masses(*body_, springs_, once_released);
        // One step for the whole motion: what is held less has the higher frequencies, but where held nodes leave a
        // scaled part.
        double highest = highest_frequency(once_released);
        if (!scaling_.parts.empty())
            highest = std::max(highest, highest_frequency(held_));
        critical_ = 2.0 / highest;
        if (options.may_be_cut)
            parts_ = msm::CutParts::prepare(*body_, springs_, model.spring_source(*body_));
    }

    void prepare(double time_step) override {
        if (steps_ && time_step == time_step_)
            return;
        time_step_ = time_step;
        if (steps_ && options_.may_be_cut)
            steps_->set_time_step(time_step);
        else
            make_steps();
    }

    void step(double time_step, int /*iterations*/) override {
        steps_->take(1);
        for (std::size_t i = 0; i < led_nodes_.size(); ++i)
            steps_->set_displacement(led_nodes_[i], led_to_[i]);
        led_nodes_.clear();
        if (ball_)
            push_out(time_step);
        if (after_)
            after_(*this, 1.0, time_step);
    }

    double critical_time_step() const override { return critical_; }
    bool counts_iterations() const override { return false; }

    void lead(std::span<const int> nodes, std::span<const core::Vector3> displacement) override {
        led_nodes_.assign(nodes.begin(), nodes.end());
        led_to_.assign(displacement.begin(), displacement.end());
    }

    void hold(const msm::NodalConditions &conditions) override {
        held_ = conditions;
        make_steps();
    }

    void cut(const NodalProblem &after, const std::vector<int> &parent_tetrahedron) override {
        const auto cut = numbers_.follow(after.body->mesh, parent_tetrahedron);
        if (!cut.removed.empty()) {
            const auto &changes = parts_->remove(cut.removed);
            steps_->cut(parts_->parts(), parts_->node_mass(), changes);
        }
        if (!cut.parting.tetrahedra.empty()) {
            const auto &changes = parts_->part(cut.parting);
            steps_->part(parts_->parts(), parts_->node_mass(), changes);
        }
        body_ = after.body;
        for (std::size_t i = 0; i < numbers_.nodes().size(); ++i)
            steps_->set_load(numbers_.nodes()[i], after.conditions.force[i]);
    }

    void touch(std::shared_ptr<core::BallContact> ball) override { ball_ = std::move(ball); }
    void act_after_steps(AfterStep action) override { after_ = std::move(action); }

    core::Vector3 position(int node) const override { return body_->mesh.points[node] + steps_->displacement(node); }

    std::vector<core::Vector3> displacement() const override {
        std::vector<core::Vector3> found(numbers_.nodes().size());
        steps_->displacements(numbers_.nodes(), found);
        return found;
    }

    void start_from(const std::vector<core::Vector3> &displacement) override {
        const auto size = static_cast<Eigen::Index>(3 * displacement.size());
        Eigen::VectorXd components(size);
        for (std::size_t i = 0; i < displacement.size(); ++i)
            components.segment<3>(3 * static_cast<Eigen::Index>(i)) = displacement[i];
        steps_->set_state({components, Eigen::VectorXd::Zero(size)});
    }

    void take_motion_of(const Stepper &other) override {
        steps_->set_state(dynamic_cast<const SpringStepper &>(other).steps_->state());
    }

    core::Vector3 elastic_force(std::span<const int> held) const override {
        auto positions = displacement();
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i] += body_->mesh.points[i];
        const auto gradient = msm::elastic_gradient(springs_, positions);
        core::Vector3 force = core::Vector3::Zero();
        for (const int node : held)
            force -= gradient[node];
        return force;
    }

    std::vector<double> per_mass() const override {
        std::vector<double> result;
        for (std::size_t node = 0; node < springs_.node_mass.size(); ++node)
            result.push_back(is_held(node) ? 0.0 : 1.0 / springs_.node_mass[node]);
        return result;
    }

    FrameCost cost(const Effort &effort) const override {
        return {static_cast<double>(effort.steps),
                static_cast<double>(steps_->working_set()) / static_cast<double>(body_->mesh.tetrahedra.size())};
    }

    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        steps_->displacements(nodes, found);
    }
    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) override {
        steps_->kick(nodes, velocity, time_step);
    }

  private:
    bool is_held(std::size_t node) const { return !held_.displacement[node].array().isNaN().any(); }

    double highest_frequency(const msm::NodalConditions &conditions) const {
        return msm::largest_angular_frequency(springs_, body_->mesh.points, conditions,
                                              msm::constrained(scaling_, conditions));
    }

    /// Steps from where the body is.
    void make_steps() {
        auto steps = msm::FastSteps::prepare(
            springs_, body_->mesh.points, held_, {.alpha = options_.mass_damping, .beta = 0.0}, "symplectic_euler",
            time_step_, {.scaling = msm::constrained(scaling_, held_), .may_be_cut = options_.may_be_cut});
        if (!steps)
            throw std::logic_error("the fast kernels do not know these springs");
        if (steps_)
            steps->set_state(steps_->state());
        steps_ = std::move(steps);
    }

    /// Forces of the ball take part in the step.
    void push_out(double h) {
        const auto now = [this](int node) { return position(node); };
        const auto yields = [&](int node) {
            return is_held(static_cast<std::size_t>(node)) ? 0.0 : h * h / springs_.node_mass[node];
        };
        const auto give = [&](int node, const core::Vector3 &force) {
            const core::Vector3 way = yields(node) * force;
            steps_->push(node, way, way / h);
        };
        ball_->begin_step(give);
        ball_->sweep(
            ball_->part(0, 1), [&](int node) { return core::Vector3(position(node) - h * steps_->velocity(node)); },
            now, [&](int node) { return Eigen::Matrix3d(yields(node) * Eigen::Matrix3d::Identity()); }, give);
        ball_->end_step(h);
    }

    std::shared_ptr<const core::Body> body_;
    msm::ElasticBody springs_;
    StepperOptions options_;
    msm::NodalConditions held_;
    msm::KeptNumbers numbers_;
    msm::MassScaling scaling_;
    double critical_ = std::numeric_limits<double>::infinity(), time_step_ = 0.0; ///< [s]
    std::optional<msm::FastSteps> steps_;
    std::optional<msm::CutParts> parts_;
    std::vector<int> led_nodes_;
    std::vector<core::Vector3> led_to_; ///< [m]
    std::shared_ptr<core::BallContact> ball_;
    AfterStep after_;
};

} // namespace

std::unique_ptr<Stepper> spring_stepper(const MovingSpringModel &model, const NodalProblem &problem,
                                        const msm::NodalConditions &once_released, const StepperOptions &options) {
    return std::make_unique<SpringStepper>(model, problem, once_released, options);
}

} // namespace livermark::models
