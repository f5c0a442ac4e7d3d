#include "meshes/generators/delaunay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <gmsh.h>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::meshes {

/// gmsh from start to end of a scope, silent and repeatable. After a meshing exception gmsh yields empty meshes until
/// it is finalised, so every mesh gets a session of its own. gmsh is global: one session at a time, in one thread.
struct GmshSession {
    GmshSession() {
        gmsh::initialize();
        gmsh::option::setNumber("General.Terminal", 0);
        gmsh::option::setNumber("General.NumThreads", 1); // more threads: another mesh at every run
        gmsh::option::setNumber("Mesh.Algorithm3D", 1);   // Delaunay, the one that is repeatable
        gmsh::model::add("body");
    }
    ~GmshSession() { gmsh::finalize(); }
    GmshSession(const GmshSession &) = delete;
    GmshSession &operator=(const GmshSession &) = delete;
};

/// Takes nodes and tetrahedra out of the model of a GmshSession, in gmsh's order.
class GmshCollector {
  public:
    /// @param mesh  gets them; kept alive by the caller
    explicit GmshCollector(core::TetraMesh &mesh) : mesh_(mesh) {}

    /// Adds the nodes of an entity, or of a dimension, or of all.
    void add_nodes(int dimension = -1, int entity = -1);

    /// Adds the tetrahedra of a volume, or of all, with positive volume. Their nodes are there already.
    void add_tetrahedra(int volume = -1);

  private:
    core::TetraMesh &mesh_;
    std::unordered_map<std::size_t, int> number_; ///< in the mesh, by gmsh's tag
};

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

double expected_tetrahedra(double side_of_cube, double edge_length) {
    constexpr double per_cube_of_edge = 6.0 * std::numbers::sqrt2;
    return per_cube_of_edge * std::pow(side_of_cube / edge_length, 3);
}

std::string text_of_expected_tetrahedra(double expected) {
    constexpr double most_in_full = 1e12;
    const double unit = std::pow(10.0, std::floor(std::log10(std::max(expected, 1.0))) - 1.0);
    return expected < most_in_full ? fmt::format("about {:.0f} tetrahedra", std::round(expected / unit) * unit)
                                   : fmt::format("about {:.2g} tetrahedra", expected);
}

void check_number_of_tetrahedra(const std::string &what, double side_of_cube, double edge_length) {
    const double expected = expected_tetrahedra(side_of_cube, edge_length);
    if (!(expected <= most_tetrahedra))
        throw support::InputError("the edges are too short: {} with edges of {:g} m would have {}, and {:.0f} are the "
                                  "most; make them longer, or check that lengths are in metres",
                                  what, edge_length, text_of_expected_tetrahedra(expected), most_tetrahedra);
}

namespace {

void check_size(const Solid &solid, double edge_length) {
    constexpr double longest = 1e6; // [m], of what OpenCASCADE calculates with
    check_number_of_tetrahedra(fmt::format("a {} of {}", solid.name, solid.size), solid.side_of_cube, edge_length);
    if (!(solid.longest_side <= longest))
        throw support::InputError("a side of {:g} m is too long to mesh; give lengths in metres", solid.longest_side);
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
