#include "core/tool/touching_tool.hpp"

#include <algorithm>

namespace livermark::core {

namespace {

Eigen::Matrix3d along_surface(const Vector3 &normal) {
    return Eigen::Matrix3d::Identity() - normal * normal.transpose();
}

/// tau' [Pa]
Vector3 trial_friction(const ContactLaw &law, const Vector3 &normal, const Vector3 &from_anchor) {
    return -law.tangential_penalty * (from_anchor - normal.dot(from_anchor) * normal);
}

} // namespace

Gap gap_to(double radius, const Vector3 &from_centre) {
    const double distance = from_centre.norm();
    return {distance - radius, from_centre / distance};
}

Contact touch(const ContactLaw &law, double radius, const Vector3 &from_centre, const ContactMemory &memory) {
    Contact contact{.gap = gap_to(radius, from_centre)};
    contact.pressure = std::max(0.0, memory.multiplier - law.penalty * contact.gap.size);
    if (!contact.touches() || law.friction == 0.0)
        return contact;
    contact.friction = trial_friction(law, contact.gap.normal, from_centre - memory.anchor);
    const double size = contact.friction.norm(), most = law.friction * contact.pressure;
    contact.slips = size > most;
    if (contact.slips)
        contact.friction *= most / size;
    return contact;
}

double contact_energy(const ContactLaw &law, const Contact &contact, const ContactMemory &memory) {
    return (contact.pressure * contact.pressure - memory.multiplier * memory.multiplier) / (2.0 * law.penalty);
}

ContactStiffness contact_stiffness(const ContactLaw &law, const Vector3 &from_centre, const ContactMemory &memory,
                                   const Contact &contact) {
    ContactStiffness result;
    if (!contact.touches())
        return result;
    const auto &normal = contact.gap.normal;
    const Eigen::Matrix3d along = along_surface(normal);
    const double distance = from_centre.norm();
    result.positive = law.penalty * normal * normal.transpose();
    result.rest = -contact.pressure / distance * along;
    if (law.friction == 0.0)
        return result;
    const Vector3 from_anchor = from_centre - memory.anchor;
    // Minus the derivative of tau': that of the step, and that of the plane which it is projected on.
    const Eigen::Matrix3d of_step = law.tangential_penalty * along;
    const Eigen::Matrix3d of_plane = -law.tangential_penalty / distance *
                                     (normal.dot(from_anchor) * along + normal * (along * from_anchor).transpose());
    if (!contact.slips) {
        result.positive += of_step;
        result.rest += of_plane;
        return result;
    }
    const Vector3 trial = trial_friction(law, normal, from_anchor);
    const Vector3 direction = trial / trial.norm();
    const double shorter = law.friction * contact.pressure / trial.norm();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    result.positive += shorter * across * of_step;
    result.rest += shorter * across * of_plane + law.friction * law.penalty * direction * normal.transpose();
    return result;
}

ContactMemory after_step(const ContactLaw &law, const Vector3 &from_centre, const ContactMemory &memory,
                         const Contact &contact) {
    if (!contact.touches() || law.friction == 0.0)
        return {memory.multiplier, from_centre};
    if (!contact.slips)
        return memory;
    return {memory.multiplier, from_centre + contact.friction / law.tangential_penalty};
}

} // namespace livermark::core
