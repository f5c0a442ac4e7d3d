#include "core/tool/tool_errors.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace livermark::core {

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
