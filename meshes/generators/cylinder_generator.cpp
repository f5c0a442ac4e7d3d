#include "meshes/generators/cylinder_generator.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gmsh.h>
#include <numbers>

#include "core/support/input_error.hpp"
#include "meshes/generators/delaunay.hpp"

namespace livermark::meshes {

namespace {

enum CylinderPatch { side = 0, bottom = 1, top = 2 };

core::TetraMesh filled_cylinder(double radius, double height, double edge_length) {
    return delaunay_mesh({.name = "cylinder",
                          .size = fmt::format("{:g} m radius and {:g} m height", radius, height),
                          .side_of_cube = side_of_cube_like_cylinder(radius, height, edge_length),
                          .longest_side = std::max(2.0 * radius, height),
                          .add = [&] { gmsh::model::occ::addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, height, radius); }},
                         edge_length);
}

} // namespace

double side_of_cube_like_cylinder(double radius, double height, double edge_length) {
    return std::cbrt(std::numbers::pi) * std::pow(std::cbrt(radius), 2) * std::cbrt(std::max(height, edge_length));
}

core::TetraMesh generate_cylinder(double radius, double height, double edge_length) {
    for (const auto &[length, what] : {std::pair{radius, "radius"}, {height, "height"}, {edge_length, "edge length"}})
        if (!(length > 0.0) || !std::isfinite(length))
            throw support::InputError("the {} of a cylinder is {} m; give a positive length", what, length);
    if (edge_length > radius)
        throw support::InputError("the edges of a cylinder are {} m long and its radius is {} m; make them shorter",
                                  edge_length, radius);
    auto mesh = filled_cylinder(radius, height, edge_length);
    mesh.region.assign(mesh.tetrahedra.size(), 0);
    mesh.region_names = {"solid"};
    mesh.patch_names = {"side", "z_min", "z_max"};
    mesh.boundary_triangles = core::outer_faces(mesh.tetrahedra);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const core::Vector3 normal = core::area_vector(mesh, f).normalized();
        constexpr double upright = 0.99; // triangles of the side are vertical
        mesh.boundary_patch.push_back(normal.z() > upright ? top : normal.z() < -upright ? bottom : side);
    }
    return mesh;
}

} // namespace livermark::meshes
