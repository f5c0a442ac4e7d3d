#include "meshes/anatomy/liver_patches.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "meshes/generators/liver/liver_shape.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;

enum Patch { posterior, anterior, inferior, superior, right_lobe_dome, right_lateral, left_lobe_tip, num_patches };

/// @param p  centroid of a facet [m]
/// @param n  its unit outward normal
/// @param drawn  the liver at the scale and the place of the one that ships
/// @param tip  where its tip begins [m]
Patch patch_at(const Vector3 &p, const Vector3 &n, const LiverShape &drawn, double tip) {
    if (p.x() > tip)
        return left_lobe_tip;
    if (n.y() > 0.45 && n.z() > -0.35 && p.x() > -0.068 && p.x() < 0.062 && p.z() > -0.035)
        return posterior;
    if (n.z() > 0.5)
        return p.x() < 0.02 ? right_lobe_dome : superior;
    if (diaphragmatic_depth(p, drawn) > 0.005)
        return inferior;
    if (n.x() < -0.65)
        return right_lateral;
    if (n.y() < 0.0)
        return anterior;
    return p.x() < 0.0 ? right_lateral : superior; // their backs
}

class Painter {
  public:
    Painter(core::TetraMesh &mesh, const LiverFit &fit, const LiverShape &drawn, double tip)
        : mesh_(mesh), areas_(mesh.boundary_triangles.size()), around_node_(mesh.points.size()) {
        for (int t = 0; t < mesh.num_boundary_triangles(); ++t) {
            const auto &[a, b, c] = mesh.boundary_triangles[t];
            const Vector3 area = core::area_vector(mesh, t);
            areas_[t] = area.norm();
            mesh.boundary_patch.push_back(patch_at(fit.place((mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0),
                                                   fit.normal(area), drawn, tip));
            for (const int node : {a, b, c})
                around_node_[node].push_back(t);
        }
    }

    /// Gives each facet the patch that has the largest area among the facets that share a node with it.
    void smooth() {
        auto smoothed = mesh_.boundary_patch;
        for (int t = 0; t < mesh_.num_boundary_triangles(); ++t) {
            const auto areas = areas_around(t);
            const auto largest = std::ranges::max_element(areas) - areas.begin();
            if (areas[largest] > areas[mesh_.boundary_patch[t]])
                smoothed[t] = static_cast<int>(largest);
        }
        mesh_.boundary_patch = std::move(smoothed);
    }

    /// Gives every piece of a patch but its largest to the patches around it, from the rim inwards.
    void absorb_islands() {
        for (auto islands = island_facets(); !islands.empty(); islands = island_facets())
            for (const int t : islands) {
                auto areas = areas_around(t);
                areas[mesh_.boundary_patch[t]] = 0.0;
                const auto largest = std::ranges::max_element(areas);
                if (*largest > 0.0)
                    mesh_.boundary_patch[t] = static_cast<int>(largest - areas.begin());
            }
    }

  private:
    std::array<double, num_patches> areas_around(int t) const {
        std::array<double, num_patches> areas{};
        for (const int node : mesh_.boundary_triangles[t])
            for (const int other : around_node_[node])
                areas[mesh_.boundary_patch[other]] += areas_[other];
        return areas;
    }

    /// Facets of the same patch as t that share an edge with it.
    std::vector<int> next_to(int t) const {
        std::vector<int> found;
        const auto &nodes = mesh_.boundary_triangles[t];
        for (const int node : nodes)
            for (const int other : around_node_[node]) {
                const auto num_shared = std::ranges::count_if(
                    mesh_.boundary_triangles[other], [&](int n) { return std::ranges::find(nodes, n) != nodes.end(); });
                if (num_shared == 2 && mesh_.boundary_patch[other] == mesh_.boundary_patch[t])
                    found.push_back(other);
            }
        return found;
    }

    std::vector<int> island_facets() const {
        std::vector<std::vector<int>> pieces;
        std::vector<bool> is_seen(areas_.size(), false);
        std::array<double, num_patches> largest{};
        std::array<int, num_patches> largest_piece{};
        for (int start = 0; start < mesh_.num_boundary_triangles(); ++start) {
            if (is_seen[start])
                continue;
            auto &piece = pieces.emplace_back(std::vector{start});
            is_seen[start] = true;
            double area = 0.0;
            for (std::size_t i = 0; i < piece.size(); ++i) {
                area += areas_[piece[i]];
                for (const int other : next_to(piece[i]))
                    if (!is_seen[other]) {
                        is_seen[other] = true;
                        piece.push_back(other);
                    }
            }
            const int patch = mesh_.boundary_patch[start];
            if (area > largest[patch]) {
                largest[patch] = area;
                largest_piece[patch] = static_cast<int>(pieces.size()) - 1;
            }
        }
        std::vector<int> islands;
        for (int p = 0; p < static_cast<int>(pieces.size()); ++p)
            if (largest_piece[mesh_.boundary_patch[pieces[p].front()]] != p)
                islands.insert(islands.end(), pieces[p].begin(), pieces[p].end());
        return islands;
    }

    core::TetraMesh &mesh_;
    std::vector<double> areas_;
    std::vector<std::vector<int>> around_node_;
};

void paint(core::TetraMesh &mesh, const LiverFit &fit, const LiverShape &drawn, double tip) {
    mesh.patch_names = liver_patch_names();
    mesh.boundary_patch.clear();
    Painter painter(mesh, fit, drawn, tip);
    constexpr int num_rounds = 6;
    for (int round = 0; round < num_rounds; ++round)
        painter.smooth();
    painter.absorb_islands();
}

constexpr double tip_of_shipped_liver = 0.105; // [m]

/// A left lobe may end sooner than that of the fitted shape. Its tip then begins sooner as well, and has half the
/// length of that of the shape, so that every liver has one.
double tip_begin(const core::TetraMesh &mesh, const LiverFit &fit) {
    constexpr double least_part = 0.5;
    double end = -std::numeric_limits<double>::infinity();
    for (const auto &triangle : mesh.boundary_triangles)
        for (const int node : triangle)
            end = std::max(end, fit.place(mesh.points[node]).x());
    const double begin = left_lobe_tip_begin(fit.shape);
    return std::min(begin, end - least_part * (left_lobe_end(fit.shape) - begin));
}

} // namespace

std::vector<std::string> liver_patch_names() {
    return {"posterior", "anterior", "inferior", "superior", "right_lobe_dome", "right_lateral", "left_lobe_tip"};
}

void assign_liver_patches(core::TetraMesh &mesh) {
    mesh.boundary_triangles = core::outer_faces(mesh.tetrahedra);
    paint(mesh, {}, {}, tip_of_shipped_liver);
}

void assign_liver_patches(core::TetraMesh &mesh, const LiverFit &fit) {
    paint(mesh, fit, fit.shape, tip_begin(mesh, fit));
}

void assign_liver_patches(core::TetraMesh &mesh, const LiverShape &shape) {
    mesh.boundary_triangles = core::outer_faces(mesh.tetrahedra);
    // Through the drawing to the scale and the place of the liver that ships.
    LiverShape drawn = shape;
    drawn.metres_per_unit = LiverShape().metres_per_unit;
    drawn.centroid = LiverShape().centroid;
    LiverFit fit;
    const Vector3 stretch = drawn.metres_per_unit.cwiseQuotient(shape.metres_per_unit);
    fit.linear = stretch.asDiagonal();
    fit.offset = (shape.centroid - drawn.centroid).cwiseProduct(drawn.metres_per_unit);
    paint(mesh, fit, drawn, left_lobe_tip_begin(drawn));
}

} // namespace livermark::meshes
