#include "meshes/generators/box_generator.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gmsh.h>
#include <string>

#include "meshes/generators/delaunay.hpp"
#include "meshes/generators/expected_tetrahedra.hpp"
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

std::string text_of_size(const core::Vector3 &size) {
    return fmt::format("{:g} x {:g} x {:g} m", size.x(), size.y(), size.z());
}

core::TetraMesh delaunay_box(const core::Vector3 &size, double edge_length) {
    return delaunay_mesh({.name = "box",
                          .size = text_of_size(size),
                          .side_of_cube = side_of_cube_like_box(size, edge_length),
                          .longest_side = size.maxCoeff(),
                          .add = [&] { gmsh::model::occ::addBox(0.0, 0.0, 0.0, size.x(), size.y(), size.z()); }},
                         edge_length);
}

} // namespace

double side_of_cube_like_box(const core::Vector3 &size, double edge_length) {
    return size.unaryExpr([=](double side) { return std::cbrt(std::max(side, edge_length)); }).prod();
}

core::TetraMesh generate_box(const core::Vector3 &size, double edge_length, BoxTopology topology) {
    for (int i = 0; i < 3; ++i)
        check_length(size[i], fmt::format("size in {}", "xyz"[i]));
    check_length(edge_length, "edge length");
    if (topology != BoxTopology::delaunay)
        check_number_of_tetrahedra("a box of " + text_of_size(size), side_of_cube_like_box(size, edge_length),
                                   edge_length);
    auto mesh = topology == BoxTopology::delaunay       ? delaunay_box(size, edge_length)
                : topology == BoxTopology::body_centred ? lattice_box(size, edge_length, Lattice::body_centred)
                                                        : lattice_box(size, edge_length, Lattice::kuhn);
    mesh.region.assign(mesh.tetrahedra.size(), 0);
    mesh.region_names = {"solid"};
    name_sides(mesh);
    return mesh;
}

} // namespace livermark::meshes
