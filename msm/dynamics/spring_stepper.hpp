#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/relaxation.hpp"
#include "core/tool/stepper.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/elastic_body.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"

namespace livermark::msm {

/// Springs that move, and in which steps.
struct MovingSprings {
    ElasticBody springs;
    std::optional<SpringSource> source{}; ///< of their stiffness, for cuts; nothing of coupled springs
    core::RayleighDamping damping{};
    /// Scaled masses are those of a body whose constraints may be others: nodes that are held belong to no part.
    FastStepOptions options{};
    double critical_time_step = 0.0; ///< at rest [s]
    /// Whether what a ball exerts acts as loads in the next step, and not as kicks after it: limits of speeds and
    /// scaled masses leave equilibria under it as they are then.
    bool bears_ball_as_loads = false;
};

/// Springs in steps of symplectic Euler on vector units, forces in single precision. Nodes and tetrahedra keep their
/// numbers when it is cut, and what a cut changes is made again around it.
class SpringStepper : public core::Stepper {
  public:
    /// The first step asks for prepare().
    /// @param held  and loads
    SpringStepper(std::shared_ptr<const core::Body> body, MovingSprings moving, NodalConditions held);

    void prepare(double time_step) override;
    void step(double time_step, int iterations) override;
    double critical_time_step() const override { return moving_.critical_time_step; }
    bool counts_iterations() const override { return false; }
    void lead(std::span<const int> nodes, std::span<const core::Vector3> displacement) override;
    void hold(const NodalConditions &conditions) override;
    void cut(const core::NodalProblem &after, const std::vector<int> &parent_tetrahedron) override;
    std::vector<core::TouchedFacet> touched_facets(std::vector<core::TouchedFacet> facets) const override;
    void touch(std::shared_ptr<core::BallContact> ball) override;
    /// Lets several balls touch, each its own facets: what one gives way by, the next one feels in the same step.
    void touch(std::vector<std::shared_ptr<core::BallContact>> balls);
    void act_after_steps(core::AfterStep action) override { after_ = std::move(action); }
    core::Vector3 position(int node) const override { return body_->mesh.points[node] + steps_->displacement(node); }
    std::vector<core::Vector3> displacement() const override;
    void start_from(const std::vector<core::Vector3> &displacement) override;
    void take_motion_of(const core::Stepper &other) override;
    core::Vector3 elastic_force(std::span<const int> held) const override;
    std::vector<double> per_mass() const override;
    core::FrameCost cost(const core::Effort &effort) const override;
    void load(std::span<const int> nodes, std::span<const core::Vector3> force) override;
    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        steps_->displacements(nodes, found);
    }
    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) override {
        steps_->kick(nodes, velocity, time_step);
    }

    State state() const { return steps_->state(); }
    void set_state(const State &state) { steps_->set_state(state); }

    /// FastSteps::is_pressed().
    bool is_pressed() const { return steps_->is_pressed(); }

    /// Masses of the nodes as they are now, shape (N) [kg].
    const std::vector<double> &node_mass() const { return parts_ ? parts_->node_mass() : moving_.springs.node_mass; }

    /// Gives nodes more mass from the next step on [kg], and none to those that had more before.
    void add_masses(std::span<const int> nodes, std::span<const double> more);

    /// Goes on without tetrahedra of the whole body.
    /// @return FastSteps::cut()
    bool remove(std::span<const int> tetrahedra);

    /// FastSteps::set_scaling().
    void set_scaling(const MassScaling &scaling);

  private:
    void make_steps();
    void part(const Parting &parting);
    void cut_terms_beside();
    void set_factors(const MassScaling &scaling);
    void give_load(int node, const core::Vector3 &force);
    void load_with_balls();
    void load_with_terms_beside();
    void push_out(double time_step);
    /// Mass with which a node gives way to a ball in a step [kg].
    double moved_mass(int node) const;

    std::shared_ptr<const core::Body> body_;
    MovingSprings moving_;
    NodalConditions held_;
    KeptNumbers numbers_;
    double time_step_ = 0.0; ///< [s]
    std::optional<FastSteps> steps_;
    std::optional<CutParts> parts_;
    std::vector<int> led_nodes_;
    std::vector<core::Vector3> led_to_; ///< [m]
    std::vector<int> loaded_, heavier_; ///< nodes
    /// Terms that the kernels leave out act as loads in each step, beside those that are given; often there are none.
    std::vector<std::shared_ptr<const ElasticTerm>> beside_;
    Eigen::VectorXd rest_;                  ///< (3N) [m]; empty where no term is beside the kernels
    std::vector<core::Vector3> given_load_; ///< (N) [N]; empty where no term is beside the kernels
    std::vector<char> bears_more_;          ///< (N) whether such a term loaded a node in the last step
    std::vector<std::shared_ptr<core::BallContact>> balls_;
    std::vector<core::Vector3> force_of_balls_; ///< (N) of the step before [N]; empty where it acts as kicks
    std::vector<int> pressed_;                  ///< nodes that have some of it
    std::vector<double> factor_;                ///< (N) of masses that are scaled; empty where none are
    core::AfterStep after_;
};

} // namespace livermark::msm
