#include "models/tool_motion/contender.hpp"

#include <algorithm>
#include <iterator>

#include "models/tool_motion/contenders.hpp"

namespace livermark::models {

const char *to_string(Setting setting) {
    return setting == Setting::one_step ? "one step" : "one iteration";
}

std::vector<Contender> all_contenders(Precision precision) {
    auto contenders = spring_contenders();
    std::ranges::move(interactive_contenders(precision), std::back_inserter(contenders));
    return contenders;
}

} // namespace livermark::models
