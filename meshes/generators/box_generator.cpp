#include "meshes/generators/box_generator.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gmsh.h>
#include <string>

#include "meshes/generators/delaunay.hpp"
#include "meshes/generators/lattice_box.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

void check_length(double length, const std::string &what) {
    if (!(length > 0.0) || !std::isfinite(length))
        throw support::InputError(fmt::format("the {} of a box is {} m; give a positive length", what, length));
}

void name_sides(core::TetraMesh &mesh) {
    mesh.patch_names = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};
    mesh.boundary_triangles = core::outer_faces(mesh.tetrahedra);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const core::Vector3 area = core::area_vector(mesh, f);
        int axis = 0;
        area.cwiseAbs().maxCoeff(&axis);
        mesh.boundary_patch.push_back(2 * axis + (area[axis] > 0.0 ? 1 : 0));
    }
}

core::TetraMesh delaunay_box(const core::Vector3 &size, double edge_length) {
    return delaunay_mesh({.name = "box",
                          .size = fmt::format("{:g} x {:g} x {:g} m", size.x(), size.y(), size.z()),
                          .side_of_cube = size.unaryExpr([](double side) { return std::cbrt(side); }).prod(),
                          .longest_side = size.maxCoeff(),
                          .add = [&] { gmsh::model::occ::addBox(0.0, 0.0, 0.0, size.x(), size.y(), size.z()); }},
                         edge_length);
}

} // namespace

core::TetraMesh generate_box(const core::Vector3 &size, double edge_length, BoxTopology topology) {
    for (int i = 0; i < 3; ++i)
        check_length(size[i], fmt::format("size in {}", "xyz"[i]));
    check_length(edge_length, "edge length");
    auto mesh = topology == BoxTopology::delaunay       ? delaunay_box(size, edge_length)
                : topology == BoxTopology::body_centred ? lattice_box(size, edge_length, Lattice::body_centred)
                                                        : lattice_box(size, edge_length, Lattice::kuhn);
    mesh.region.assign(mesh.tetrahedra.size(), 0);
    mesh.region_names = {"solid"};
    name_sides(mesh);
    return mesh;
}

} // namespace livermark::meshes
