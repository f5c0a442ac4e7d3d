#include <cmath>
#include <optional>
#include <utility>

#include "models/needle_motion/needled_methods.hpp"
#include "models/tool_motion/frame_steps.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/needle/moving_needle.hpp"

namespace livermark::models {

namespace {

/// Steps of symplectic Euler on vector units, forces in single precision, and the needle after each.
class NeedledSprings : public NeedledBody {
  public:
    NeedledSprings(livermark::msm::ElasticBody springs, const core::Problem &problem, const core::Needle &needle,
                   const NeedlePlan &plan)
        : body_(problem.body), springs_(std::move(springs)), plan_(plan),
          conditions_(livermark::msm::nodal_conditions(problem, springs_.node_mass)),
          needle_(needle, body_->mesh, springs_.node_mass, conditions_) {
        const double highest = livermark::msm::largest_angular_frequency(springs_, body_->mesh.points, conditions_);
        const double longest = livermark::msm::default_safety_factor * 2.0 / highest;
        least_steps_ = static_cast<int>(std::ceil(plan_.frame_interval / longest));
        take_steps_of(least_steps_);
        needle_.begin(*steps_);
    }

    void prepare_for(const Effort &effort) override {
        if (effort.steps != num_steps_)
            take_steps_of(effort.steps);
    }

    void advance(double depth, const Effort &effort) override {
        prepare_for(effort);
        const double start = needle_.depth(), step = plan_.frame_interval / num_steps_;
        force_ = 0.0;
        for (int s = 1; s <= num_steps_; ++s) {
            steps_->take(1);
            needle_.act(*steps_, start + (depth - start) * s / num_steps_, step);
            force_ += needle_.force() / num_steps_;
        }
    }

    void advance_alone(const Effort &effort) override {
        prepare_for(effort);
        steps_->take(num_steps_);
    }

    void take_motion_of(const NeedledBody &other) override {
        steps_->set_state(dynamic_cast<const NeedledSprings &>(other).steps_->state());
    }

    std::vector<core::Vector3> displacement() const override {
        return livermark::msm::to_field(steps_->state().displacement);
    }

    NeedleReading reading() const override {
        return {.force = force_, .tip = needle_.tip(), .places = needle_.place_displacements(*steps_)};
    }

    FrameCost cost(const Effort &effort) const override { return frame_cost(*steps_, *body_, effort); }

    std::optional<Effort> least_effort() const override { return Effort{.steps = least_steps_}; }

  private:
    void take_steps_of(int num_steps) {
        auto steps = frame_steps(springs_, *body_, conditions_, plan_.mass_damping, plan_.frame_interval / num_steps);
        if (steps_)
            steps.set_state(steps_->state());
        steps_ = std::move(steps);
        num_steps_ = num_steps;
    }

    std::shared_ptr<const core::Body> body_;
    livermark::msm::ElasticBody springs_;
    NeedlePlan plan_;
    livermark::msm::NodalConditions conditions_;
    livermark::msm::MovingNeedle needle_;
    int least_steps_ = 1, num_steps_ = 0; ///< in a frame: at least, and those that are taken
    std::optional<livermark::msm::FastSteps> steps_;
    double force_ = 0.0;
};

} // namespace

PrepareNeedled needled_springs(const MovingSpringModel &model) {
    return [make = model.make](const core::Problem &problem, const core::Needle &needle,
                               const NeedlePlan &plan) -> std::unique_ptr<NeedledBody> {
        return std::make_unique<NeedledSprings>(make(*problem.body), problem, needle, plan);
    };
}

} // namespace livermark::models
