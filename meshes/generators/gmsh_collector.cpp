#include "meshes/generators/gmsh_collector.hpp"

#include <array>
#include <vector>

#include "meshes/generators/gmsh_session.hpp"
#include "meshes/io/orientation.hpp"

namespace livermark::meshes {

void GmshCollector::add_nodes(int dimension, int entity) {
    std::vector<std::size_t> tags;
    std::vector<double> coordinates;
    std::vector<double> parameters;
    gmsh::model::mesh::getNodes(tags, coordinates, parameters, dimension, entity);
    for (std::size_t i = 0; i < tags.size(); ++i) {
        number_.emplace(tags[i], mesh_.num_nodes());
        mesh_.points.emplace_back(coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]);
    }
}

void GmshCollector::add_tetrahedra(int volume) {
    constexpr int gmsh_tetrahedron = 4;
    std::vector<std::size_t> tags;
    std::vector<std::size_t> corners;
    gmsh::model::mesh::getElementsByType(gmsh_tetrahedron, tags, corners, volume);
    for (std::size_t i = 0; i + 3 < corners.size(); i += 4) {
        std::array<int, 4> nodes;
        for (std::size_t c = 0; c < 4; ++c)
            nodes[c] = number_.at(corners[i + c]);
        mesh_.tetrahedra.push_back(with_positive_volume(nodes, mesh_.points));
    }
}

} // namespace livermark::meshes
