#include "meshes/generators/delaunay.hpp"

#include <cmath>
#include <fmt/format.h>
#include <stdexcept>

#include "meshes/generators/gmsh_collector.hpp"
#include "meshes/generators/gmsh_session.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {

namespace {

/// Unlike that of lattices, the number of tetrahedra is not known before gmsh has made them: it works for days.
void check_number(const Solid &solid, double edge_length) {
    constexpr double most_tetrahedra = 2e7, longest = 1e6; // [m], of what OpenCASCADE calculates with
    const double volume_of_each = std::pow(edge_length, 3) / (6.0 * std::sqrt(2.0));
    if (!(std::pow(solid.side_of_cube / std::cbrt(volume_of_each), 3) <= most_tetrahedra))
        throw support::InputError(
            fmt::format("the edges are too short: a {} of {} would have more than {:g} tetrahedra; make them longer",
                        solid.name, solid.size, most_tetrahedra));
    if (!(solid.longest_side <= longest))
        throw support::InputError(
            fmt::format("a side of {:g} m is too long to mesh; give lengths in metres", solid.longest_side));
}

} // namespace

core::TetraMesh delaunay_mesh(const Solid &solid, double edge_length) {
    check_number(solid, edge_length);
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
