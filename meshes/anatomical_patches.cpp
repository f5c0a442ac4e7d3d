#include "meshes/anatomical_patches.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace livermark::meshes {

namespace {

using core::Vector3;
using Eigen::Matrix3d;

struct Rule {
    const char *patch;
    const char *text; ///< what the function says
    /// @param p  centroid of a facet, parts of the bounding box
    /// @param n  its unit outward normal
    bool (*holds)(const Vector3 &p, const Vector3 &n);
};

constexpr std::array rules{
    Rule{"left_lobe_tip", "x > 0.88", [](const Vector3 &p, const Vector3 &) { return p.x() > 0.88; }},
    Rule{"posterior", "0.15 < x < 0.62, y > 0.42, z > 0.6, n_y + n_z > 0.5",
         [](const Vector3 &p, const Vector3 &n) {
             return p.x() > 0.15 && p.x() < 0.62 && p.y() > 0.42 && p.z() > 0.6 && n.y() + n.z() > 0.5;
         }},
    Rule{"right_lobe_dome", "0.15 < x < 0.56, y < 0.42, z > 0.66, n_z - n_y > 0.6",
         [](const Vector3 &p, const Vector3 &n) {
             return p.x() > 0.15 && p.x() < 0.56 && p.y() < 0.42 && p.z() > 0.66 && n.z() - n.y() > 0.6;
         }},
    Rule{"superior", "x > 0.56, y < 0.7, n_z > 0.3",
         [](const Vector3 &p, const Vector3 &n) { return p.x() > 0.56 && p.y() < 0.7 && n.z() > 0.3; }},
    Rule{"anterior", "n_y < -0.2, n_x > -0.7",
         [](const Vector3 &, const Vector3 &n) { return n.y() < -0.2 && n.x() > -0.7; }},
    Rule{"inferior", "n_y > 0.3, n_z < 0.3",
         [](const Vector3 &, const Vector3 &n) { return n.y() > 0.3 && n.z() < 0.3; }},
    Rule{"right_lateral", "n_x < -0.6", [](const Vector3 &, const Vector3 &n) { return n.x() < -0.6; }},
};

/// Second moments of the volume about its centroid.
Matrix3d second_moments(const core::TetraMesh &mesh, Vector3 &centroid) {
    const auto volumes = tetrahedron_volumes(mesh);
    centroid.setZero();
    double volume = 0.0;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        for (const int node : mesh.tetrahedra[t])
            centroid += 0.25 * volumes[t] * mesh.points[node];
        volume += volumes[t];
    }
    centroid /= volume;
    Matrix3d moments = Matrix3d::Zero();
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        Vector3 sum = Vector3::Zero();
        for (const int node : mesh.tetrahedra[t]) {
            const Vector3 from_centroid = mesh.points[node] - centroid;
            moments += volumes[t] / 20.0 * from_centroid * from_centroid.transpose();
            sum += from_centroid;
        }
        moments += volumes[t] / 20.0 * sum * sum.transpose();
    }
    return moments;
}

/// Rows are the principal axes, the one nearest to x first, each turned so that it points along its axis.
Matrix3d principal_axes(const Matrix3d &moments) {
    const Matrix3d vectors = Eigen::SelfAdjointEigenSolver<Matrix3d>(moments).eigenvectors();
    Matrix3d axes = Matrix3d::Zero();
    std::array<bool, 3> is_named{}, is_used{};
    for (int step = 0; step < 3; ++step) {
        int axis = 0, best = 0;
        double largest = -1.0;
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k)
                if (!is_named[i] && !is_used[k] && std::abs(vectors(i, k)) > largest) {
                    largest = std::abs(vectors(i, k));
                    axis = i;
                    best = k;
                }
        is_named[axis] = is_used[best] = true;
        axes.row(axis) = std::copysign(1.0, vectors(axis, best)) * vectors.col(best).transpose();
    }
    return axes;
}

/// The first rule that a facet meets; as many as there are if it meets none.
std::size_t rule_of(const Vector3 &place, const Vector3 &normal) {
    return static_cast<std::size_t>(
        std::ranges::find_if(rules, [&](const Rule &rule) { return rule.holds(place, normal); }) - rules.begin());
}

/// Patches that no facet has any more lose their names.
void drop_empty_patches(core::TetraMesh &mesh) {
    std::vector<int> new_number(mesh.patch_names.size(), -1);
    std::vector<std::string> names;
    for (std::size_t patch = 0; patch < mesh.patch_names.size(); ++patch)
        if (std::ranges::find(mesh.boundary_patch, static_cast<int>(patch)) != mesh.boundary_patch.end()) {
            new_number[patch] = static_cast<int>(names.size());
            names.push_back(mesh.patch_names[patch]);
        }
    for (int &patch : mesh.boundary_patch)
        patch = new_number[patch];
    mesh.patch_names = std::move(names);
}

} // namespace

std::vector<std::string> find_anatomical_patches(core::TetraMesh &mesh) {
    Vector3 centroid;
    const Matrix3d axes = principal_axes(second_moments(mesh, centroid));
    Eigen::AlignedBox3d box; // along the principal axes
    for (const auto &point : mesh.points)
        box.extend(Vector3(axes * (point - centroid)));
    const auto is_anatomical = [](const std::string &name) {
        return std::ranges::any_of(rules, [&](const Rule &rule) { return name == rule.patch; });
    };
    const auto of_file = mesh.patch_names;
    std::array<int, rules.size()> number{};
    std::array<double, rules.size()> area{};
    number.fill(-1);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (is_anatomical(of_file[mesh.boundary_patch[f]]))
            continue;
        const Vector3 area_vector = core::area_vector(mesh, f);
        Vector3 middle = Vector3::Zero();
        for (const int node : mesh.boundary_triangles[f])
            middle += (mesh.points[node] - centroid) / 3.0;
        const Vector3 place = (axes * middle - box.min()).cwiseQuotient(box.sizes());
        const auto rule = rule_of(place, axes * area_vector.normalized());
        if (rule == rules.size() || std::ranges::find(of_file, rules[rule].patch) != of_file.end())
            continue;
        if (number[rule] < 0) {
            number[rule] = static_cast<int>(mesh.patch_names.size());
            mesh.patch_names.emplace_back(rules[rule].patch);
        }
        mesh.boundary_patch[f] = number[rule];
        area[rule] += area_vector.norm();
    }
    drop_empty_patches(mesh);
    constexpr double square_centimetres = 1e4;
    std::vector<std::string> remarks;
    for (std::size_t rule = 0; rule < rules.size(); ++rule)
        if (number[rule] >= 0)
            remarks.push_back(fmt::format("patch {}: {:.1f} cm^2 by the rule {}", rules[rule].patch,
                                          square_centimetres * area[rule], rules[rule].text));
    return remarks;
}

} // namespace livermark::meshes
