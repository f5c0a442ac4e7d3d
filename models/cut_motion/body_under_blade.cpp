#include "models/cut_motion/body_under_blade.hpp"

#include <cmath>
#include <utility>

#include "interactive/cutting/cut_motion.hpp"
#include "models/tool_motion/frame_steps.hpp"
#include "models/tool_motion/moving_methods.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/cutting/part_of_body.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/kernels/fast_steps.hpp"

namespace livermark::models {

namespace {

using livermark::interactive::Method;

livermark::interactive::Field field_on_nodes(const std::vector<core::Vector3> &vectors) {
    livermark::interactive::Field field(3, static_cast<Eigen::Index>(vectors.size()));
    for (std::size_t i = 0; i < vectors.size(); ++i)
        field.col(static_cast<Eigen::Index>(i)) = vectors[i];
    return field;
}

class InteractiveUnderBlade : public BodyUnderBlade {
  public:
    InteractiveUnderBlade(const Method &method, const ProblemOnNodes &problem, const FramesUnderBlade &frames)
        : method_(&method), interval_(frames.interval) {
        livermark::interactive::Scene scene{.body = problem.body,
                                            .node_mass = problem.node_mass,
                                            .constrained_nodes = {},
                                            .mass_damping = frames.mass_damping};
        for (std::size_t i = 0; i < problem.node_mass.size(); ++i)
            if (!problem.conditions.displacement[i].array().isNaN().any())
                scene.constrained_nodes.push_back(static_cast<int>(i));
        simulation_ = method.prepare(scene);
        apply(problem);
        if (method.is_explicit)
            least_steps_ = static_cast<int>(
                std::ceil(interval_ / (livermark::msm::default_safety_factor * simulation_->critical_time_step())));
    }

    void prepare_for(const Effort &effort) override {
        step_ = interval_ / effort.steps;
        simulation_->prepare(step_);
    }

    void advance(double /*start*/, const Effort &effort) override {
        for (int s = 0; s < effort.steps; ++s)
            simulation_->step(interval_ / effort.steps, effort.iterations);
    }

    void cut(const ProblemOnNodes &after, const std::vector<int> &parent_tetrahedron) override {
        simulation_ = livermark::interactive::continue_after_cut(
            *method_, *simulation_,
            {.body = after.body, .node_mass = after.node_mass, .parent_tetrahedron = parent_tetrahedron});
        apply(after);
        if (step_ > 0.0)
            simulation_->prepare(step_);
    }

    std::vector<core::Vector3> displacement() const override { return displacement_of(*simulation_); }

    FrameCost cost(const Effort &effort) const override { return frame_cost(*simulation_, effort); }

    std::optional<Effort> least_effort() const override {
        return least_steps_ == 0 ? std::nullopt : std::optional(Effort{.iterations = least_steps_});
    }

  private:
    void apply(const ProblemOnNodes &problem) {
        simulation_->set_external_forces(field_on_nodes(problem.conditions.force));
        auto targets = simulation_->targets();
        const auto &nodes = simulation_->scene().constrained_nodes;
        for (std::size_t c = 0; c < nodes.size(); ++c)
            targets.col(static_cast<Eigen::Index>(c)) =
                problem.body->mesh.points[nodes[c]] + problem.conditions.displacement[nodes[c]];
        simulation_->set_targets(targets);
    }

    const Method *method_;
    double interval_;
    std::unique_ptr<livermark::interactive::Simulation> simulation_;
    int least_steps_ = 0; ///< in a frame; zero where every step is stable
    double step_ = 0.0;   ///< that is prepared [s]
};

/// Steps of symplectic Euler on vector units. Nodes and tetrahedra keep their numbers, and what a cut changes is made
/// again around it.
class SpringsUnderBlade : public BodyUnderBlade {
  public:
    SpringsUnderBlade(const MovingSpringModel &model, const ProblemOnNodes &problem, const FramesUnderBlade &frames)
        : frames_(frames), body_(problem.body), numbers_(problem.body->mesh) {
        const auto springs = model.make(*body_);
        const double highest =
            livermark::msm::largest_angular_frequency(springs, body_->mesh.points, problem.conditions);
        least_steps_ =
            static_cast<int>(std::ceil(frames.interval * highest / (2.0 * livermark::msm::default_safety_factor)));
        num_steps_ = least_steps_;
        steps_ = frame_steps(springs, *body_, problem.conditions, frames_.mass_damping, frames_.interval / num_steps_,
                             {.may_be_cut = true});
        parts_ = livermark::msm::CutParts::prepare(*body_, springs, model.spring_source(*body_));
    }

    void prepare_for(const Effort &effort) override {
        if (effort.steps == num_steps_)
            return;
        num_steps_ = effort.steps;
        steps_->set_time_step(frames_.interval / num_steps_);
    }

    void advance(double /*start*/, const Effort &effort) override {
        prepare_for(effort);
        steps_->take(num_steps_);
    }

    void cut(const ProblemOnNodes &after, const std::vector<int> &parent_tetrahedron) override {
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

    std::vector<core::Vector3> displacement() const override {
        std::vector<core::Vector3> result(numbers_.nodes().size());
        steps_->displacements(numbers_.nodes(), result);
        return result;
    }

    FrameCost cost(const Effort &effort) const override { return frame_cost(*steps_, *body_, effort); }

    std::optional<Effort> least_effort() const override { return Effort{.steps = least_steps_}; }

  private:
    FramesUnderBlade frames_;
    std::shared_ptr<const core::Body> body_;
    livermark::msm::KeptNumbers numbers_;
    int least_steps_ = 1, num_steps_ = 1; ///< in a frame: at least, and those that are taken
    std::optional<livermark::msm::FastSteps> steps_;
    std::optional<livermark::msm::CutParts> parts_;
};

} // namespace

ProblemOnNodes on_nodes(const core::Problem &problem) {
    auto masses = livermark::msm::lumped_masses(*problem.body);
    auto conditions = livermark::msm::nodal_conditions(problem, masses);
    return {problem.body, std::move(masses), std::move(conditions)};
}

std::vector<MethodUnderBlade> methods_under_blade() {
    std::vector<MethodUnderBlade> methods;
    for (const auto &model : moving_spring_models())
        methods.push_back({model.name, [&model](const ProblemOnNodes &problem, const FramesUnderBlade &frames) {
                               return std::unique_ptr<BodyUnderBlade>(
                                   std::make_unique<SpringsUnderBlade>(model, problem, frames));
                           }});
    for (const auto &method : livermark::interactive::all_methods())
        methods.push_back({method.name, [&method](const ProblemOnNodes &problem, const FramesUnderBlade &frames) {
                               return std::unique_ptr<BodyUnderBlade>(
                                   std::make_unique<InteractiveUnderBlade>(method, problem, frames));
                           }});
    return methods;
}

} // namespace livermark::models
