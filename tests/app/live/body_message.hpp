#pragma once

#include <optional>
#include <vector>

#include "core/events.hpp"
#include "core/problem.hpp"

namespace livermark::live {

/// Message of scene_of() to a body.
inline std::vector<double> body_message(const core::Body &body, const std::vector<bool> &is_constrained,
                                        const std::optional<core::Foundation> &foundation = {}) {
    const auto &mesh = body.mesh;
    std::vector<double> message;
    const auto append = [&](auto... numbers) { (message.push_back(static_cast<double>(numbers)), ...); };
    const auto append_all = [&](const auto &numbers) { message.insert(message.end(), numbers.begin(), numbers.end()); };
    append(mesh.points.size(), mesh.tetrahedra.size(), body.materials.size(), mesh.boundary_triangles.size());
    for (const auto &x : mesh.points)
        append_all(x);
    for (const auto &nodes : mesh.tetrahedra)
        append_all(nodes);
    append_all(mesh.region);
    for (const auto value : {&core::Material::density, &core::Material::young_modulus, &core::Material::poisson_ratio})
        for (const auto &material : body.materials)
            append(material.*value);
    for (const auto &nodes : mesh.boundary_triangles)
        append_all(nodes);
    append_all(is_constrained);
    append(body.modulus_factor.size());
    append_all(body.modulus_factor);
    append(body.capsule.has_value());
    if (body.capsule) {
        append(body.capsule->thickness, body.capsule->young_modulus);
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            append(core::Capsule::covers(mesh, f));
    }
    append(body.vessels ? body.vessels->points.size() : 0);
    if (body.vessels) {
        const auto &tree = *body.vessels;
        append(tree.segments.size());
        for (const auto &x : tree.points)
            append_all(x);
        append_all(tree.radius);
        for (const auto &segment : tree.segments)
            append_all(segment);
        append(tree.wall_ratio, tree.wall_modulus);
    }
    append(foundation ? foundation->facets.size() : 0);
    if (foundation) {
        append_all(foundation->facets);
        append_all(foundation->stiffness);
        append_all(foundation->normal_only);
    }
    return message;
}

} // namespace livermark::live
