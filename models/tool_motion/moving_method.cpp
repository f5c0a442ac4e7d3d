#include "models/tool_motion/moving_method.hpp"

#include <algorithm>
#include <iterator>

#include "models/tool_motion/moving_methods.hpp"

namespace livermark::models {

const char *to_string(Setting setting) {
    if (setting == Setting::one_step)
        return "one step";
    return setting == Setting::ten_iterations ? "ten iterations" : "one iteration";
}

std::vector<MovingMethod> all_moving_methods() {
    auto methods = moving_springs();
    std::ranges::move(interactive_moving_methods(), std::back_inserter(methods));
    return methods;
}

} // namespace livermark::models
