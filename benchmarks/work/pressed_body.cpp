#include "benchmarks/work/pressed_body.hpp"

#include <algorithm>
#include <utility>

#include "benchmarks/bodies.hpp"
#include "core/mesh/bounding_box.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "support/root_folder.hpp"

namespace livermark::benchmarks {

namespace {

constexpr int num_warm_up_frames = 3;
constexpr double way_in = 0.5; ///< of the press, where the tool is

} // namespace

core::Problem pressed_problem(const std::string &body_name) {
    const auto body = make_body(body_name);
    return {body, load_cases::read_load_case(support::root_folder() / "load_cases" / "moving" / "press_and_slide.toml",
                                             body->mesh)};
}

PressedBody::PressedBody(const models::MovingMethod &method, std::shared_ptr<const core::Problem> problem)
    : problem_(std::move(problem)), body_(method.prepare(*problem_)) {
    const auto least = body_->least_effort();
    is_explicit_ = least.has_value();
    effort_ = least.value_or(usual_effort);
    body_->prepare_for(effort_);
    const auto &tool = *problem_->load_case.tool;
    for (double time = tool.frame_interval; time < way_in * tool.press_until; time += tool.frame_interval)
        body_->advance(time, effort_);
    for (int f = 0; f < num_warm_up_frames; ++f)
        advance();
}

int PressedBody::steps_in_frame() const {
    return is_explicit_ ? effort_.steps * effort_.iterations : effort_.steps;
}

void PressedBody::advance() {
    body_->advance(way_in * problem_->load_case.tool->press_until, effort_);
}

bool PressedBody::has_left_all_bounds() const {
    const double bound = core::extent(problem_->body->mesh.points);
    return !std::ranges::all_of(body_->displacement(),
                                [&](const core::Vector3 &u) { return u.lpNorm<Eigen::Infinity>() < bound; });
}

} // namespace livermark::benchmarks
