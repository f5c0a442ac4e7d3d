#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

inline const core::Vector3 rod_size{0.1, 0.08, 0.06}; ///< [m]

/// A box_mesh whose inner nodes are moved at random by up to a tenth of a brick in each direction, always the same way.
inline core::TetraMesh shaken_box_mesh(const core::Vector3 &size, const std::array<int, 3> &bricks) {
    auto mesh = box_mesh(size, bricks);
    std::vector<bool> outer(mesh.points.size(), false);
    for (const auto &triangle : mesh.boundary_triangles)
        for (const int node : triangle)
            outer[node] = true;
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> tenth(-0.1, 0.1);
    for (std::size_t node = 0; node < outer.size(); ++node)
        for (int i = 0; i < 3; ++i) {
            const double shift = tenth(generator) * size[i] / bricks[i];
            mesh.points[node][i] += outer[node] ? 0.0 : shift;
        }
    return mesh;
}

/// A rod of 100 x 80 x 60 mm, some of whose tetrahedra are ten times as stiff: constrained at one end, with a side that
/// is moved along its normal; hanging, and nothing pulls at it yet.
/// @param mesh       of size rod_size, from box_mesh() or the like
/// @param poisson    of the soft part and of the stiff part
/// @param is_stiff   whether a tetrahedron is, by its number
template <class IsStiff>
core::Problem constrained_rod(core::TetraMesh mesh, const std::array<double, 2> &poisson, IsStiff &&is_stiff) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    mesh.region_names = {"soft", "stiff"};
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        mesh.region[t] = is_stiff(t) ? 1 : 0;
    auto body = std::make_shared<core::Body>();
    body->name = "rod";
    body->mesh = std::move(mesh);
    body->materials = {{1060.0, 5000.0, poisson[0]}, {1060.0, 50000.0, poisson[1]}};
    auto load_case = empty_load_case(body->mesh);
    prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    prescribe(load_case, body->mesh, "y_min", {nan, 0.001, nan});
    load_case.acceleration = {0.1, 0.2, -0.5};
    return {body, load_case};
}

/// The same, shaken, every fifth tetrahedron stiff.
inline core::Problem shaken_rod(double poisson_ratio, const std::array<int, 3> &bricks) {
    return constrained_rod(shaken_box_mesh(rod_size, bricks), {poisson_ratio, poisson_ratio},
                           [](int t) { return t % 5 == 0; });
}

/// Two of a mesh side by side that do not touch.
inline core::TetraMesh twice(core::TetraMesh mesh, const core::Vector3 &shift) {
    const auto one = mesh;
    for (const auto &point : one.points)
        mesh.points.push_back(point + shift);
    const auto add = [&](auto &sets, const auto &added) {
        for (auto nodes : added) {
            for (int &node : nodes)
                node += one.num_nodes();
            sets.push_back(nodes);
        }
    };
    add(mesh.tetrahedra, one.tetrahedra);
    add(mesh.boundary_triangles, one.boundary_triangles);
    mesh.region.resize(mesh.tetrahedra.size(), 0);
    mesh.boundary_patch.insert(mesh.boundary_patch.end(), one.boundary_patch.begin(), one.boundary_patch.end());
    return mesh;
}

/// A load case that holds one side, where nothing pulls.
inline core::LoadCase held(const core::TetraMesh &mesh, const std::string &patch = "x_min") {
    auto load_case = empty_load_case(mesh);
    prescribe(load_case, mesh, patch, core::Vector3::Zero());
    return load_case;
}

/// Nothing is prescribed, and nothing pulls.
inline fem_reference::DofConditions no_conditions(const fem_reference::ElasticSystem &system) {
    const auto size = 3 * system.points.size();
    fem_reference::DofConditions conditions;
    conditions.prescribed.assign(size, std::numeric_limits<double>::quiet_NaN());
    conditions.constraint.assign(size, -1);
    conditions.load.assign(size, 0.0);
    return conditions;
}

/// Largest distance between two fields over the largest vector of the second.
inline double relative_difference(const std::vector<core::Vector3> &a, const std::vector<core::Vector3> &b) {
    double difference = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity();
    double size = 0.0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        const double here = (a[i] - b[i]).norm();
        difference = std::isnan(here) ? here : std::max(difference, here); // a NaN must not hide
        if (std::isnan(difference))
            return difference;
        size = std::max(size, b[i].norm());
    }
    return difference / size;
}

/// |a - b| / |b| over all of a series of vectors or numbers.
template <class Series> double relative_l2(const Series &a, const Series &b) {
    double difference = a.size() == b.size() ? 0.0 : std::numeric_limits<double>::infinity(), size = 0.0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        if constexpr (std::is_same_v<typename Series::value_type, double>) {
            difference += (a[i] - b[i]) * (a[i] - b[i]);
            size += b[i] * b[i];
        } else {
            difference += (a[i] - b[i]).squaredNorm();
            size += b[i].squaredNorm();
        }
    return std::sqrt(difference / size);
}

inline Eigen::MatrixXd dense(const fem_reference::SymmetricMatrix &matrix) {
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(matrix.num_rows(), matrix.num_rows());
    for (int row = 0; row < matrix.num_rows(); ++row)
        for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
            full(row, matrix.column[k]) = matrix.value[k];
    return full;
}

inline Eigen::MatrixXd dense(const fem_reference::DivergenceRows<double> &matrix, Eigen::Index num_columns) {
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(matrix.num_rows()), num_columns);
    for (std::size_t row = 0; row < matrix.num_rows(); ++row)
        for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
            for (int i = 0; i < 3; ++i)
                full(static_cast<Eigen::Index>(row), 3 * matrix.column[k] + i) = matrix.value[k][i];
    return full;
}

} // namespace livermark::tests
