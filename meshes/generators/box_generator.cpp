#include "meshes/generators/box_generator.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <string>

#include "meshes/generators/gmsh_collector.hpp"
#include "meshes/generators/gmsh_session.hpp"
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

/// Unlike that of lattices, the number of tetrahedra is not known before gmsh has made them: it works for days.
void check_number(const core::Vector3 &size, double edge_length) {
    constexpr double most_tetrahedra = 2e7, longest = 1e6; // [m], of what OpenCASCADE calculates with
    const double volume_of_each = std::pow(edge_length, 3) / (6.0 * std::sqrt(2.0));
    const double number = (size / std::cbrt(volume_of_each)).prod();
    if (!(number <= most_tetrahedra))
        throw support::InputError(
            fmt::format("the edges are too short: a box of {:g} x {:g} x {:g} m would have more than {:g} tetrahedra; "
                        "make them longer",
                        size.x(), size.y(), size.z(), most_tetrahedra));
    if (!(size.maxCoeff() <= longest))
        throw support::InputError(
            fmt::format("a side of {:g} m is too long to mesh; give lengths in metres", size.maxCoeff()));
}

core::TetraMesh delaunay_box(const core::Vector3 &size, double edge_length) {
    check_number(size, edge_length);
    core::TetraMesh mesh;
    try {
        const GmshSession session;
        gmsh::model::occ::addBox(0.0, 0.0, 0.0, size.x(), size.y(), size.z());
        gmsh::model::occ::synchronize();
        gmsh::option::setNumber("Mesh.CharacteristicLengthMin", edge_length);
        gmsh::option::setNumber("Mesh.CharacteristicLengthMax", edge_length);
        gmsh::model::mesh::generate(3);
        GmshCollector collector(mesh);
        collector.add_nodes();
        collector.add_tetrahedra();
    } catch (const std::string &error) { // what Debian's gmsh throws
        throw std::runtime_error(fmt::format("gmsh cannot mesh the box: {}", error));
    }
    return mesh;
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
