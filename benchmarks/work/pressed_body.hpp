#pragma once

#include <memory>
#include <string>

#include "core/problem.hpp"
#include "models/motion/moving_method.hpp"

namespace livermark::benchmarks {

/// What a step of methods that have a choice of iterations does in these benchmarks: about what their users take.
inline constexpr models::Effort usual_effort{.steps = 1, .iterations = 10};

/// A body of bodies.hpp under the tool of the load case press_and_slide.
/// @throws support::InputError if there is none of that name
core::Problem pressed_problem(const std::string &body);

/// A method on it, with the tool half the way in.
class PressedBody {
  public:
    /// Goes there frame by frame, as in the arena: a tool that jumps throws springs out of all bounds.
    PressedBody(const models::MovingMethod &method, std::shared_ptr<const core::Problem> problem);

    const core::Problem &problem() const { return *problem_; }
    const models::MovingBody &body() const { return *body_; }
    /// Steps of all methods, also of those that call the steps of a frame iterations.
    int steps_in_frame() const;
    /// The least that is stable, or usual_effort.
    const models::Effort &effort() const { return effort_; }
    /// Another frame, in which the tool stays about where it is.
    void advance();
    bool has_left_all_bounds() const;

  private:
    std::shared_ptr<const core::Problem> problem_;
    std::unique_ptr<models::MovingBody> body_;
    models::Effort effort_;
    bool is_explicit_ = false;
};

} // namespace livermark::benchmarks
