#include <gtest/gtest.h>

#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/linear/mixed_solver.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "meshes/generators/box_generator.hpp"
#include "tests/samples/lagrange_elements.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {

namespace {

using core::Vector3;
using fem_reference::Formulation;

/// An exact solution of Navier's equation, the sum of two parts whose stresses stay finite as nu goes to 1/2:
/// Papkovich and Neuber's u = 4 (1 - nu) B - grad(x . B) with B = (psi, 0, 0) and psi = e^(a x) cos(b y) cos(c z)
/// harmonic, a^2 = b^2 + c^2, which needs no body force and is compressed: div u = (2 - 4 nu) d psi / dx;
/// and (sin(k y), sin(k z), sin(k x)), which keeps every volume and needs the body force mu k^2 u.
tests::ElasticField manufactured_field(const core::Material &material) {
    constexpr double a = 1.25, b = 0.75, c = 1.0, k = 1.5;
    const double nu = material.poisson_ratio;
    const auto waves = [](const Vector3 &x) {
        return Vector3(std::sin(k * x.y()), std::sin(k * x.z()), std::sin(k * x.x()));
    };
    tests::ElasticField field;
    field.displacement = [=](const Vector3 &x) -> Vector3 {
        const double e = std::exp(a * x.x());
        const double psi = e * std::cos(b * x.y()) * std::cos(c * x.z());
        const Vector3 slope(a * psi, -b * e * std::sin(b * x.y()) * std::cos(c * x.z()),
                            -c * e * std::cos(b * x.y()) * std::sin(c * x.z()));
        return Vector3((3.0 - 4.0 * nu) * psi, 0.0, 0.0) - x.x() * slope + waves(x);
    };
    field.gradient = [=](const Vector3 &x) {
        const double e = std::exp(a * x.x());
        const double cy = std::cos(b * x.y()), sy = std::sin(b * x.y());
        const double cz = std::cos(c * x.z()), sz = std::sin(c * x.z());
        const Vector3 slope = e * Vector3(a * cy * cz, -b * sy * cz, -c * cy * sz);
        Eigen::Matrix3d curvature;
        curvature << a * a * cy * cz, -a * b * sy * cz, -a * c * cy * sz, //
            -a * b * sy * cz, -b * b * cy * cz, b * c * sy * sz,          //
            -a * c * cy * sz, b * c * sy * sz, -c * c * cy * cz;
        Eigen::Matrix3d gradient = -x.x() * e * curvature;
        gradient.row(0) += (3.0 - 4.0 * nu) * slope.transpose();
        gradient.col(0) -= slope;
        gradient(0, 1) += k * std::cos(k * x.y());
        gradient(1, 2) += k * std::cos(k * x.z());
        gradient(2, 0) += k * std::cos(k * x.x());
        return gradient;
    };
    field.body_force = [=](const Vector3 &x) -> Vector3 { return material.shear_modulus() * k * k * waves(x); };
    return field;
}

struct Outcome {
    double size = 0.0; ///< of the mesh, see tests::mesh_size
    tests::RelativeError error;
    int iterations = 0;
};

/// A unit cube that is constrained at x = 0 as the exact field is and pulled at the five other sides by its tractions.
Outcome solve_on(const core::TetraMesh &mesh, int degree, const core::Material &material,
                 Formulation formulation = Formulation::displacement) {
    const auto field = manufactured_field(material);
    const auto body = tests::make_body(mesh, material);
    const bool is_mixed = formulation == Formulation::mixed;
    const auto system = fem_reference::assemble(is_mixed ? fem_reference::without_pressure(*body) : *body, degree);
    std::vector<double> prescribed(3 * system.points.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t n = 0; n < system.facet_nodes.size(); ++n)
        if (mesh.patch_names[mesh.boundary_patch[n / system.nodes_per_facet]] == "x_min") {
            const int node = system.facet_nodes[n];
            Vector3::Map(&prescribed[3 * node]) = field.displacement(system.points[node]);
        }
    std::vector<double> load(prescribed.size(), 0.0);
    tests::add_body_force(system, field.body_force, load);
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0})
            if (axis > 0 || side > 0.0)
                tests::add_traction(
                    system, mesh, fmt::format("{}_{}", "xyz"[axis], side < 0.0 ? "min" : "max"),
                    [&](const Vector3 &x) -> Vector3 {
                        return side * tests::stress(material, field.gradient(x)).col(axis);
                    },
                    load);
    fem_reference::ChosenSolver solver(system, fem_reference::SolverChoice::direct);
    const auto pressure = is_mixed ? fem_reference::assemble_pressure(*body, system) : fem_reference::PressureSystem{};
    const auto found = is_mixed ? fem_reference::MixedSolver(system, solver, pressure).solve(prescribed, load)
                                : solver.solve(prescribed, load);
    EXPECT_TRUE(found.unique && found.converged);
    return {tests::mesh_size(mesh, degree), tests::relative_error(system, found.displacement, field), found.iterations};
}

struct Case {
    int degree;
    double poisson_ratio;
    std::array<double, 3> edges; ///< of three meshes that have nothing in common [m]
    Formulation formulation = Formulation::displacement;
};

/// Linear elements lock at 0.49 and come to their order only on fine meshes: between edges of 0.1 and 0.06 the L2 error
/// falls with about h^1.6 there, and with h^2.0 at 0.45.
const std::array<Case, 9> cases{{{1, 0.25, {0.12, 0.07, 0.045}},
                                 {1, 0.45, {0.12, 0.07, 0.045}},
                                 {1, 0.49, {0.05, 0.036, 0.028}},
                                 {2, 0.25, {0.2, 0.12, 0.075}},
                                 {2, 0.45, {0.2, 0.12, 0.075}},
                                 {2, 0.49, {0.16, 0.1, 0.065}},
                                 {2, 0.45, {0.2, 0.12, 0.075}, Formulation::mixed},
                                 {2, 0.49, {0.2, 0.12, 0.075}, Formulation::mixed},
                                 {2, 0.4999, {0.2, 0.12, 0.075}, Formulation::mixed}}};

class FemConvergence : public testing::TestWithParam<Case> {};

} // namespace

TEST_P(FemConvergence, HasTheOrderOfItsElementsOnUnstructuredMeshes) {
    const auto &[degree, poisson_ratio, edges, formulation] = GetParam();
    const core::Material material{1000.0, 5000.0, poisson_ratio};
    Outcome coarse;
    for (const double edge : edges) {
        const auto fine = solve_on(meshes::generate_box({1.0, 1.0, 1.0}, edge), degree, material, formulation);
        if (coarse.size > 0.0) {
            const double refinement = std::log(coarse.size / fine.size);
            const double l2 = std::log(coarse.error.l2 / fine.error.l2) / refinement;
            const double h1 = std::log(coarse.error.h1 / fine.error.h1) / refinement;
            RecordProperty(fmt::format("orders_at_{}", edge), fmt::format("{:.3f} {:.3f}", l2, h1));
            EXPECT_NEAR(l2, degree + 1.0, 0.2) << "L2 errors " << coarse.error.l2 << ", " << fine.error.l2;
            EXPECT_NEAR(h1, degree, 0.15) << "H1 errors " << coarse.error.h1 << ", " << fine.error.h1;
        }
        RecordProperty(fmt::format("errors_at_{}", edge),
                       fmt::format("{:.4f} {:.3e} {:.3e}", fine.size, fine.error.l2, fine.error.h1));
        coarse = fine;
    }
    EXPECT_LT(coarse.error.l2, 0.003);
}

INSTANTIATE_TEST_SUITE_P(Fem, FemConvergence, testing::ValuesIn(cases), [](const auto &info) {
    return fmt::format("p{}{}_nu_0{:04.0f}", info.param.degree,
                       info.param.formulation == Formulation::mixed ? "p1" : "", 1e4 * info.param.poisson_ratio);
});

/// The mixed formulation is as good for what keeps its volume as for what does not, and as quick; the other is neither.
TEST(FemMixed, DoesNotLock) {
    const auto mesh = meshes::generate_box({1.0, 1.0, 1.0}, 0.14);
    const auto solve = [&](double poisson_ratio, Formulation formulation) {
        return solve_on(mesh, 2, {1000.0, 5000.0, poisson_ratio}, formulation);
    };
    const auto usual = solve(0.45, Formulation::mixed);
    const auto extreme = solve(0.4999, Formulation::mixed);
    EXPECT_LT(extreme.error.l2, 1.2 * usual.error.l2);
    EXPECT_LT(extreme.error.h1, 1.2 * usual.error.h1);
    EXPECT_LT(extreme.iterations, 1.3 * usual.iterations);
    EXPECT_GT(solve(0.4999, Formulation::displacement).error.h1, 2.0 * extreme.error.h1);
}

} // namespace livermark
