#include "core/tool/touching_tool.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/load_case.hpp"

namespace livermark::core {

namespace {

Eigen::Matrix3d along_surface(const Vector3 &normal) {
    return Eigen::Matrix3d::Identity() - normal * normal.transpose();
}

/// tau' [Pa]
Vector3 trial_friction(const ContactLaw &law, const Vector3 &normal, const Vector3 &from_anchor) {
    return -law.tangential_penalty * (from_anchor - normal.dot(from_anchor) * normal);
}

/// Nearest point of the flat of a plate or of what is behind it.
struct NearestOfPlate {
    Vector3 from = Vector3::Zero();                   ///< x - p [m]
    Eigen::Matrix3d slides = Eigen::Matrix3d::Zero(); ///< dp/dx
    bool is_on_face = false;                          ///< whether x is before or behind the flat
};

NearestOfPlate nearest_of_plate(const ToolShape &plate, const Vector3 &from_centre) {
    NearestOfPlate nearest{.is_on_face = true};
    const double height = plate.axis.dot(from_centre);
    const Vector3 across = from_centre - height * plate.axis;
    Vector3 on_flat = across;
    if (const double distance = across.norm(); plate.face == ToolFace::round && distance > plate.size) {
        const Vector3 out = across / distance;
        nearest.is_on_face = false;
        on_flat = plate.size * out;
        nearest.slides = plate.size / distance * (along_surface(plate.axis) - out * out.transpose());
    } else if (plate.face == ToolFace::square) {
        for (const Vector3 &side : {plate.side, Vector3(plate.axis.cross(plate.side))}) {
            const double at = side.dot(across), beyond = at - std::clamp(at, -plate.size, plate.size);
            on_flat -= beyond * side;
            if (beyond == 0.0)
                nearest.slides += side * side.transpose();
            else
                nearest.is_on_face = false;
        }
    }
    nearest.from = across - on_flat;
    if (nearest.is_on_face || height > 0.0)
        nearest.from += height * plate.axis;
    else
        nearest.slides += plate.axis * plate.axis.transpose();
    return nearest;
}

} // namespace

const char *to_string(ToolFace face) {
    return face == ToolFace::ball ? "ball" : face == ToolFace::round ? "round" : "square";
}

ToolShape::ToolShape(ToolFace flat, double half_width, double edge_radius, const Vector3 &press)
    : radius(edge_radius), face(flat), size(half_width), axis(press.normalized()) {
    Eigen::Index along = 0;
    axis.cwiseAbs().minCoeff(&along);
    side = along_surface(axis).col(along).normalized();
}

Gap gap_to(const ToolShape &shape, const Vector3 &from_centre) {
    if (!shape.is_plate()) {
        const double distance = from_centre.norm();
        return {distance - shape.radius, from_centre / distance, distance};
    }
    const auto nearest = nearest_of_plate(shape, from_centre);
    if (nearest.is_on_face)
        return {shape.axis.dot(nearest.from) - shape.radius, shape.axis, shape.radius};
    const double distance = nearest.from.norm();
    return {distance - shape.radius, nearest.from / distance, distance};
}

Eigen::Matrix3d bend(const ToolShape &shape, const Vector3 &from_centre, const Gap &gap) {
    if (!shape.is_plate())
        return along_surface(gap.normal);
    const auto nearest = nearest_of_plate(shape, from_centre);
    if (nearest.is_on_face)
        return Eigen::Matrix3d::Zero();
    return along_surface(gap.normal) - nearest.slides;
}

Contact touch(const ContactLaw &law, const ToolShape &shape, const Vector3 &from_centre, const ContactMemory &memory) {
    Contact contact{.gap = gap_to(shape, from_centre)};
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

ContactStiffness contact_stiffness(const ContactLaw &law, const ToolShape &shape, const Vector3 &from_centre,
                                   const ContactMemory &memory, const Contact &contact) {
    ContactStiffness result;
    if (!contact.touches())
        return result;
    const auto &normal = contact.gap.normal;
    const Eigen::Matrix3d along = along_surface(normal), bends = bend(shape, from_centre, contact.gap);
    const double distance = contact.gap.distance;
    result.positive = law.penalty * normal * normal.transpose();
    result.rest = -contact.pressure / distance * bends;
    if (law.friction == 0.0)
        return result;
    const Vector3 from_anchor = from_centre - memory.anchor;
    // Minus the derivative of tau': that of the step, and that of the plane which it is projected on.
    const Eigen::Matrix3d step_part = law.tangential_penalty * along;
    const Eigen::Matrix3d plane_part = -law.tangential_penalty / distance *
                                       (normal.dot(from_anchor) * bends + normal * (bends * from_anchor).transpose());
    if (!contact.slips) {
        result.positive += step_part;
        result.rest += plane_part;
        return result;
    }
    const Vector3 trial = trial_friction(law, normal, from_anchor);
    const Vector3 direction = trial / trial.norm();
    const double shorter = law.friction * contact.pressure / trial.norm();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    result.positive += shorter * across * step_part;
    result.rest += shorter * across * plane_part + law.friction * law.penalty * direction * normal.transpose();
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

namespace {

constexpr int most_divisions = 8;

double mean_side(const Corners &corners) {
    return ((corners[0] - corners[1]).norm() + (corners[1] - corners[2]).norm() + (corners[2] - corners[0]).norm()) /
           3.0;
}

std::array<int, 3> sorted(std::array<int, 3> nodes) {
    std::ranges::sort(nodes);
    return nodes;
}

/// E / (1 - nu^2) of what is behind each facet, by its nodes in ascending order [Pa].
std::map<std::array<int, 3>, double> moduli_behind_facets(const Body &body) {
    const auto &mesh = body.mesh;
    std::map<std::array<int, 3>, double> moduli;
    for (const auto &facet : mesh.boundary_triangles)
        moduli.emplace(sorted(facet), 0.0);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        for (const auto &face : tetrahedron_faces) {
            const auto &nodes = mesh.tetrahedra[t];
            const auto facet = moduli.find(sorted({nodes[face[0]], nodes[face[1]], nodes[face[2]]}));
            if (facet == moduli.end())
                continue;
            const auto material = body.material_of(t);
            facet->second = material.young_modulus / (1.0 - material.poisson_ratio * material.poisson_ratio);
        }
    return moduli;
}

} // namespace

double FacetSoftness::at(double circle_over_side) const {
    const double faded = circle_over_side / fades_at;
    // The last digits of exp() are those of a C library; what is left of them is the same everywhere.
    constexpr double kept = 1e12;
    return std::max(at_first * (std::round(kept * std::exp(-faded * faded)) / kept), least);
}

std::vector<TouchedFacet> touched_facets(const Body &body, const LoadCase &load_case, const FacetSoftness &softness) {
    const auto moduli = moduli_behind_facets(body);
    std::vector<TouchedFacet> facets;
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.may_touch(f)) {
            const auto &nodes = body.mesh.boundary_triangles[f];
            const Vector3 area = area_vector(body.mesh, f);
            facets.push_back({nodes, area.norm(), area.normalized(), mean_side(corners_of(body.mesh, f)),
                              moduli.at(sorted(nodes)), softness});
        }
    return facets;
}

double circle_of_contact(const TouchingTool &tool, double part) {
    return tool.shape.contact_radius(std::min(part / tool.pressed_at(), 1.0) * tool.press.norm());
}

int contact_divisions(const Body &body, const LoadCase &load_case) {
    double sum = 0.0;
    int number = 0;
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.may_touch(f)) {
            sum += mean_side(corners_of(body.mesh, f));
            ++number;
        }
    const double longest = load_case.contacts().at(0).radius;
    return number == 0 ? 1 : std::clamp(static_cast<int>(std::ceil(sum / number / longest)), 1, most_divisions);
}

} // namespace livermark::core
