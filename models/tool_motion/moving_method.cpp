#include "models/tool_motion/moving_method.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "models/tool_motion/moving_methods.hpp"

namespace livermark::models {

const char *to_string(Setting setting) {
    switch (setting) {
    case Setting::one_step:
        return "one step";
    case Setting::ten_iterations:
        return "ten iterations";
    case Setting::one_iteration:
        return "one iteration";
    }
    std::unreachable();
}

std::vector<MovingMethod> all_moving_methods(Precision precision) {
    auto methods = moving_springs();
    std::ranges::move(interactive_moving_methods(precision), std::back_inserter(methods));
    return methods;
}

} // namespace livermark::models
