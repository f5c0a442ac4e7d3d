#include "meshes/liver_registration.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "meshes/liver_shape.hpp"
#include "meshes/surface_mesh.hpp"

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

/// A part of the boundary.
struct Sample {
    Vector3 place, area;
};

/// Facets that stand for equal parts of the area.
std::vector<Sample> samples_of(const core::TetraMesh &mesh, int count) {
    double total = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        total += core::area_vector(mesh, f).norm();
    std::vector<Sample> samples;
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

class Registration {
  public:
    explicit Registration(const core::TetraMesh &mesh)
        : body_(moments_of(mesh.boundary_triangles, mesh.points)), few_(samples_of(mesh, 150)),
          many_(samples_of(mesh, 800)), to_round_(root_of(body_.covariance, -0.5)),
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

    /// The same, and what the normals are off, of which a right angle counts as much as some millimetres.
    double distance(const Quaterniond &rotation) const {
        constexpr double far = 0.04, right_angle = 0.015;
        const auto fit = fit_at(rotation);
        double sum = 0.0;
        for (const auto &sample : many_) {
            const Vector3 place = fit.place(sample.place);
            const double off = 1.0 - fit.normal(sample.area).dot(liver_gradient(place).normalized());
            sum += std::min(std::pow(liver_level(place), 2), far * far) + right_angle * right_angle * off;
        }
        return sum / static_cast<double>(many_.size());
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
    std::vector<Sample> few_, many_;
    Matrix3d to_round_, from_round_;
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

constexpr double apart = std::numbers::pi / 3.0; ///< of orientations that are others

} // namespace

Vector3 LiverFit::normal(const Vector3 &area_vector) const {
    return (linear.inverse().transpose() * area_vector).normalized();
}

LiverFit fit_liver(const core::TetraMesh &mesh) {
    constexpr int num_rotations = 1000, num_refined = 24;
    const Registration registration(mesh);
    const auto quick = [&](const Quaterniond &rotation) { return registration.quick_distance(rotation); };
    const auto exact = [&](const Quaterniond &rotation) { return registration.distance(rotation); };
    std::vector<Candidate> rough;
    for (const auto &rotation : all_rotations(num_rotations))
        rough.push_back({rotation, quick(rotation)});
    std::ranges::sort(rough, {}, &Candidate::square);
    // The orientation of a patient in the scanner comes first.
    rough.insert(rough.begin(), {Quaterniond::Identity(), 0.0});
    std::vector<Candidate> candidates;
    for (int i = 0; i < num_refined; ++i) {
        const auto rotation = registration.refined(rough[i].rotation, 0.2, 0.02, quick);
        const bool is_known = std::ranges::any_of(
            candidates, [&](const Candidate &other) { return other.rotation.angularDistance(rotation) < 0.3; });
        if (!is_known)
            candidates.push_back({rotation, exact(rotation)});
    }
    for (auto &candidate : candidates) {
        candidate.rotation = registration.refined(candidate.rotation, 0.1, 0.005, exact);
        candidate.square = exact(candidate.rotation);
    }
    auto best = *std::ranges::min_element(candidates, {}, &Candidate::square);
    constexpr double clearly = 0.85;
    if (const auto &patient = candidates.front();
        patient.rotation.angularDistance(Quaterniond::Identity()) < apart && best.square > clearly * patient.square)
        best = patient;
    double next = std::numeric_limits<double>::infinity();
    for (const auto &candidate : candidates)
        if (candidate.rotation.angularDistance(best.rotation) > apart)
            next = std::min(next, candidate.square);
    auto fit = registration.fit_at(best.rotation);
    fit.distance = std::sqrt(best.square);
    fit.next_distance = std::max(fit.distance, std::sqrt(next));
    return fit;
}

} // namespace livermark::meshes
