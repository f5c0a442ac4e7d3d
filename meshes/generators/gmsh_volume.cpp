#include "meshes/generators/gmsh_volume.hpp"

#include <fmt/format.h>
#include <numeric>
#include <stdexcept>
#include <string>

#include "meshes/generators/gmsh_collector.hpp"
#include "meshes/generators/gmsh_session.hpp"

namespace livermark::meshes {

namespace {

constexpr int gmsh_triangle = 2;

/// @param num_nodes  nodes that gmsh has already; theirs are the tags 1 ... num_nodes
void add_surface(int tag, const SurfaceMesh &surface, std::size_t num_nodes) {
    std::vector<std::size_t> node_tags(surface.points.size());
    std::iota(node_tags.begin(), node_tags.end(), num_nodes + 1);
    std::vector<double> coordinates;
    for (const auto &point : surface.points)
        coordinates.insert(coordinates.end(), point.begin(), point.end());
    std::vector<std::size_t> corners;
    for (const auto &triangle : surface.triangles)
        for (const int node : triangle)
            corners.push_back(num_nodes + 1 + static_cast<std::size_t>(node));
    gmsh::model::addDiscreteEntity(2, tag);
    gmsh::model::mesh::addNodes(2, tag, node_tags, coordinates);
    gmsh::model::mesh::addElementsByType(tag, gmsh_triangle, {}, corners);
}

core::TetraMesh collect(int num_volumes) {
    core::TetraMesh mesh;
    GmshCollector collector(mesh);
    for (const int dimension : {2, 3})
        for (int entity = 1; entity <= num_volumes; ++entity)
            collector.add_nodes(dimension, entity);
    for (int entity = 1; entity <= num_volumes; ++entity) {
        collector.add_tetrahedra(entity);
        mesh.region.resize(mesh.tetrahedra.size(), entity - 1);
    }
    return mesh;
}

} // namespace

core::TetraMesh fill_with_tetrahedra(const SurfaceMesh &outer, const std::vector<SurfaceMesh> &inclusions,
                                     double largest_size) {
    const GmshSession session;
    try {
        gmsh::option::setNumber("Mesh.OptimizeThreshold", 0.4);
        std::size_t num_nodes = 0;
        std::vector<int> loops;
        const auto add = [&](const SurfaceMesh &surface) {
            const int tag = static_cast<int>(loops.size()) + 1;
            add_surface(tag, surface, num_nodes);
            num_nodes += surface.points.size();
            loops.push_back(gmsh::model::geo::addSurfaceLoop({tag}));
        };
        add(outer);
        for (const auto &inclusion : inclusions)
            add(inclusion);
        gmsh::model::geo::addVolume(loops, 1);
        for (std::size_t i = 1; i < loops.size(); ++i)
            gmsh::model::geo::addVolume({loops[i]}, static_cast<int>(i) + 1);
        gmsh::model::geo::synchronize();
        gmsh::option::setNumber("Mesh.CharacteristicLengthMax", largest_size);
        gmsh::model::mesh::generate(3);
        return collect(static_cast<int>(loops.size()));
    } catch (const std::string &error) { // what Debian's gmsh throws
        throw std::runtime_error(fmt::format("gmsh cannot fill the body with tetrahedra: {}", error));
    }
}

} // namespace livermark::meshes
