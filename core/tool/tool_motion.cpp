#include "core/tool/tool_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace livermark::core {

double smooth_step(double time, double from, double until) {
    const double s = std::clamp((time - from) / (until - from), 0.0, 1.0);
    return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

ToolPosition tool_position(const ToolMotion &motion, double time) {
    return {smooth_step(time, 0.0, motion.press_until), smooth_step(time, motion.slide_from, motion.slide_until)};
}

std::vector<double> record_times(const ToolMotion &motion) {
    std::vector<double> time;
    for (int record = 0; record < motion.num_records(); ++record)
        time.push_back(motion.time_of(record));
    return time;
}

int last_record_held(const ToolMotion &motion) {
    return static_cast<int>(std::lround(motion.release_at / motion.frame_interval));
}

LoadCase let_go(LoadCase load_case) {
    const int place = load_case.tool.value().constraint;
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.constraint_on(f) == place)
            load_case.free_facet(f);
    load_case.touching.reset();
    return load_case;
}

LoadCase with_slide(LoadCase load_case) {
    const auto &tool = load_case.tool.value();
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.constraint_on(f) == tool.constraint)
            load_case.value[f] = tool.slide;
    load_case.node_factor.clear();
    load_case.node_shift.clear();
    return load_case;
}

} // namespace livermark::core
