#include <algorithm>
#include <fmt/format.h>

#include "live/parameters.hpp"
#include "support/input_error.hpp"

namespace livermark::live {

namespace {

constexpr std::size_t most_nodes = 1'000'000;

/// Whether all entries of some lists are numbers of something.
bool are_below(const auto &lists, std::size_t count) {
    return std::ranges::all_of(lists, [count](const auto &list) {
        return std::ranges::all_of(list, [count](int i) { return i >= 0 && static_cast<std::size_t>(i) < count; });
    });
}

void check_mesh(const core::TetraMesh &mesh) {
    const auto fault = [](const std::string &what) {
        throw support::InputError(what + "; the file is damaged, make it again with `livermark run`");
    };
    if (mesh.points.empty() || mesh.points.size() > most_nodes || mesh.tetrahedra.empty())
        fault(fmt::format("a body of {} nodes and {} tetrahedra", mesh.points.size(), mesh.tetrahedra.size()));
    if (!std::ranges::all_of(mesh.points, [](const auto &x) { return x.allFinite(); }))
        fault("a node has a place that is no number");
    if (!are_below(mesh.tetrahedra, mesh.points.size()) || !are_below(mesh.boundary_triangles, mesh.points.size()))
        fault("a tetrahedron or triangle names a node that is not there");
    if (mesh.region.size() != mesh.tetrahedra.size() || !std::ranges::all_of(mesh.region, [&](int r) {
            return r >= 0 && static_cast<std::size_t>(r) < mesh.region_names.size();
        }))
        fault("a tetrahedron has a material that is not there");
    const auto volumes = core::tetrahedron_volumes(mesh);
    if (!std::ranges::all_of(volumes, [](double v) { return v > 0.0; }))
        fault("a tetrahedron has no volume, or is inverted");
    const auto nodal = core::nodal_volumes(mesh);
    if (!std::ranges::all_of(nodal, [](double v) { return v > 0.0; }))
        fault("a node belongs to no tetrahedron");
}

} // namespace

void check_body(const core::Body &body, const std::vector<bool> &is_constrained) {
    check_mesh(body.mesh);
    if (body.materials.size() != body.mesh.region_names.size() || body.materials.empty())
        throw support::InputError("a region has no material; give each one");
    for (const auto &material : body.materials)
        if (!(material.density > 0.0 && material.density < 1e6 && material.young_modulus > 0.0 &&
              material.young_modulus < 1e12))
            throw support::InputError(fmt::format("a material of {} kg/m^3 and {} Pa; both have to be above zero",
                                                  material.density, material.young_modulus));
    if (is_constrained.size() != body.mesh.boundary_triangles.size())
        throw support::InputError("the constraints are not given for every triangle of the boundary");
    if (std::ranges::none_of(is_constrained, [](bool constrained) { return constrained; }))
        throw support::InputError(
            "this load case does not constrain the body, so it would fly away; open one that does, such "
            "as palpation");
    if (std::ranges::all_of(is_constrained, [](bool constrained) { return constrained; }))
        throw support::InputError("all of the surface is constrained, so nothing can be touched; constrain less of it");
}

} // namespace livermark::live
