#include "meshes/segmentation/meshing/mesh_operations.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace livermark::segmentation {

namespace {

using core::Vector3;

/// Quality below which a move must not bring a tetrahedron, unless it was worse before.
constexpr double fair = 0.15;

double worst_at(const core::TetraMesh &mesh, const MeshLinks &links, int node) {
    double worst = std::numeric_limits<double>::infinity();
    for (const int t : links.tetrahedra_of[node])
        worst = std::min(worst, quality_of(mesh, mesh.tetrahedra[t]));
    return worst;
}

double mean_edge_at(const core::TetraMesh &mesh, const MeshLinks &links, int node) {
    double sum = 0.0;
    for (const int t : links.tetrahedra_of[node])
        for (const int other : mesh.tetrahedra[t])
            sum += (mesh.points[other] - mesh.points[node]).norm();
    return sum / (3.0 * static_cast<double>(links.tetrahedra_of[node].size()));
}

/// Goes as far towards a place as leaves the tetrahedra fair, or at least no worse.
void move_towards(core::TetraMesh &mesh, const MeshLinks &links, int node, const Vector3 &place) {
    const Vector3 start = mesh.points[node];
    const double enough = std::min(fair, worst_at(mesh, links, node));
    for (const double part : {1.0, 0.5, 0.25}) {
        mesh.points[node] = start + part * (place - start);
        if (worst_at(mesh, links, node) >= enough)
            return;
    }
    mesh.points[node] = start;
}

/// Directions to the corners and the faces of a cube.
std::vector<Vector3> all_around() {
    std::vector<Vector3> directions;
    for (int d = 0; d < 3; ++d)
        for (const double sign : {-1.0, 1.0})
            directions.push_back(sign * Vector3::Unit(d));
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0})
                directions.push_back(Vector3(x, y, z).normalized());
    return directions;
}

/// The directions that stay on the level sets to first order.
std::vector<Vector3> along_levels(std::vector<Vector3> directions, const LevelGradients &gradients) {
    const LevelGradients normals = independent_normals(gradients);
    for (auto &direction : directions)
        for (Eigen::Index row = 0; row < normals.rows(); ++row)
            if (const double square = normals.row(row).squaredNorm(); square > 0.0)
                direction -= normals.row(row).dot(direction) / square * normals.row(row).transpose();
    std::erase_if(directions, [](const Vector3 &direction) { return direction.norm() < 0.3; });
    return directions;
}

void climb_at(core::TetraMesh &mesh, const LabelDomain &domain, const MeshLinks &links, int node, double quality) {
    static const auto directions = all_around();
    const auto &labels = links.labels_of[node];
    double worst = worst_at(mesh, links, node);
    if (worst >= quality || labels.size() > max_labels)
        return;
    const bool free = labels.size() == 1;
    const Levels levels = free ? Levels() : level_differences(domain, mesh.points[node], labels);
    const double length = mean_edge_at(mesh, links, node);
    for (const double part : {0.2, 0.1, 0.05, 0.02}) {
        const auto ways =
            free ? directions : along_levels(directions, level_gradients(domain, mesh.points[node], labels));
        const Vector3 start = mesh.points[node];
        Vector3 best = start;
        for (const auto &way : ways) {
            mesh.points[node] = start + part * length * way;
            if (worst_at(mesh, links, node) <= worst)
                continue;
            if (!free)
                mesh.points[node] = project_to_levels(domain, mesh.points[node], labels, levels);
            if (const double reached = worst_at(mesh, links, node);
                reached > worst && (mesh.points[node] - start).norm() < length) {
                worst = reached;
                best = mesh.points[node];
            }
        }
        mesh.points[node] = best;
    }
}

/// Place where the labels meet, if that is within reach.
std::optional<Vector3> nearby_border(const LabelDomain &domain, const Vector3 &start, const std::vector<int> &labels,
                                     double reach) {
    const Levels border = Levels::Zero(static_cast<Eigen::Index>(labels.size()) - 1);
    const Vector3 place = project_to_levels(domain, start, labels, border);
    if ((place - start).norm() > reach)
        return std::nullopt;
    const Levels miss = level_differences(domain, place, labels);
    const LevelGradients gradients = level_gradients(domain, place, labels);
    for (Eigen::Index row = 0; row < miss.size(); ++row)
        if (!(std::abs(miss[row]) < 0.1 * domain.fields.spacing * gradients.row(row).norm()))
            return std::nullopt;
    return place;
}

/// Derivatives of the volumes of the regions with respect to the place of a node.
struct VolumeGradient {
    int region;
    Vector3 gradient; ///< [m^2]
};

std::vector<std::vector<VolumeGradient>> volume_gradients(const core::TetraMesh &mesh, const MeshLinks &links) {
    std::vector<std::vector<VolumeGradient>> gradients(mesh.points.size());
    for (std::size_t node = 0; node < mesh.points.size(); ++node) {
        const auto &labels = links.labels_of[node];
        if (labels.size() < 2)
            continue;
        for (const int region : labels) {
            Vector3 gradient = Vector3::Zero();
            for (const int t : links.tetrahedra_of[node]) {
                if (mesh.region[t] != region)
                    continue;
                const int corner = corner_of(mesh.tetrahedra[t], static_cast<int>(node));
                const auto &[i, j, k] = core::tetrahedron_faces[corner];
                const Vector3 &a = mesh.points[mesh.tetrahedra[t][i]];
                const Vector3 &b = mesh.points[mesh.tetrahedra[t][j]];
                const Vector3 &c = mesh.points[mesh.tetrahedra[t][k]];
                gradient -= (b - a).cross(c - a) / 6.0;
            }
            if (region != outside)
                gradients[node].push_back({region, gradient});
        }
    }
    return gradients;
}

} // namespace

void snap_to_levels(core::TetraMesh &mesh, const LabelDomain &domain) {
    const auto links = mesh_links(mesh);
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        auto labels = links.labels_of[node];
        if (labels.size() > max_labels)
            continue;
        // Where the borders do not meet nearby after all, the first of them, which the capsule would be.
        for (; labels.size() > 1; labels.pop_back())
            if (const auto place =
                    nearby_border(domain, mesh.points[node], labels, 0.5 * mean_edge_at(mesh, links, node))) {
                move_towards(mesh, links, node, *place);
                break;
            }
    }
}

void climb(core::TetraMesh &mesh, const LabelDomain &domain, double quality) {
    const auto links = mesh_links(mesh);
    for (int node = 0; node < mesh.num_nodes(); ++node)
        climb_at(mesh, domain, links, node, quality);
}

std::vector<double> volumes_of_regions(const core::TetraMesh &mesh, std::size_t num_regions) {
    std::vector<double> volumes(num_regions, 0.0);
    const auto volume = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volume.size(); ++t)
        volumes[mesh.region[t]] += volume[t];
    return volumes;
}

void correct_volumes(core::TetraMesh &mesh, const std::vector<double> &wanted) {
    constexpr int num_steps = 4;
    const auto links = mesh_links(mesh);
    const auto num_regions = static_cast<Eigen::Index>(wanted.size());
    for (int step = 0; step < num_steps; ++step) {
        const auto volumes = volumes_of_regions(mesh, wanted.size());
        const auto gradients = volume_gradients(mesh, links);
        // The area that a node has of the borders, so that an even move is one of least change.
        std::vector<double> area(mesh.points.size(), 0.0);
        Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(num_regions, num_regions);
        for (std::size_t node = 0; node < gradients.size(); ++node) {
            for (const auto &[region, gradient] : gradients[node])
                area[node] += gradient.norm();
            for (const auto &[r, gradient_r] : gradients[node])
                for (const auto &[s, gradient_s] : gradients[node])
                    normal(r, s) += gradient_r.dot(gradient_s) / area[node];
        }
        Eigen::VectorXd miss(num_regions);
        for (Eigen::Index r = 0; r < num_regions; ++r) {
            miss[r] = wanted[r] - volumes[r];
            normal(r, r) += 1e-9 * normal.diagonal().maxCoeff(); // a region may be missing
        }
        const Eigen::VectorXd pressure = normal.ldlt().solve(miss);
        for (std::size_t node = 0; node < gradients.size(); ++node) {
            Vector3 move = Vector3::Zero();
            for (const auto &[region, gradient] : gradients[node])
                move += pressure[region] / area[node] * gradient;
            if (!gradients[node].empty())
                move_towards(mesh, links, static_cast<int>(node), mesh.points[node] + move);
        }
    }
}

} // namespace livermark::segmentation
