#include "models/needle_motion/needled_body.hpp"

#include <algorithm>
#include <cmath>

#include "models/needle_motion/needled_methods.hpp"

namespace livermark::models {

namespace {

constexpr double of_a_frame = 1e-9; ///< rounding of lengths over the way of a frame

} // namespace

int NeedlePlan::at_plan(const core::Needle &needle) const {
    return std::max(1, static_cast<int>(std::ceil(needle.depth() / (speed * frame_interval) - of_a_frame)));
}

int NeedlePlan::num_frames(const core::Needle &needle) const {
    return 2 * at_plan(needle) + static_cast<int>(std::lround(rest / frame_interval));
}

double NeedlePlan::depth_after(const core::Needle &needle, int frame) const {
    const int in = at_plan(needle), steps = std::min({frame, in, num_frames(needle) - frame});
    return needle.depth() * steps / in;
}

std::vector<NeedledMethod> all_needled_methods() {
    std::vector<NeedledMethod> methods;
    const auto springs = moving_spring_models();
    const auto interactive_methods = livermark::interactive::all_methods();
    for (auto &moving : all_moving_methods()) {
        auto &method = methods.emplace_back(NeedledMethod{.texts = std::move(moving), .prepare = {}});
        const auto &name = method.texts.name;
        const auto spring = std::ranges::find(springs, name, &MovingSpringModel::name);
        const auto other = std::ranges::find(interactive_methods, name, &livermark::interactive::Method::name);
        if (spring != springs.end())
            method.prepare = needled_springs(*spring);
        else if (other != interactive_methods.end())
            method.prepare = needled_interactive(*other);
        else
            method.obstacle = "the masses of its stiff parts are scaled, and impulses of a needle are those of true "
                              "masses";
    }
    return methods;
}

} // namespace livermark::models
