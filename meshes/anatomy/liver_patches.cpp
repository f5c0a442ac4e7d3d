#include "meshes/anatomy/liver_patches.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "meshes/generators/liver_generator.hpp"
#include "meshes/generators/liver_shape.hpp"
#include "meshes/generators/surface_mesh.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;
using Eigen::Matrix3d;
using Eigen::Quaterniond;

/// Volume, centroid and second moments of a solid.
struct Moments {
    double volume = 0.0;
    Vector3 centroid = Vector3::Zero();
    Matrix3d covariance = Matrix3d::Zero(); ///< second moments about the centroid over the volume [m^2]
};

/// From the tetrahedra between the origin and each triangle of its surface.
template <class Triangles> Moments moments_of(const Triangles &triangles, const std::vector<Vector3> &points) {
    Moments moments;
    Matrix3d about_origin = Matrix3d::Zero();
    for (const auto &[i, j, k] : triangles) {
        const Vector3 &a = points[i], &b = points[j], &c = points[k];
        const double volume = a.dot(b.cross(c)) / 6.0;
        const Vector3 sum = a + b + c;
        moments.volume += volume;
        moments.centroid += 0.25 * volume * sum;
        about_origin +=
            volume / 20.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
    moments.centroid /= moments.volume;
    moments.covariance = about_origin / moments.volume - moments.centroid * moments.centroid.transpose();
    return moments;
}

const Moments &moments_of_shipped_liver() {
    static const Moments moments = [] {
        const auto [low, high] = liver_bounding_box();
        const auto surface = march_tetrahedra([](const Vector3 &p) { return liver_level(p); }, low, high, 0.006);
        return moments_of(surface.triangles, surface.points);
    }();
    return moments;
}

/// @param power  1/2 or -1/2
Matrix3d root_of(const Matrix3d &symmetric, double power) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(symmetric);
    return solver.eigenvectors() * solver.eigenvalues().array().pow(power).matrix().asDiagonal() *
           solver.eigenvectors().transpose();
}

/// Facets that stand for equal parts of the area.
std::vector<BoundarySample> samples_of(const core::TetraMesh &mesh, int count) {
    double total = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        total += core::area_vector(mesh, f).norm();
    std::vector<BoundarySample> samples;
    double so_far = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const Vector3 area = core::area_vector(mesh, f);
        so_far += area.norm();
        if (so_far * count < total * (static_cast<double>(samples.size()) + 0.5))
            continue;
        Vector3 middle = Vector3::Zero();
        for (const int node : mesh.boundary_triangles[f])
            middle += mesh.points[node] / 3.0;
        samples.push_back({middle, area});
    }
    return samples;
}

/// Principal axes of the body as rows, each towards the longer tail of the boundary, so that whatever starts from there
/// is the same in every orientation of the body. The last one makes them right-handed.
Matrix3d own_axes(const Moments &body, const std::vector<BoundarySample> &samples) {
    Matrix3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(body.covariance).eigenvectors().transpose();
    for (int axis = 0; axis < 2; ++axis) {
        double skewness = 0.0;
        for (const auto &sample : samples)
            skewness += std::pow(axes.row(axis).dot(sample.place - body.centroid), 3);
        if (skewness < 0.0)
            axes.row(axis) *= -1.0;
    }
    axes.row(2) = axes.row(0).cross(axes.row(1));
    return axes;
}

class Registration {
  public:
    explicit Registration(const core::TetraMesh &mesh)
        : body_(moments_of(mesh.boundary_triangles, mesh.points)), few_(samples_of(mesh, 150)),
          many_(samples_of(mesh, 800)), axes_(own_axes(body_, many_)),
          to_round_(axes_ * root_of(body_.covariance, -0.5)),
          from_round_(root_of(moments_of_shipped_liver().covariance, 0.5)) {}

    LiverFit fit_at(const Quaterniond &rotation) const {
        LiverFit fit;
        fit.linear = from_round_ * rotation.toRotationMatrix() * to_round_;
        fit.offset = moments_of_shipped_liver().centroid - fit.linear * body_.centroid;
        return fit;
    }

    /// Mean square distance from the capsule [m^2], which is no more than that of a hand's breadth for each sample.
    double quick_distance(const Quaterniond &rotation) const {
        constexpr double far = 0.04;
        const auto fit = fit_at(rotation);
        double sum = 0.0;
        for (const auto &sample : few_)
            sum += std::min(std::pow(liver_level(fit.place(sample.place)), 2), far * far);
        return sum / static_cast<double>(few_.size());
    }

    /// The rotation of a body that lies so.
    Quaterniond lying(const Matrix3d &from_lps) const {
        return Quaterniond(Matrix3d(from_lps.transpose() * axes_.transpose()));
    }

    double distance(const Quaterniond &rotation) const { return boundary_misfit(fit_at(rotation), many_); }

    /// The liver that ships is bent, with a Riedel's lobe and without.
    LiverFit bent(const Quaterniond &rotation) const {
        const auto start = fit_at(rotation);
        const auto usual = adjusted(start, many_, false), with_tongue = adjusted(start, many_, true);
        return with_tongue.distance < usual.distance ? with_tongue : usual;
    }

    /// Goes to the nearest least distance by a pattern search in the rotation vector.
    template <class Distance>
    Quaterniond refined(Quaterniond rotation, double step, double last, Distance distance) const {
        double least = distance(rotation);
        while (step > last) {
            bool is_better = false;
            for (int axis = 0; axis < 3; ++axis)
                for (const double sign : {1.0, -1.0}) {
                    const Quaterniond turned =
                        Quaterniond(Eigen::AngleAxisd(sign * step, Vector3::Unit(axis))) * rotation;
                    if (const double found = distance(turned); found < least) {
                        least = found;
                        rotation = turned.normalized();
                        is_better = true;
                    }
                }
            if (!is_better)
                step *= 0.5;
        }
        return rotation;
    }

  private:
    Moments body_;
    std::vector<BoundarySample> few_, many_;
    Matrix3d axes_, to_round_, from_round_;
};

/// Super-Fibonacci spirals.
std::vector<Quaterniond> all_rotations(int count) {
    constexpr double phi = std::numbers::sqrt2, psi = 1.533751168755204288118041;
    std::vector<Quaterniond> rotations;
    for (int i = 0; i < count; ++i) {
        const double s = i + 0.5, t = s / count;
        const double alpha = 2.0 * std::numbers::pi * s / phi, beta = 2.0 * std::numbers::pi * s / psi;
        rotations.emplace_back(std::sqrt(1.0 - t) * std::cos(beta), std::sqrt(t) * std::sin(alpha),
                               std::sqrt(t) * std::cos(alpha), std::sqrt(1.0 - t) * std::sin(beta));
    }
    return rotations;
}

struct Candidate {
    Quaterniond rotation;
    double square; ///< of the distance [m^2]
};

/// Rotations about which the capsule lies nearest to the boundary, each in a valley of its own; the best comes first.
std::vector<Candidate> best_rotations(const Registration &registration) {
    constexpr int num_rotations = 1000, num_refined = 24;
    constexpr double same = 0.3;
    const auto quick = [&](const Quaterniond &rotation) { return registration.quick_distance(rotation); };
    const auto exact = [&](const Quaterniond &rotation) { return registration.distance(rotation); };
    std::vector<Candidate> rough;
    for (const auto &rotation : all_rotations(num_rotations))
        rough.push_back({rotation, quick(rotation)});
    std::ranges::sort(rough, {}, &Candidate::square);
    std::vector<Candidate> candidates;
    for (int i = 0; i < num_refined; ++i) {
        const auto rotation = registration.refined(rough[i].rotation, 0.2, 0.02, quick);
        const bool is_known = std::ranges::any_of(
            candidates, [&](const Candidate &other) { return other.rotation.angularDistance(rotation) < same; });
        if (!is_known)
            candidates.push_back({rotation, exact(rotation)});
    }
    std::ranges::sort(candidates, {}, &Candidate::square);
    return candidates;
}

/// The rotation in a map.
Quaterniond rotation_of(const LiverFit &fit) {
    const Eigen::JacobiSVD<Matrix3d> parts(fit.linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return Quaterniond(Matrix3d(parts.matrixU() * parts.matrixV().transpose()));
}

} // namespace

Vector3 LiverFit::normal(const Vector3 &area_vector) const {
    return (linear.inverse().transpose() * area_vector).normalized();
}

Matrix3d LiverFit::from_lps() const {
    return rotation_of(*this).toRotationMatrix().transpose();
}

double LiverFit::confidence() const {
    return std::max(0.0, 1.0 - distance / next_distance);
}

double LiverFit::turn() const {
    return rotation_of(*this).angularDistance(Quaterniond::Identity());
}

LiverFit fit_liver(const core::TetraMesh &mesh, const std::optional<Matrix3d> &from_lps) {
    constexpr std::size_t num_bent = 8;
    constexpr double apart = std::numbers::pi / 3.0; // of orientations that are others
    const Registration registration(mesh);
    const auto may_be = [&](const LiverFit &fit) {
        return !from_lps || rotation_of(fit).angularDistance(Quaterniond(Matrix3d(from_lps->transpose()))) < apart;
    };
    std::vector<LiverFit> fits;
    for (const auto &candidate : best_rotations(registration)) {
        fits.push_back(registration.bent(candidate.rotation));
        if (fits.size() == num_bent)
            break;
    }
    if (from_lps) {
        const auto quick = [&](const Quaterniond &turned) { return registration.quick_distance(turned); };
        fits.push_back(registration.bent(registration.refined(registration.lying(*from_lps), 0.2, 0.02, quick)));
    }
    const bool is_any = std::ranges::any_of(fits, may_be);
    const auto distance = [&](const LiverFit &fit) {
        return !is_any || may_be(fit) ? fit.distance : std::numeric_limits<double>::infinity();
    };
    auto best = *std::ranges::min_element(fits, {}, distance);
    const auto rotation = rotation_of(best);
    best.next_distance = std::numeric_limits<double>::infinity();
    for (const auto &fit : fits)
        if (rotation_of(fit).angularDistance(rotation) > apart)
            best.next_distance = std::min(best.next_distance, fit.distance);
    return best;
}

namespace {

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
        const auto pieces = parts_that_touch(std::vector(areas_.size(), true), [&](int t, const auto &visit) {
            for (const int other : next_to(t))
                visit(other);
        });
        std::array<double, num_patches> largest{};
        std::array<int, num_patches> largest_piece{};
        for (int p = 0; p < static_cast<int>(pieces.size()); ++p) {
            double area = 0.0;
            for (const int t : pieces[p])
                area += areas_[t];
            const int patch = mesh_.boundary_patch[pieces[p].front()];
            if (area > largest[patch]) {
                largest[patch] = area;
                largest_piece[patch] = p;
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
