#include "meshes/generators/box_generator.hpp"

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

namespace {

/// The corners of a tetrahedron, the last two exchanged where its volume would be negative.
/// @param nodes   node numbers, indices into points
/// @param points  (N) [m]
std::array<int, 4> with_positive_volume(std::array<int, 4> nodes, std::span<const core::Vector3> points) {
    if (core::signed_volume(points[nodes[0]], points[nodes[1]], points[nodes[2]], points[nodes[3]]) < 0.0)
        std::swap(nodes[2], nodes[3]);
    return nodes;
}

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
    /// Adds the nodes of an entity, or of a dimension, or of all.
    void add_nodes(int dimension = -1, int entity = -1) {
        std::vector<std::size_t> tags;
        std::vector<double> coordinates, parameters;
        gmsh::model::mesh::getNodes(tags, coordinates, parameters, dimension, entity);
        for (std::size_t i = 0; i < tags.size(); ++i) {
            number_.emplace(tags[i], mesh.num_nodes());
            mesh.points.emplace_back(coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]);
        }
    }

    /// Adds the tetrahedra of a volume, or of all, with positive volume. Their nodes are there already.
    void add_tetrahedra(int volume = -1) {
        constexpr int gmsh_tetrahedron = 4;
        std::vector<std::size_t> tags, corners;
        gmsh::model::mesh::getElementsByType(gmsh_tetrahedron, tags, corners, volume);
        for (std::size_t i = 0; i + 3 < corners.size(); i += 4) {
            std::array<int, 4> nodes;
            for (std::size_t c = 0; c < 4; ++c)
                nodes[c] = number_.at(corners[i + c]);
            mesh.tetrahedra.push_back(with_positive_volume(nodes, mesh.points));
        }
    }

    core::TetraMesh mesh;

  private:
    std::unordered_map<std::size_t, int> number_; ///< in the mesh, by gmsh's tag
};

} // namespace

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

namespace {

/// Refuses a mesh before it is made, which may take hours and all of the memory.
/// @param what  "a box of 0.1 x 0.2 x 0.1 m"
void check_number_of_tetrahedra(const std::string &what, double side_of_cube, double edge_length) {
    const double expected = expected_tetrahedra(side_of_cube, edge_length);
    if (!(expected <= most_tetrahedra))
        throw support::InputError("the edges are too short: {} with edges of {:g} m would have {}, and {:.0f} are the "
                                  "most; make them longer, or check that lengths are in metres",
                                  what, edge_length, text_of_expected_tetrahedra(expected), most_tetrahedra);
}

/// Nodes and tetrahedra of a solid, unstructured, and no boundary yet.
/// @param name          "box", for messages
/// @param size          "0.1 x 0.2 x 0.1 m", the same
/// @param side_of_cube  of the same volume [m]
/// @param longest_side  [m]
/// @param add           adds it to gmsh's model, by OpenCASCADE
template <class Add>
core::TetraMesh delaunay_mesh(const std::string &name, const std::string &size, double side_of_cube,
                              double longest_side, double edge_length, const Add &add) {
    constexpr double longest = 1e6; // [m], of what OpenCASCADE calculates with
    check_number_of_tetrahedra(fmt::format("a {} of {}", name, size), side_of_cube, edge_length);
    if (!(longest_side <= longest))
        throw support::InputError("a side of {:g} m is too long to mesh; give lengths in metres", longest_side);
    try {
        const GmshSession session;
        add();
        gmsh::model::occ::synchronize();
        gmsh::option::setNumber("Mesh.CharacteristicLengthMin", edge_length);
        gmsh::option::setNumber("Mesh.CharacteristicLengthMax", edge_length);
        gmsh::model::mesh::generate(3);
        GmshCollector collector;
        collector.add_nodes();
        collector.add_tetrahedra();
        return std::move(collector.mesh);
    } catch (const std::string &error) { // what Debian's gmsh throws
        throw std::runtime_error(fmt::format("gmsh cannot mesh the {}: {}", name, error));
    }
}

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
    GmshCollector collector;
    for (const int dimension : {2, 3})
        for (int entity = 1; entity <= num_volumes; ++entity)
            collector.add_nodes(dimension, entity);
    for (int entity = 1; entity <= num_volumes; ++entity) {
        collector.add_tetrahedra(entity);
        collector.mesh.region.resize(collector.mesh.tetrahedra.size(), entity - 1);
    }
    return std::move(collector.mesh);
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

namespace {

using Cell = std::array<int, 3>;

/// Mean edge over the side of a cube, for a node inside: of seven edges (halves of its fourteen) four lead to middles
/// and three along sides; or three along sides, three across squares and one across the cube.
double mean_edge_of_unit_cube(BoxTopology lattice) {
    using std::numbers::sqrt2, std::numbers::sqrt3;
    return lattice == BoxTopology::body_centred ? (4.0 * sqrt3 / 2.0 + 3.0) / 7.0 : (3.0 + 3.0 * sqrt2 + sqrt3) / 7.0;
}

/// A box of bricks and the numbers of its nodes: corners first, then middles.
struct Bricks {
    Cell count{};
    core::Vector3 side;

    int corner(const Cell &at) const { return at[0] + (count[0] + 1) * (at[1] + (count[1] + 1) * at[2]); }
    int num_corners() const { return (count[0] + 1) * (count[1] + 1) * (count[2] + 1); }
    int middle(const Cell &at) const { return num_corners() + at[0] + count[0] * (at[1] + count[1] * at[2]); }

    template <class Action> void for_each(int extra, Action action) const {
        for (int z = 0; z < count[2] + extra; ++z)
            for (int y = 0; y < count[1] + extra; ++y)
                for (int x = 0; x < count[0] + extra; ++x)
                    action(Cell{x, y, z});
    }
    core::Vector3 place(const Cell &at, double offset) const {
        return side.cwiseProduct(core::Vector3(at[0] + offset, at[1] + offset, at[2] + offset));
    }
};

Bricks bricks_of(const core::Vector3 &size, double side) {
    Bricks bricks;
    for (int i = 0; i < 3; ++i) {
        const double wanted = std::max(1.0, std::round(size[i] / side));
        bricks.count[i] = static_cast<int>(wanted);
        bricks.side[i] = size[i] / wanted;
    }
    return bricks;
}

void add(core::TetraMesh &mesh, const std::array<int, 4> &nodes) {
    mesh.tetrahedra.push_back(with_positive_volume(nodes, mesh.points));
}

void cut_after_kuhn(core::TetraMesh &mesh, const Bricks &bricks) {
    bricks.for_each(0, [&](const Cell &cell) {
        Cell order{0, 1, 2};
        do { // along the sides in this order leads from the first corner to the last
            std::array<int, 4> nodes{bricks.corner(cell)};
            Cell corner = cell;
            for (int i = 0; i < 3; ++i) {
                ++corner[order[i]];
                nodes[i + 1] = bricks.corner(corner);
            }
            add(mesh, nodes);
        } while (std::ranges::next_permutation(order).found);
    });
}

/// The corners of the square of a cell on its lower side along an axis, in a ring.
std::array<int, 4> square(const Bricks &bricks, const Cell &cell, int axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<int, 4> ring{};
    for (int k = 0; k < 4; ++k) {
        Cell corner = cell;
        corner[u] += k == 1 || k == 2 ? 1 : 0;
        corner[v] += k >= 2 ? 1 : 0;
        ring[k] = bricks.corner(corner);
    }
    return ring;
}

void cut_around_middles(core::TetraMesh &mesh, const Bricks &bricks) {
    bricks.for_each(0, [&](const Cell &cell) { mesh.points.push_back(bricks.place(cell, 0.5)); });
    const auto cut_side = [&](const std::array<int, 4> &ring, int middle, bool other_diagonal) {
        const int first = other_diagonal ? 1 : 0;
        for (const int k : {first, first + 2})
            add(mesh, {ring[k], ring[(k + 1) % 4], ring[(k + 2) % 4], middle});
    };
    bricks.for_each(1, [&](const Cell &cell) {
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            if (cell[u] == bricks.count[u] || cell[v] == bricks.count[v])
                continue;
            const auto ring = square(bricks, cell, axis);
            Cell before = cell;
            --before[axis];
            // Diagonals of neighbouring squares meet at the same corners, which favours no direction.
            const bool is_odd = (cell[0] + cell[1] + cell[2]) % 2 != 0;
            if (cell[axis] == 0)
                cut_side(ring, bricks.middle(cell), is_odd);
            else if (cell[axis] == bricks.count[axis])
                cut_side(ring, bricks.middle(before), is_odd);
            else
                for (int k = 0; k < 4; ++k)
                    add(mesh, {ring[k], ring[(k + 1) % 4], bricks.middle(before), bricks.middle(cell)});
        }
    });
}

/// Points and tetrahedra of a box, and nothing else; the bricks are as close to cubes as a whole number of them can be.
/// @param mean_edge  wanted mean length of the edges inside [m]
core::TetraMesh lattice_box(const core::Vector3 &size, double mean_edge, BoxTopology lattice) {
    const auto bricks = bricks_of(size, mean_edge / mean_edge_of_unit_cube(lattice));
    core::TetraMesh mesh;
    bricks.for_each(1, [&](const Cell &cell) { mesh.points.push_back(bricks.place(cell, 0.0)); });
    if (lattice == BoxTopology::kuhn)
        cut_after_kuhn(mesh, bricks);
    else
        cut_around_middles(mesh, bricks);
    return mesh;
}

void check_length(const char *solid, double length, const std::string &what) {
    if (!(length > 0.0) || !std::isfinite(length))
        throw support::InputError("the {} of a {} is {} m; give a positive length", what, solid, length);
}

std::string text_of_size(const core::Vector3 &size) {
    return fmt::format("{:g} x {:g} x {:g} m", size.x(), size.y(), size.z());
}

/// Makes all of it the region "solid", and its boundary patches.
/// @param patch_of  (normal of a facet) -> its patch
template <class PatchOf>
core::TetraMesh with_sides(core::TetraMesh mesh, std::vector<std::string> names, const PatchOf &patch_of) {
    mesh.region.assign(mesh.tetrahedra.size(), 0);
    mesh.region_names = {"solid"};
    mesh.patch_names = std::move(names);
    mesh.boundary_triangles = core::outer_faces(mesh.tetrahedra);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        mesh.boundary_patch.push_back(patch_of(core::Vector3(core::area_vector(mesh, f).normalized())));
    return mesh;
}

} // namespace

double side_of_cube_like_box(const core::Vector3 &size, double edge_length) {
    return size.unaryExpr([=](double side) { return std::cbrt(std::max(side, edge_length)); }).prod();
}

core::TetraMesh generate_box(const core::Vector3 &size, double edge_length, BoxTopology topology) {
    for (int i = 0; i < 3; ++i)
        check_length("box", size[i], fmt::format("size in {}", "xyz"[i]));
    check_length("box", edge_length, "edge length");
    const double side_of_cube = side_of_cube_like_box(size, edge_length);
    core::TetraMesh mesh;
    if (topology == BoxTopology::delaunay) {
        mesh = delaunay_mesh("box", text_of_size(size), side_of_cube, size.maxCoeff(), edge_length,
                             [&] { gmsh::model::occ::addBox(0.0, 0.0, 0.0, size.x(), size.y(), size.z()); });
    } else {
        check_number_of_tetrahedra("a box of " + text_of_size(size), side_of_cube, edge_length);
        mesh = lattice_box(size, edge_length, topology);
    }
    return with_sides(std::move(mesh), {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"},
                      [](const core::Vector3 &normal) {
                          int axis = 0;
                          normal.cwiseAbs().maxCoeff(&axis);
                          return 2 * axis + (normal[axis] > 0.0 ? 1 : 0);
                      });
}

namespace {

/// Moves the nodes of a mesh with curved sides away from an axis or a centre until it has the volume of the solid: its
/// facets are flat, and with their corners on the surface it would be too thin.
/// @param volume  of the solid [m^3]
/// @param moves   1 of the directions in which nodes move, 0 of others
void swell(core::TetraMesh &mesh, double volume, const core::Vector3 &moves) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    const double filled = std::accumulate(volumes.begin(), volumes.end(), 0.0);
    const double factor = std::pow(volume / filled, 1.0 / moves.sum());
    for (auto &point : mesh.points)
        point = point.cwiseProduct(core::Vector3::Ones() + (factor - 1.0) * moves);
}

void check_edges(const char *solid, double radius, double edge_length) {
    if (edge_length > radius)
        throw support::InputError("the edges of a {} are {} m long and its radius is {} m; make them shorter", solid,
                                  edge_length, radius);
}

} // namespace

double side_of_cube_like_cylinder(double radius, double height, double edge_length, CylinderPart part) {
    return std::cbrt(std::numbers::pi / number_of(part)) * std::pow(std::cbrt(radius), 2) *
           std::cbrt(std::max(height, edge_length));
}

core::TetraMesh generate_cylinder(double radius, double height, double edge_length, CylinderPart part) {
    check_length("cylinder", radius, "radius");
    check_length("cylinder", height, "height");
    check_length("cylinder", edge_length, "edge length");
    check_edges("cylinder", radius, edge_length);
    auto mesh = delaunay_mesh("cylinder", fmt::format("{:g} m radius and {:g} m height", radius, height),
                              side_of_cube_like_cylinder(radius, height, edge_length, part),
                              std::max(2.0 * radius, height), edge_length, [&] {
                                  gmsh::model::occ::addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, height, radius, -1,
                                                                2.0 * std::numbers::pi / number_of(part));
                              });
    swell(mesh, std::numbers::pi * radius * radius * height / number_of(part), {1.0, 1.0, 0.0});
    std::vector<std::string> patches{"side", "z_min", "z_max"};
    if (part == CylinderPart::quarter)
        patches.insert(patches.end(), {"x_min", "y_min"});
    return with_sides(std::move(mesh), std::move(patches), [part](const core::Vector3 &normal) {
        constexpr double along = 0.99; // triangles of the side are vertical, and their normals point away from the axis
        if (std::abs(normal.z()) > along)
            return normal.z() > 0.0 ? 2 : 1;
        if (part == CylinderPart::quarter && normal.x() < -along)
            return 3;
        return part == CylinderPart::quarter && normal.y() < -along ? 4 : 0;
    });
}

double side_of_cube_like_sphere(double radius) {
    return std::cbrt(4.0 / 3.0 * std::numbers::pi) * radius;
}

core::TetraMesh generate_sphere(double radius, double edge_length) {
    check_length("sphere", radius, "radius");
    check_length("sphere", edge_length, "edge length");
    check_edges("sphere", radius, edge_length);
    auto mesh = delaunay_mesh("sphere", fmt::format("{:g} m radius", radius), side_of_cube_like_sphere(radius),
                              2.0 * radius, edge_length, [&] { gmsh::model::occ::addSphere(0.0, 0.0, 0.0, radius); });
    swell(mesh, 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3), core::Vector3::Ones());
    return with_sides(std::move(mesh), {"surface"}, [](const core::Vector3 & /*normal*/) { return 0; });
}

} // namespace livermark::meshes
