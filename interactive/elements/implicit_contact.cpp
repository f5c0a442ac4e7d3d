#include "interactive/elements/implicit_contact.hpp"

namespace livermark::interactive {

core::Vector3 ImplicitContact::linearise_at(Point &point, const core::Vector3 &x) const {
    point.stiffness.setZero();
    point.force.setZero();
    const core::Vector3 from_centre = x - step_.to;
    const double distance = from_centre.norm(), depth = step_.radius - distance;
    if (depth <= 0.0 || distance == 0.0)
        return core::Vector3::Zero();
    const core::Vector3 normal = from_centre / distance;
    const double size = depth / point.compliance;
    point.stiffness = normal * normal.transpose() / point.compliance;
    point.force = normal * ((depth + normal.dot(x - point.start)) / point.compliance);
    if (step_.friction == 0.0)
        return size * normal;
    const auto across = [&](const core::Vector3 &v) { return core::Vector3(v - normal.dot(v) * normal); };
    const core::Vector3 of_ball = step_.to - step_.from;
    const core::Vector3 sticking = across(point.before) - across(x - point.start - of_ball) / point.compliance;
    const double length = sticking.norm(), limit = step_.friction * size;
    const double share = length > limit ? limit / length : 1.0;
    point.stiffness += share / point.compliance * (Matrix3::Identity() - normal * normal.transpose());
    point.force += share * (across(point.before) + across(of_ball) / point.compliance);
    return size * normal + share * sticking;
}

} // namespace livermark::interactive
