#include "meshes/generators/box_generator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <gmsh.h>
#include <numbers>
#include <string>

#include "core/support/input_error.hpp"
#include "meshes/generators/delaunay.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::meshes {

namespace {

using Cell = std::array<int, 3>;

/// Mean edge over the side of a cube, for a node inside: of seven edges (halves of its fourteen) four lead to middles
/// and three along sides; or three along sides, three across squares and one across the cube.
double mean_edge_of_unit_cube(Lattice lattice) {
    using std::numbers::sqrt2, std::numbers::sqrt3;
    return lattice == Lattice::body_centred ? (4.0 * sqrt3 / 2.0 + 3.0) / 7.0 : (3.0 + 3.0 * sqrt2 + sqrt3) / 7.0;
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

} // namespace

core::TetraMesh lattice_box(const core::Vector3 &size, double mean_edge, Lattice lattice) {
    const auto bricks = bricks_of(size, mean_edge / mean_edge_of_unit_cube(lattice));
    core::TetraMesh mesh;
    bricks.for_each(1, [&](const Cell &cell) { mesh.points.push_back(bricks.place(cell, 0.0)); });
    if (lattice == Lattice::kuhn)
        cut_after_kuhn(mesh, bricks);
    else
        cut_around_middles(mesh, bricks);
    return mesh;
}

namespace {

void check_length(double length, const std::string &what) {
    if (!(length > 0.0) || !std::isfinite(length))
        throw support::InputError("the {} of a box is {} m; give a positive length", what, length);
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
