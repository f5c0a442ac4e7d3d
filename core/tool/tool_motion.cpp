#include "core/tool/tool_motion.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
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

namespace {

/// Squares of a difference and of what it is a part of.
struct Squares {
    double difference = 0.0, reference = 0.0;
    Squares &operator+=(const Squares &other) {
        difference += other.difference;
        reference += other.reference;
        return *this;
    }
    double ratio() const { return std::sqrt(difference / reference); }
};

} // namespace

ToolErrors compare(const TetraMesh &mesh, const ToolMotion &motion, const ToolHistory &history,
                   const ToolHistory &reference) {
    const auto num_nodes = mesh.points.size();
    if (history.time.size() != reference.time.size() || history.force.size() != reference.force.size() ||
        history.displacement.size() != reference.displacement.size() || reference.displacement.size() % num_nodes != 0)
        throw std::invalid_argument("two motions under a tool with other records or nodes");
    const auto volume = nodal_volumes(mesh);
    ToolErrors errors;
    Squares contact, after, force;
    double largest = 0.0;
    std::size_t field = 0;
    const int last_held = last_record_held(motion);
    for (std::size_t k = 0; k < reference.time.size(); ++k) {
        const bool is_held = static_cast<int>(k) <= last_held;
        if (is_held)
            force += {(history.force[k] - reference.force[k]).squaredNorm(), reference.force[k].squaredNorm()};
        if (!ToolHistory::has_field(static_cast<int>(k)))
            continue;
        Squares now;
        for (std::size_t i = 0; i < num_nodes; ++i) {
            const Vector3 u = history.displacement[field * num_nodes + i].cast<double>();
            const Vector3 r = reference.displacement[field * num_nodes + i].cast<double>();
            now += {volume[i] * (u - r).squaredNorm(), volume[i] * r.squaredNorm()};
        }
        (is_held ? contact : after) += now;
        errors.over_time.push_back(std::sqrt(now.difference));
        largest = std::max(largest, std::sqrt(now.reference));
        ++field;
    }
    for (double &error : errors.over_time)
        error /= largest;
    errors.contact = contact.ratio();
    errors.after = after.ratio();
    errors.force = force.ratio();
    return errors;
}

} // namespace livermark::core
