#include "meshes/generators/cylinder_generator.hpp"

#include <cmath>
#include <fmt/format.h>
#include <stdexcept>
#include <string>

#include "meshes/generators/gmsh_collector.hpp"
#include "meshes/generators/gmsh_session.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

enum CylinderPatch { side = 0, bottom = 1, top = 2 };

core::TetraMesh filled_cylinder(double radius, double height, double edge_length) {
    core::TetraMesh mesh;
    try {
        const GmshSession session;
        gmsh::model::occ::addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, height, radius);
        gmsh::model::occ::synchronize();
        gmsh::option::setNumber("Mesh.CharacteristicLengthMin", edge_length);
        gmsh::option::setNumber("Mesh.CharacteristicLengthMax", edge_length);
        gmsh::model::mesh::generate(3);
        GmshCollector collector(mesh);
        collector.add_nodes();
        collector.add_tetrahedra();
    } catch (const std::string &error) { // what Debian's gmsh throws
        throw std::runtime_error(fmt::format("gmsh cannot mesh the cylinder: {}", error));
    }
    return mesh;
}

} // namespace

core::TetraMesh generate_cylinder(double radius, double height, double edge_length) {
    for (const auto &[length, what] : {std::pair{radius, "radius"}, {height, "height"}, {edge_length, "edge length"}})
        if (!(length > 0.0) || !std::isfinite(length))
            throw support::InputError(
                fmt::format("the {} of a cylinder is {} m; give a positive length", what, length));
    if (edge_length > radius)
        throw support::InputError(fmt::format("the edges of a cylinder are {} m long and its radius is {} m; make them "
                                              "shorter",
                                              edge_length, radius));
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
