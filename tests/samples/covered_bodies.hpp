#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "tests/samples/test_meshes.hpp"

/// Bodies with a capsule, and what closed forms say of them.
namespace livermark::tests::covered {

inline const core::Capsule capsule{.thickness = 2e-4, .young_modulus = 4e5}; ///< E t = 80 N/m

inline std::shared_ptr<const core::Body> with_capsule(const std::shared_ptr<const core::Body> &body,
                                                      const std::optional<core::Capsule> &cover = capsule) {
    auto covered = *body;
    covered.capsule = cover;
    return std::make_shared<const core::Body>(std::move(covered));
}

inline Eigen::Matrix3d some_strain() {
    Eigen::Matrix3d strain;
    strain << 0.11, 0.04, -0.02, 0.04, -0.07, 0.05, -0.02, 0.05, 0.06;
    return strain;
}

/// The part of a strain in the plane of a facet.
inline Eigen::Matrix2d in_plane(const Eigen::Matrix3d &strain, const core::Vector3 &normal) {
    Eigen::Matrix<double, 3, 2> plane;
    plane << normal.unitOrthogonal(), normal.normalized().cross(normal.unitOrthogonal());
    return plane.transpose() * strain * plane;
}

/// All of the surface displaced by (F - I) x.
inline core::Problem deformed(const std::shared_ptr<const core::Body> &body, const Eigen::Matrix3d &f) {
    auto load_case = empty_load_case(body->mesh);
    for (const auto &patch : body->mesh.patch_names)
        prescribe(load_case, body->mesh, patch, core::Vector3::Zero());
    for (const auto &point : body->mesh.points)
        load_case.node_shift.emplace_back(f * point - point);
    return {body, load_case};
}

/// The energy of the capsule of a body where F is the same everywhere [J], by the lengths and the area of a square on
/// it.
inline double capsule_energy(const core::Body &body, const Eigen::Matrix3d &f) {
    double energy = 0.0;
    for (int facet = 0; facet < body.mesh.num_boundary_triangles(); ++facet) {
        const core::Vector3 normal = core::area_vector(body.mesh, facet);
        const core::Vector3 along = normal.unitOrthogonal(), across = normal.normalized().cross(along);
        const double trace = (f * along).squaredNorm() + (f * across).squaredNorm(),
                     area_ratio = (f * along).cross(f * across).norm();
        energy += capsule.stiffness() / 6.0 * normal.norm() * (trace + 1.0 / (area_ratio * area_ratio) - 3.0);
    }
    return energy;
}

/// The same of small strains [J]: E t / 3 (e : e + (tr e)^2).
inline double small_capsule_energy(const core::Body &body, const Eigen::Matrix3d &strain) {
    double energy = 0.0;
    for (int facet = 0; facet < body.mesh.num_boundary_triangles(); ++facet) {
        const core::Vector3 normal = core::area_vector(body.mesh, facet);
        const auto here = in_plane(strain, normal);
        energy += capsule.stiffness() / 3.0 * normal.norm() * (here.squaredNorm() + here.trace() * here.trace());
    }
    return energy;
}

/// An eighth of a ball, whose flat sides slide, blown up by a traction or a pressure outside. It is a cube whose corner
/// is rounded so that no tetrahedron becomes flat: x sqrt(1 - y^2/2 - z^2/2 + y^2 z^2/3).
/// @param bricks  along a side
inline core::Problem blown_up_ball(double radius, int bricks, const core::Material &material, double pressure,
                                   core::ConditionKind kind) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    auto mesh = box_mesh({1.0, 1.0, 1.0}, {bricks, bricks, bricks});
    for (auto &point : mesh.points) {
        const core::Vector3 q = point.cwiseAbs2();
        point = radius * core::Vector3(point.x() * std::sqrt(1.0 - q.y() / 2.0 - q.z() / 2.0 + q.y() * q.z() / 3.0),
                                       point.y() * std::sqrt(1.0 - q.z() / 2.0 - q.x() / 2.0 + q.z() * q.x() / 3.0),
                                       point.z() * std::sqrt(1.0 - q.x() / 2.0 - q.y() / 2.0 + q.x() * q.y() / 3.0));
    }
    // The flat sides are cuts: the capsule is outside.
    for (const auto *const side : {"x_min", "y_min", "z_min"})
        for (auto &name : mesh.patch_names)
            if (name == side)
                name = std::string(core::wound_patch) + core::patch_joint + side;
    const auto body = make_body(std::move(mesh), material);
    auto load_case = empty_load_case(body->mesh);
    const auto name = [](const char *side) { return std::string(core::wound_patch) + core::patch_joint + side; };
    prescribe(load_case, body->mesh, name("x_min"), {0.0, nan, nan});
    prescribe(load_case, body->mesh, name("y_min"), {nan, 0.0, nan});
    prescribe(load_case, body->mesh, name("z_min"), {nan, nan, 0.0});
    std::vector<int> outside;
    for (int f = 0; f < body->mesh.num_boundary_triangles(); ++f)
        if (core::Capsule::covers(body->mesh, f))
            outside.push_back(f);
    load_case.put({.place = "outside", .kind = kind}, outside, core::Vector3::Zero());
    for (const int f : outside)
        load_case.value[f] = pressure * core::area_vector(body->mesh, f).normalized();
    return {with_capsule(body), load_case};
}

/// Mean and standard deviation of |x + u| / |x| - 1 at the nodes of the capsule.
struct Growth {
    double mean = 0.0, spread = 0.0;
};
inline Growth growth(const core::TetraMesh &mesh, const std::vector<core::Vector3> &displacement) {
    std::vector<char> is_outside(mesh.points.size(), 0);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (core::Capsule::covers(mesh, f))
            for (const int node : mesh.boundary_triangles[f])
                is_outside[node] = 1;
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (std::size_t i = 0; i < is_outside.size(); ++i)
        if (is_outside[i]) {
            const double grown = (mesh.points[i] + displacement[i]).norm() / mesh.points[i].norm() - 1.0;
            sum += grown;
            squares += grown * grown;
            count += 1.0;
        }
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, squares / count - mean * mean))};
}

/// c of a ball with the capsule under the traction p n, u = c x: p = 3 K c + 4 E t c / R, for the strain c all over
/// makes the stress 3 K c inside and the tension 2 E t c in the sphere.
inline double small_growth(double radius, const core::Material &material, double pressure) {
    const double bulk = material.lame_lambda() + 2.0 / 3.0 * material.shear_modulus();
    return pressure / (3.0 * bulk + 4.0 * capsule.stiffness() / radius);
}

} // namespace livermark::tests::covered
