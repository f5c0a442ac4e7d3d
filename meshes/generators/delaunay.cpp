#include "meshes/generators/delaunay.hpp"

#include <fmt/format.h>
#include <stdexcept>

#include "meshes/generators/expected_tetrahedra.hpp"
#include "meshes/generators/gmsh_collector.hpp"
#include "meshes/generators/gmsh_session.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

void check_size(const Solid &solid, double edge_length) {
    constexpr double longest = 1e6; // [m], of what OpenCASCADE calculates with
    check_number_of_tetrahedra(fmt::format("a {} of {}", solid.name, solid.size), solid.side_of_cube, edge_length);
    if (!(solid.longest_side <= longest))
        throw support::InputError(
            fmt::format("a side of {:g} m is too long to mesh; give lengths in metres", solid.longest_side));
}

} // namespace

core::TetraMesh delaunay_mesh(const Solid &solid, double edge_length) {
    check_size(solid, edge_length);
    core::TetraMesh mesh;
    try {
        const GmshSession session;
        solid.add();
        gmsh::model::occ::synchronize();
        gmsh::option::setNumber("Mesh.CharacteristicLengthMin", edge_length);
        gmsh::option::setNumber("Mesh.CharacteristicLengthMax", edge_length);
        gmsh::model::mesh::generate(3);
        GmshCollector collector(mesh);
        collector.add_nodes();
        collector.add_tetrahedra();
    } catch (const std::string &error) { // what Debian's gmsh throws
        throw std::runtime_error(fmt::format("gmsh cannot mesh the {}: {}", solid.name, error));
    }
    return mesh;
}

} // namespace livermark::meshes
