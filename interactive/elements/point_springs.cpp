#include "interactive/elements/point_springs.hpp"

#include <algorithm>
#include <array>

#include "core/mesh/places.hpp"
#include "core/part_springs.hpp"

namespace livermark::interactive {

namespace {

using Edge = std::array<int, 2>;

Edge edge_between(int a, int b) {
    return {std::min(a, b), std::max(a, b)};
}

/// Nodes of a method in the middle of edges, as quadratic_scene() makes them.
class MiddleNodes {
  public:
    explicit MiddleNodes(const core::TetraMesh &mesh)
        : table_(core::edge_table(mesh.tetrahedra)), num_corners_(mesh.num_nodes()) {}

    int between(int a, int b) const {
        return num_corners_ +
               static_cast<int>(std::ranges::lower_bound(table_.edges, edge_between(a, b)) - table_.edges.begin());
    }

  private:
    core::EdgeTable table_;
    int num_corners_;
};

/// The covered surface of a scene as a body without tetrahedra.
core::Body surface_of(const Scene &scene) {
    const auto &mesh = scene.body->mesh;
    core::Body surface{.name = scene.body->name, .mesh = {}, .materials = {}, .capsule = scene.body->capsule};
    surface.mesh.points = mesh.points;
    surface.mesh.patch_names = mesh.patch_names;
    if (scene.own_nodes.empty()) {
        surface.mesh.boundary_triangles = mesh.boundary_triangles;
        surface.mesh.boundary_patch = mesh.boundary_patch;
        return surface;
    }
    surface.mesh.points.insert(surface.mesh.points.end(), scene.own_nodes.begin(), scene.own_nodes.end());
    const MiddleNodes middle(mesh);
    for (std::size_t f = 0; f < mesh.boundary_triangles.size(); ++f) {
        const auto [a, b, c] = mesh.boundary_triangles[f];
        const int ab = middle.between(a, b), bc = middle.between(b, c), ca = middle.between(c, a);
        for (const auto &part : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}}) {
            surface.mesh.boundary_triangles.push_back(part);
            surface.mesh.boundary_patch.push_back(mesh.boundary_patch[f]);
        }
    }
    return surface;
}

core::EdgeTable edges_of_facets(const core::TetraMesh &mesh) {
    core::EdgeTable table;
    for (const auto &nodes : mesh.boundary_triangles)
        for (std::size_t k = 0; k < 3; ++k)
            table.edges.push_back(edge_between(nodes[k], nodes[(k + 1) % 3]));
    std::ranges::sort(table.edges);
    table.edges.erase(std::unique(table.edges.begin(), table.edges.end()), table.edges.end());
    return table;
}

} // namespace

std::vector<PointSpring> capsule_edges(const Scene &scene) {
    std::vector<PointSpring> springs;
    if (!scene.body->capsule)
        return springs;
    const auto surface = surface_of(scene);
    const auto table = edges_of_facets(surface.mesh);
    const auto stiffness = core::capsule_springs(surface, table);
    for (std::size_t e = 0; e < table.edges.size(); ++e) {
        if (stiffness[e] == 0.0) // at a wound
            continue;
        const auto [a, b] = table.edges[e];
        springs.push_back({.nodes = {a, b},
                           .weights = {-1.0, 1.0},
                           .rest_length = (surface.mesh.points[b] - surface.mesh.points[a]).norm(),
                           .stiffness = stiffness[e]});
    }
    return springs;
}

namespace {

/// Derivatives of the shape functions of a quadratic tetrahedron along a direction, corners first.
/// @param slopes  of the barycentric coordinates
std::vector<double> quadratic_slopes(const Eigen::Vector4d &coordinates, const Eigen::Vector4d &slopes) {
    std::vector<double> result;
    for (int a = 0; a < 4; ++a)
        result.push_back((4.0 * coordinates[a] - 1.0) * slopes[a]);
    for (const auto &[a, b] : core::tetrahedron_edges)
        result.push_back(4.0 * (coordinates[a] * slopes[b] + coordinates[b] * slopes[a]));
    return result;
}

bool are_parallel(const core::VesselPoint &a, const core::VesselPoint &b) {
    constexpr double rounding = 1e-10; // of directions of the same segment
    return a.tetrahedron == b.tetrahedron && (a.direction - b.direction).norm() < rounding;
}

} // namespace

std::vector<PointSpring> vessel_fibres(const Scene &scene) {
    std::vector<PointSpring> springs;
    const auto &mesh = scene.body->mesh;
    const auto points = core::vessel_points(*scene.body);
    const bool is_quadratic = !scene.own_nodes.empty();
    const auto table = is_quadratic && !points.empty() ? core::edge_table(mesh.tetrahedra) : core::EdgeTable{};
    const core::VesselPoint *last = nullptr;
    for (const auto &point : points) {
        if (point.weight == 0.0) // its wall is as soft as the tissue in its place
            continue;
        const auto &corners = mesh.tetrahedra[static_cast<std::size_t>(point.tetrahedron)];
        const Eigen::Vector4d slopes = core::coordinate_slopes(mesh, corners, point.direction);
        const double length = 1.0 / slopes.cwiseMax(0.0).sum(); // from the nodes that it leaves to those that it nears
        const double stiffness = point.weight / (length * length);
        if (!is_quadratic && last && are_parallel(*last, point)) {
            springs.back().stiffness += stiffness;
            continue;
        }
        last = &point;
        PointSpring spring{.nodes = {corners.begin(), corners.end()},
                           .weights = {slopes.begin(), slopes.end()},
                           .rest_length = length,
                           .stiffness = stiffness};
        if (is_quadratic) {
            for (const int edge : table.tetrahedron_edge[static_cast<std::size_t>(point.tetrahedron)])
                spring.nodes.push_back(mesh.num_nodes() + edge);
            spring.weights = quadratic_slopes(point.coordinates, slopes);
        }
        for (double &weight : spring.weights)
            weight *= length;
        springs.push_back(std::move(spring));
    }
    return springs;
}

std::vector<PointSpring> capsule_and_vessels(const Scene &scene) {
    auto springs = capsule_edges(scene);
    for (auto &fibre : vessel_fibres(scene))
        springs.push_back(std::move(fibre));
    return springs;
}

std::vector<std::vector<SpringEnd>> springs_at_nodes(std::span<const PointSpring> springs, std::size_t num_nodes) {
    std::vector<std::vector<SpringEnd>> at_node(num_nodes);
    for (std::size_t s = 0; s < springs.size(); ++s)
        for (std::size_t a = 0; a < springs[s].nodes.size(); ++a)
            at_node[springs[s].nodes[a]].push_back({s, a});
    return at_node;
}

Energy::Triplets laplacian(const std::vector<PointSpring> &springs) {
    Energy::Triplets triplets;
    for (const auto &spring : springs)
        for (std::size_t a = 0; a < spring.nodes.size(); ++a)
            for (std::size_t b = 0; b < spring.nodes.size(); ++b)
                triplets.emplace_back(spring.nodes[a], spring.nodes[b],
                                      spring.stiffness * spring.weights[a] * spring.weights[b]);
    return triplets;
}

Energy::Triplets sum_of(Energy::Triplets elements, const Energy::Triplets &springs) {
    elements.insert(elements.end(), springs.begin(), springs.end());
    return elements;
}

double PointSpringEnergy::value(const Field &x) const {
    double value = 0.0;
    for (const auto &spring : springs_)
        value += spring.law().value(spring.span(x));
    return value;
}

void PointSpringEnergy::add_forces(const Field &x, Field &f) const {
    for (const auto &spring : springs_) {
        const core::Vector3 pull = spring.law().pull(spring.span(x));
        for (std::size_t a = 0; a < spring.nodes.size(); ++a)
            f.col(spring.nodes[a]) -= spring.weights[a] * pull;
    }
}

void PointSpringEnergy::add_hessian(const Field &x, bool is_projected, Triplets &triplets) const {
    for (const auto &spring : springs_) {
        const Matrix3 tangent = spring.law().tangent(spring.span(x), is_projected);
        for (std::size_t a = 0; a < spring.nodes.size(); ++a)
            for (std::size_t b = 0; b < spring.nodes.size(); ++b)
                for (int i = 0; i < 3; ++i)
                    for (int k = 0; k < 3; ++k)
                        triplets.emplace_back(3 * spring.nodes[a] + i, 3 * spring.nodes[b] + k,
                                              spring.weights[a] * spring.weights[b] * tangent(i, k));
    }
}

namespace {

Eigen::Map<const Eigen::VectorXd> unknowns(const Field &field) {
    return {field.data(), field.size()};
}

/// core::foundation_stiffness() where displacements are quadratic: entries of the integral of N_a N_b over a facet, by
/// corners and the middles of the edges between corners k and k + 1, in parts of A / 180.
Eigen::SparseMatrix<double> quadratic_foundation_stiffness(const Scene &scene, const core::Foundation &foundation) {
    constexpr std::array<std::array<double, 6>, 6> part_of_area{{{6, -1, -1, 0, -4, 0},
                                                                 {-1, 6, -1, 0, 0, -4},
                                                                 {-1, -1, 6, -4, 0, 0},
                                                                 {0, 0, -4, 32, 16, 16},
                                                                 {-4, 0, 0, 16, 32, 16},
                                                                 {0, -4, 0, 16, 16, 32}}};
    const auto &mesh = scene.body->mesh;
    const MiddleNodes middle(mesh);
    Energy::Triplets entries;
    for (std::size_t which = 0; which < foundation.facets.size(); ++which) {
        const int facet = foundation.facets[which];
        const auto [a, b, c] = mesh.boundary_triangles[facet];
        const std::array nodes{a, b, c, middle.between(a, b), middle.between(b, c), middle.between(c, a)};
        core::add_blocks(entries, nodes, part_of_area,
                         core::area_vector(mesh, facet).norm() / 180.0 * foundation.stiffness_on(mesh, which));
    }
    const Eigen::Index size = 3 * num_nodes(scene);
    Eigen::SparseMatrix<double> stiffness(size, size);
    stiffness.setFromTriplets(entries.begin(), entries.end());
    return stiffness;
}

} // namespace

OnFoundation::OnFoundation(const Energy &body, const Scene &scene, const core::Foundation &foundation)
    : body_(body), rest_(rest_positions(scene)),
      stiffness_(scene.own_nodes.empty() ? core::foundation_stiffness(scene.body->mesh, foundation)
                                         : quadratic_foundation_stiffness(scene, foundation)) {}

double OnFoundation::value(const Field &x) const {
    const Field moved = x - rest_;
    return body_.value(x) + 0.5 * unknowns(moved).dot(stiffness_ * unknowns(moved));
}

void OnFoundation::add_forces(const Field &x, Field &f) const {
    body_.add_forces(x, f);
    const Field moved = x - rest_;
    Eigen::Map<Eigen::VectorXd>(f.data(), f.size()) -= stiffness_ * unknowns(moved);
}

void OnFoundation::add_hessian(const Field &x, bool is_projected, Triplets &triplets) const {
    body_.add_hessian(x, is_projected, triplets);
    for (Eigen::Index column = 0; column < stiffness_.outerSize(); ++column)
        for (Eigen::SparseMatrix<double>::InnerIterator entry(stiffness_, column); entry; ++entry)
            triplets.emplace_back(entry.row(), entry.col(), entry.value());
}

} // namespace livermark::interactive
