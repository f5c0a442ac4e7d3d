#include "python/bindings/body.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <map>
#include <numbers>

#include "core/mesh/neighbours.hpp"
#include "core/mesh/overlaps.hpp"
#include "core/mesh/plausible_liver.hpp"
#include "support/input_error.hpp"

namespace livermark::python {

namespace {

/// Of its volume, as a part of that of the regular tetrahedron with its longest edge: flatter ones have no stiffness
/// that a double can hold.
constexpr double flat = 1e-9;

void check_volumes(const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        double longest = 0.0;
        for (const auto &[a, b] : core::tetrahedron_edges)
            longest =
                std::max(longest, (mesh.points[mesh.tetrahedra[t][b]] - mesh.points[mesh.tetrahedra[t][a]]).norm());
        const double part = 6.0 * std::numbers::sqrt2 * volumes[t] / (longest * longest * longest);
        if (!(part > flat))
            throw support::InputError(fmt::format("tetrahedra: number {} {}; {}", t,
                                                  part < -flat ? "is inverted" : "is flat",
                                                  part < -flat ? "exchange two of its nodes" : "remesh there"));
    }
}

void check_nodes(const core::TetraMesh &mesh) {
    std::vector<bool> is_used(mesh.points.size(), false);
    for (const auto &nodes : mesh.tetrahedra)
        for (const int node : nodes)
            is_used[node] = true;
    const auto unused = std::ranges::find(is_used, false);
    if (unused != is_used.end())
        throw support::InputError(
            fmt::format("points: number {} belongs to no tetrahedron; remove it", unused - is_used.begin()));
}

void warn(const std::string &text) {
    if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0)
        throw py::error_already_set();
}

void check_overlaps(const core::TetraMesh &mesh) {
    if (const auto two = core::tetrahedra_of_same_nodes(mesh.tetrahedra))
        throw support::InputError(
            fmt::format("tetrahedra: numbers {} and {} have the same nodes; remove one", two->first, two->second));
    if (const auto face = core::face_of_too_many(core::sorted_faces(mesh.tetrahedra)))
        throw support::InputError(
            fmt::format("tetrahedra: more than two have the face of points {} {} {}; remesh without overlaps",
                        face->at(0), face->at(1), face->at(2)));
    // Arrays do not say where a body was parted, so this may be as it is meant.
    if (const auto two = core::nodes_in_one_place(mesh.points))
        warn(fmt::format(
            "points: numbers {} and {} have the same coordinates; merge them, unless a cut parts the body there",
            two->first, two->second));
}

/// Says in a warning what speaks against lengths in metres.
void warn_of_unit(const core::TetraMesh &mesh) {
    for (const auto &doubt : core::doubts_about_unit(mesh.points))
        warn(fmt::format("points: {}", doubt));
}

void check(const core::Material &material) {
    if (!(material.density > 0.0))
        throw support::InputError(fmt::format("density: {} kg/m^3; it has to be positive", material.density));
    if (!(material.young_modulus > 0.0))
        throw support::InputError(fmt::format("young_modulus: {} Pa; it has to be positive", material.young_modulus));
    if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5))
        throw support::InputError(
            fmt::format("poisson_ratio: {}; it has to lie between -1 and 0.5, both excluded", material.poisson_ratio));
    if (material.poisson_ratio > core::largest_poisson_ratio)
        throw support::InputError(
            fmt::format("poisson_ratio: {:.12g} is so close to 0.5 that its equations have no solution "
                        "in double precision; take {} at most",
                        material.poisson_ratio, core::largest_poisson_ratio));
}

} // namespace

core::Body to_body(const py::handle &points, const py::handle &tetrahedra, const py::handle &young_modulus,
                   const py::handle &poisson_ratio, const py::handle &density) {
    core::Body body;
    body.name = "body";
    auto &mesh = body.mesh;
    mesh.points = to_vectors(points, "points");
    const auto nodes = to_node_numbers(tetrahedra, "tetrahedra", 4, mesh.points.size());
    if (nodes.empty())
        throw support::InputError("tetrahedra: there are none; mesh the volume, not only the surface");
    for (std::size_t i = 0; i < nodes.size(); i += 4)
        mesh.tetrahedra.push_back({nodes[i], nodes[i + 1], nodes[i + 2], nodes[i + 3]});
    check_volumes(mesh);
    check_nodes(mesh);
    check_overlaps(mesh);
    if (const auto apart = core::apart_by_faces(mesh.tetrahedra))
        throw support::InputError(fmt::format(
            "tetrahedra: numbers {} and {} are in parts that are not joined by faces, but at most by an edge or "
            "a node; join them, or keep one part",
            apart->first, apart->second));
    warn_of_unit(mesh);

    const std::size_t count = mesh.tetrahedra.size();
    const auto young = to_numbers(young_modulus, "young_modulus", count);
    const auto poisson = to_numbers(poisson_ratio, "poisson_ratio", count);
    const auto rho = to_numbers(density, "density", count);
    std::map<std::array<double, 3>, int> region_of;
    for (std::size_t t = 0; t < count; ++t) {
        const auto [found, is_new] = region_of.try_emplace({rho[t], young[t], poisson[t]}, mesh.region_names.size());
        if (is_new) {
            body.materials.push_back({rho[t], young[t], poisson[t]});
            check(body.materials.back());
            mesh.region_names.push_back(fmt::format("material {}", mesh.region_names.size()));
        }
        mesh.region.push_back(found->second);
    }
    for (const auto &doubt : core::doubts_about_materials(body.materials, mesh.region_names))
        warn(doubt);
    return body;
}

} // namespace livermark::python
