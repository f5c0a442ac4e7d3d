#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <ranges>
#include <sstream>

#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/io/body_reader.hpp"
#include "meshes/io/mesh_files.hpp"
#include "studies/models/model_table.hpp"

namespace livermark {
namespace {

using core::Vector3;

const std::filesystem::path root = LIVERMARK_SOURCE_DIR;
constexpr double length = 0.12, side = 0.04; // m
const Vector3 axis(0.0, side / 2.0, side / 2.0);

std::string bytes_of(const std::filesystem::path &file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

/// The body that ships under a load case that ships, as it is written.
core::Problem beam(const std::string &load_case) {
    const auto body = std::make_shared<const core::Body>(meshes::read_body(root / "meshes" / "beam.toml"));
    return {body, load_cases::read_load_case(root / "load_cases" / (load_case + ".toml"), body->mesh)};
}

std::vector<Vector3> displacement(const core::Problem &problem, const std::string &model) {
    const auto models = models::all_models();
    const auto solution = std::ranges::find(models, model, &core::Model::name)->solve(problem);
    EXPECT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
    return solution.displacement;
}

/// Traction of a load case on the free end.
Vector3 traction_at_end(const core::Problem &problem) {
    const auto &load_case = problem.load_case;
    const auto facets = std::views::iota(0, load_case.num_facets());
    return load_case.value.at(*std::ranges::find_if(facets, [&](int f) { return load_case.is_loaded(f); }));
}

TEST(Beam, MeshIsReproducedByteForByte) {
    const auto file = std::filesystem::path(testing::TempDir()) / "livermark_beam.msh";
    meshes::write_msh(file, meshes::generate_box({length, side, side}, 0.006));
    EXPECT_TRUE(bytes_of(file) == bytes_of(root / "meshes" / "beam.msh"))
        << "if the generator was meant to change, make the mesh anew with the command in beam.toml";
    std::filesystem::remove(file);
}

TEST(Beam, StretchesUniformlyWithLinearAndQuadraticElements) {
    const auto problem = beam("beam_stretch");
    const auto &material = problem.body->materials.front();
    const double strain = traction_at_end(problem).x() / material.young_modulus;
    for (const auto *model : {"fem_p1", "fem_p2", "fem_p2p1"}) {
        const auto u = displacement(problem, model);
        for (std::size_t i = 0; i < u.size(); ++i) {
            const Vector3 &p = problem.body->mesh.points[i];
            const Vector3 exact =
                strain * Vector3(p.x(), -material.poisson_ratio * p.y(), -material.poisson_ratio * p.z());
            ASSERT_LT((u[i] - exact).norm(), 1e-8 * strain * length) << model;
        }
    }
}

/// The deflection of the end, where the clamp only holds what a beam holds: with Poisson's ratio 0.45 it also keeps the
/// section from drawing in, which takes some per cent off.
TEST(Beam, BendsAsTimoshenkoSaysWherePoissonsRatioIsZero) {
    auto problem = beam("beam_bend");
    auto body = *problem.body;
    body.materials.front().poisson_ratio = 0.0;
    problem.body = std::make_shared<const core::Body>(body);
    const auto &material = body.materials.front();
    const double area = side * side, inertia = area * area / 12.0;
    const double force = traction_at_end(problem).z() * area;
    constexpr double shear_coefficient = 5.0 / 6.0;
    const double exact = force * length * length * length / (3.0 * material.young_modulus * inertia) +
                         force * length / (shear_coefficient * material.shear_modulus() * area);
    const auto u = displacement(problem, "fem_p2");
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < u.size(); ++i)
        if (body.mesh.points[i].x() > length - 1e-9) {
            sum += u[i].z();
            ++count;
        }
    ASSERT_GT(count, 10);
    EXPECT_NEAR(sum / count / exact, 1.0, 0.01);
}

/// As it ships, in the middle half, away from both ends: u_z = a + b x + k (l x^2 / 2 - x^3 / 6 + nu (l - x)
/// (z^2 - y^2) / 2), k = F / (E I), is Saint-Venant's cantilever but for its rotation.
TEST(Beam, CurvesAsEulerAndBernoulliSay) {
    const auto problem = beam("beam_bend");
    const auto &material = problem.body->materials.front();
    const double area = side * side;
    const double exact = 12.0 * traction_at_end(problem).z() / (material.young_modulus * area);
    const auto u = displacement(problem, "fem_p2p1");
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    Vector3 right = Vector3::Zero();
    for (std::size_t i = 0; i < u.size(); ++i) {
        const Vector3 p = problem.body->mesh.points[i] - axis;
        const double x = p.x() / length; // for the condition of the matrix
        if (x < 0.25 || x > 0.75)
            continue;
        const double bend =
            x * x / 2.0 - x * x * x / 6.0 +
            material.poisson_ratio * (1.0 - x) * (p.z() * p.z() - p.y() * p.y()) / 2.0 / (length * length);
        const Vector3 basis(1.0, x, bend);
        matrix += basis * basis.transpose();
        right += u[i].z() * basis;
    }
    const double curvature = matrix.inverse().row(2).dot(right) / (length * length * length);
    EXPECT_NEAR(curvature / exact, 1.0, 0.01);
}

/// In the middle half, away from both ends.
TEST(Beam, TwistsAsSaintVenantSays) {
    const auto problem = beam("beam_twist");
    const auto &mesh = problem.body->mesh;
    double torque = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (problem.load_case.is_loaded(f)) {
            const auto &[a, b, c] = mesh.boundary_triangles[f];
            const Vector3 centroid = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3.0;
            torque += area_vector(mesh, f).norm() * (centroid - axis).cross(problem.load_case.value[f]).x();
        }
    const double twist = torque / (0.140577 * problem.body->materials.front().shear_modulus() * std::pow(side, 4));
    const auto u = displacement(problem, "fem_p2p1");
    // Least squares of the displacement across the axis with (a + b x) e_x cross r.
    Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < u.size(); ++i) {
        const Vector3 r = mesh.points[i] - axis;
        if (r.x() < 0.25 * length || r.x() > 0.75 * length)
            continue;
        const Vector3 turn = Vector3::UnitX().cross(r);
        const Eigen::Vector2d basis(1.0, r.x());
        matrix += turn.squaredNorm() * basis * basis.transpose();
        right += turn.dot(u[i]) * basis;
    }
    EXPECT_NEAR(matrix.inverse().row(1).dot(right) / twist, 1.0, 0.01);
}

} // namespace
} // namespace livermark
