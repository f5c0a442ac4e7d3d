#include "meshes/anatomy/liver_registration.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "meshes/generators/liver/liver_adjustment.hpp"
#include "meshes/generators/liver/liver_shape.hpp"
#include "meshes/generators/surface_mesh.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;
using Eigen::Matrix3d;
using Eigen::Quaterniond;

/// Of a solid.
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

} // namespace livermark::meshes
