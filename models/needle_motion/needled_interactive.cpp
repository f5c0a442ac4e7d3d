#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "core/tool/needle/moving_needle.hpp"
#include "interactive/place_response.hpp"
#include "models/needle_motion/needled_methods.hpp"
#include "models/tool_motion/frame_steps.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/mass_lumping.hpp"
#include "msm/nodal_conditions.hpp"

namespace livermark::models {

namespace {

using livermark::interactive::Field;
using livermark::interactive::Method;
using livermark::interactive::Scene;
using livermark::interactive::Simulation;

/// The nodes of the mesh of a simulation.
class NodesOfSimulation : public core::MovingNodes {
  public:
    explicit NodesOfSimulation(Simulation &simulation)
        : simulation_(simulation), change_(Field::Zero(3, simulation.positions().cols())) {}

    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        const auto &rest = simulation_.scene().body->mesh.points;
        for (std::size_t i = 0; i < nodes.size(); ++i)
            found[i] = simulation_.positions().col(nodes[i]) - rest[nodes[i]];
    }

    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) override {
        change_.setZero();
        for (std::size_t i = 0; i < nodes.size(); ++i)
            change_.col(nodes[i]) = velocity[i];
        simulation_.kick(change_, time_step);
    }

  private:
    Simulation &simulation_;
    Field change_;
};

/// Where places come to at most while a method's response is observed [m]: strains of a thousandth.
constexpr double way_of_observation = 1e-5;

/// An explicit method has the needle after each of its steps. Another one has it once in a frame: its forces last over
/// the next frame, however many steps that has. What the frame does with a force is observed at rest, since iterations
/// that have not converged give way several times as far as backward Euler.
class NeedledInteractive : public NeedledBody {
  public:
    NeedledInteractive(const Method &method, const core::Problem &problem, const core::Needle &needle,
                       const NeedlePlan &plan)
        : method_(method), plan_(plan), simulation_(method.prepare(scene_of(problem, plan))), nodes_(*simulation_) {
        const auto &mesh = problem.body->mesh;
        if (method.is_explicit) {
            needle_.emplace(needle, mesh, per_mass());
            const double longest = livermark::msm::default_safety_factor * simulation_->critical_time_step();
            least_steps_ = static_cast<int>(std::ceil(plan_.frame_interval / longest));
        } else {
            weights_ = core::place_weights(needle, mesh);
            auto converged = livermark::interactive::place_response(*simulation_, plan_.frame_interval, weights_);
            force_of_observation_ = way_of_observation / (converged.maxCoeff() * std::pow(plan_.frame_interval, 2));
            needle_.emplace(needle, weights_, std::move(converged));
        }
        needle_->begin(nodes_);
    }

    void prepare_for(const Effort &effort) override {
        simulation_->prepare(plan_.frame_interval / effort.steps);
        if (is_explicit())
            return;
        const auto at_rest = method_.prepare(simulation_->scene());
        needle_->respond_by(livermark::interactive::observed_place_response(
            *at_rest, plan_.frame_interval, effort.steps, effort.iterations, weights_, force_of_observation_));
    }

    void advance(double depth, const Effort &effort) override {
        if (is_explicit())
            advance_explicitly(depth, effort);
        else
            advance_implicitly(depth, effort);
    }

    void advance_alone(const Effort &effort) override {
        const double step = plan_.frame_interval / effort.steps;
        for (int s = 0; s < effort.steps; ++s)
            simulation_->step(step, effort.iterations);
    }

    void take_motion_of(const NeedledBody &other) override {
        const auto &of = dynamic_cast<const NeedledInteractive &>(other);
        simulation_->set_external_forces(of.simulation_->external_forces());
        simulation_->set_state(of.simulation_->positions(), of.simulation_->velocities());
    }

    std::vector<core::Vector3> displacement() const override { return displacement_of(*simulation_); }

    NeedleReading reading() const override {
        return {.force = force_, .tip = needle_->tip(), .places = needle_->place_displacements(nodes_)};
    }

    FrameCost cost(const Effort &effort) const override { return frame_cost(*simulation_, effort); }

    std::optional<Effort> least_effort() const override {
        return is_explicit() ? std::optional(Effort{.iterations = least_steps_}) : std::nullopt;
    }

  private:
    static Scene scene_of(const core::Problem &problem, const NeedlePlan &plan) {
        Scene scene{.body = problem.body,
                    .node_mass = livermark::msm::lumped_masses(*problem.body),
                    .constrained_nodes = {},
                    .mass_damping = plan.mass_damping};
        const auto conditions = livermark::msm::nodal_conditions(problem, scene.node_mass);
        for (std::size_t node = 0; node < scene.node_mass.size(); ++node)
            if (conditions.constraint[node][0] >= 0)
                scene.constrained_nodes.push_back(static_cast<int>(node));
        return scene;
    }

    bool is_explicit() const { return least_steps_ > 0; }

    std::vector<double> per_mass() const {
        const auto is_free = free_nodes(simulation_->scene());
        std::vector<double> result;
        for (std::size_t node = 0; node < is_free.size(); ++node)
            result.push_back(is_free[node] ? 1.0 / simulation_->scene().node_mass[node] : 0.0);
        return result;
    }

    void advance_explicitly(double depth, const Effort &effort) {
        const double start = needle_->depth(), step = plan_.frame_interval / effort.steps;
        force_ = 0.0;
        for (int s = 0; s < effort.steps; ++s) {
            simulation_->act_after_steps([&](core::MovingNodes &nodes, double part, double h) {
                needle_->act(nodes, start + (depth - start) * (s + part) / effort.steps, h);
                force_ += needle_->force() * h / plan_.frame_interval;
            });
            simulation_->step(step, effort.iterations);
        }
        simulation_->act_after_steps(nullptr);
    }

    void advance_implicitly(double depth, const Effort &effort) {
        advance_alone(effort);
        needle_->act(nodes_, depth, plan_.frame_interval);
        force_ = needle_->force();
        Field forces = Field::Zero(3, simulation_->positions().cols());
        for (std::size_t i = 0; i < needle_->nodes().size(); ++i)
            forces.col(needle_->nodes()[i]) = needle_->nodal_forces()[i];
        simulation_->set_external_forces(forces);
    }

    Method method_;
    NeedlePlan plan_;
    std::unique_ptr<Simulation> simulation_;
    NodesOfSimulation nodes_;
    std::optional<core::MovingNeedle> needle_;
    int least_steps_ = 0; ///< in a frame; zero where every step is stable
    double force_ = 0.0;  ///< [N]

    // Of implicit methods.
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights_; ///< of the places
    double force_of_observation_ = 0.0;                    ///< [N]
};

} // namespace

PrepareNeedled needled_interactive(const Method &method) {
    return [method](const core::Problem &problem, const core::Needle &needle,
                    const NeedlePlan &plan) -> std::unique_ptr<NeedledBody> {
        return std::make_unique<NeedledInteractive>(method, problem, needle, plan);
    };
}

} // namespace livermark::models
