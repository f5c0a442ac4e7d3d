#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>
#include <string>

#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "meshes/generators/box_generator.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/samples/lagrange_elements.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {

namespace {

using core::Vector3;
using std::numbers::pi;

/// Saint-Venant's cantilever of rectangular section, bent by a force P at its free end: an exact solution of
/// three-dimensional elasticity without body force, whose long sides are free of traction.
///
/// With axes through the middle of the root, z along the beam of length l, P along x, the section |x| <= a, |y| <= b,
/// and k = P / (E I), I = 4 a^3 b / 3 (semi-inverse method; Timoshenko and Goodier, Theory of Elasticity, chapter 12):
///   u_x = nu k (l - z) (x^2 - y^2) / 2 + k (l z^2 / 2 - z^3 / 6)
///   u_y = nu k (l - z) x y
///   u_z = -k (l z - z^2 / 2) x + warping(x, y)
///   warping = c x - k x^3 / 3 - nu k (x^3 - 3 x y^2) / 6 + sum over n of C_n sinh(n pi x / b) cos(n pi y / b)
///   c = k a^2 + nu k (a^2 - b^2 / 3),  C_n = -4 nu k b^3 (-1)^n / (n^3 pi^3 cosh(n pi a / b))
struct Cantilever {
    core::Material material;
    double length, a, b; ///< l and half the sides of the section [m]
    double force;        ///< P [N]

    double k() const { return force / (material.young_modulus * 4.0 * a * a * a * b / 3.0); }

    /// The warping and its slopes in x and y: value, d/dx, d/dy.
    Vector3 warping(double x, double y) const {
        const double nu = material.poisson_ratio;
        Vector3 sum((k() * a * a + nu * k() * (a * a - b * b / 3.0)) * x - k() * x * x * x / 3.0 -
                        nu * k() * (x * x * x - 3.0 * x * y * y) / 6.0,
                    k() * a * a + nu * k() * (a * a - b * b / 3.0) - k() * x * x - nu * k() * (x * x - y * y) / 2.0,
                    nu * k() * x * y);
        double sign = -1.0;
        for (int n = 1; n <= 40; ++n, sign = -sign) { // what is left out is 1e-5 of the largest shear, at one edge
            const double w = n * pi / b;
            const double c = -4.0 * nu * k() * sign / (w * w * w);
            // sinh(w x) / cosh(w a) and cosh(w x) / cosh(w a), which alone would overflow
            const double up = std::exp(w * (x - a)), down = std::exp(-w * (x + a)), all = 1.0 + std::exp(-2.0 * w * a);
            sum += c * Vector3((up - down) / all * std::cos(w * y), w * (up + down) / all * std::cos(w * y),
                               -w * (up - down) / all * std::sin(w * y));
        }
        return sum;
    }

    Vector3 displacement(const Vector3 &p) const {
        const double nu = material.poisson_ratio, x = p.x(), y = p.y(), z = p.z(), l = length;
        return {nu * k() * (l - z) * (x * x - y * y) / 2.0 + k() * (l * z * z / 2.0 - z * z * z / 6.0),
                nu * k() * (l - z) * x * y, -k() * (l * z - z * z / 2.0) * x + warping(x, y)[0]};
    }

    Eigen::Matrix3d gradient(const Vector3 &p) const {
        const double nu = material.poisson_ratio, x = p.x(), y = p.y(), z = p.z(), l = length;
        const Vector3 warp = warping(x, y);
        Eigen::Matrix3d gradient;
        gradient << nu * k() * (l - z) * x, -nu * k() * (l - z) * y,
            -nu * k() * (x * x - y * y) / 2.0 + k() * (l * z - z * z / 2.0),   //
            nu * k() * (l - z) * y, nu * k() * (l - z) * x, -nu * k() * x * y, //
            -k() * (l * z - z * z / 2.0) + warp[1], warp[2], -k() * (l - z) * x;
        return gradient;
    }
};

/// The generated box stands on its corner; the beam's axis starts in the middle of its root.
core::TetraMesh beam_mesh(const Cantilever &beam, double edge) {
    auto mesh = meshes::generate_box({2.0 * beam.a, 2.0 * beam.b, beam.length}, edge);
    for (auto &point : mesh.points)
        point -= Vector3(beam.a, beam.b, 0.0);
    return mesh;
}

/// Parameter: Poisson's ratio.
class FemCantilever : public testing::TestWithParam<double> {
  protected:
    Cantilever beam{{1000.0, 5000.0, GetParam()}, 0.3, 0.04, 0.03, 0.05};
};

} // namespace

TEST_P(FemCantilever, ExactSolutionIsInEquilibriumAndFreeOnItsSides) {
    const auto stress_at = [&](const Vector3 &point) { return tests::stress(beam.material, beam.gradient(point)); };
    const double bending = beam.force * beam.length * beam.a / (4.0 * std::pow(beam.a, 3) * beam.b / 3.0);
    const double step = 1e-5;
    for (const Vector3 &point : {Vector3(0.01, 0.02, 0.1), Vector3(-0.03, 0.005, 0.2), Vector3(0.02, -0.01, 0.05)}) {
        Vector3 force = Vector3::Zero(); // div sigma, and grad u, by central differences
        for (int j = 0; j < 3; ++j) {
            const Vector3 shift = step * Vector3::Unit(j);
            force += (stress_at(point + shift) - stress_at(point - shift)).col(j) / (2.0 * step);
            const Vector3 slope = (beam.displacement(point + shift) - beam.displacement(point - shift)) / (2.0 * step);
            EXPECT_LT((slope - beam.gradient(point).col(j)).norm(), 1e-8 * beam.k() * beam.length * beam.length);
        }
        EXPECT_LT(force.norm(), 1e-6 * bending / beam.a);
    }
    EXPECT_LT(stress_at({0.5 * beam.a, beam.b, 0.1}).col(1).norm(), 1e-12 * bending);
    EXPECT_LT(stress_at({beam.a, 0.3 * beam.b, 0.1}).col(0).norm(), 1e-4 * bending); // as far as the series goes
}

TEST_P(FemCantilever, QuadraticElementsMeetTheExactSolution) {
    const auto mesh = beam_mesh(beam, 0.016);
    const auto system = fem_reference::assemble(*tests::make_body(mesh, beam.material), 2);
    std::vector<double> prescribed(3 * system.points.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t n = 0; n < system.facet_nodes.size(); ++n)
        if (mesh.patch_names[mesh.boundary_patch[n / system.nodes_per_facet]] == "z_min") {
            const int node = system.facet_nodes[n];
            Vector3::Map(&prescribed[3 * node]) = beam.displacement(system.points[node]);
        }
    std::vector<double> load(prescribed.size(), 0.0);
    tests::add_traction(
        system, mesh, "z_max",
        [&](const Vector3 &point) -> Vector3 { return tests::stress(beam.material, beam.gradient(point)).col(2); },
        load);
    Vector3 total = Vector3::Zero();
    for (std::size_t node = 0; node < system.points.size(); ++node)
        total += Vector3::Map(&load[3 * node]);
    EXPECT_LT((total - Vector3(beam.force, 0.0, 0.0)).norm(), 1e-6 * beam.force);

    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    const auto found = solver.solve(prescribed, load);
    ASSERT_TRUE(found.unique);
    const auto error = tests::relative_error(system, found.displacement,
                                             {[&](const Vector3 &p) { return beam.displacement(p); },
                                              [&](const Vector3 &p) { return beam.gradient(p); },
                                              {}});

    double tip = 0.0; // deflection of the loaded end, the mean of its corner nodes
    double exact_tip = 0.0;
    for (int node = 0; node < mesh.num_nodes(); ++node)
        if (mesh.points[node].z() == beam.length) {
            tip += found.displacement[3 * node];
            exact_tip += beam.displacement(mesh.points[node]).x();
        }
    EXPECT_LT(error.l2, 1e-4);
    EXPECT_LT(error.h1, 2e-3);
    EXPECT_NEAR(tip, exact_tip, 1e-4 * exact_tip);
}

INSTANTIATE_TEST_SUITE_P(PoissonRatio, FemCantilever, testing::Values(0.0, 0.25, 0.45, 0.49),
                         [](const auto &info) { return fmt::format("nu_0{:.0f}", 100.0 * info.param); });

namespace {

/// NAFEMS LE10, thick plate under pressure (The Standard NAFEMS Benchmarks, 1990): a quarter of a plate between the
/// ellipses x^2 / 2^2 + y^2 / 1^2 = 1 and x^2 / 3.25^2 + y^2 / 2.75^2 = 1, 0 <= z <= 0.6 m, with a pressure of 1 MPa on
/// its upper side; symmetry at x = 0 and y = 0; u_x = u_y = 0 on the outer face and u_z = 0 on its middle line.
/// Asked for is sigma_y at D = (2, 0, 0.6).
const core::Material steel{7800.0, 210e9, 0.3};
constexpr double thickness = 0.6;
constexpr double target_stress = -5.38e6; ///< [Pa]

/// A block of bricks, cut into tetrahedra and bent: first axis from the inner to the outer ellipse, second along them.
core::TetraMesh plate_mesh(const std::array<int, 3> &bricks) {
    auto mesh = tests::box_mesh({1.0, 1.0, thickness}, bricks);
    for (auto &point : mesh.points) {
        const double angle = point.y() * std::numbers::pi / 2.0;
        const double out = point.x();
        point.x() = (2.0 + 1.25 * out) * std::cos(angle);
        point.y() = (1.0 + 1.75 * out) * std::sin(angle);
    }
    mesh.patch_names = {"inner", "outer", "at_y_0", "at_x_0", "lower", "upper"};
    return mesh;
}

std::vector<double> supports(const core::TetraMesh &mesh, const fem_reference::ElasticSystem &system) {
    std::vector<double> prescribed(3 * system.points.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t n = 0; n < system.facet_nodes.size(); ++n) {
        const auto &patch = mesh.patch_names[mesh.boundary_patch[n / system.nodes_per_facet]];
        const int node = system.facet_nodes[n];
        if (patch == "at_x_0" || patch == "outer")
            prescribed[3 * node] = 0.0;
        if (patch == "at_y_0" || patch == "outer")
            prescribed[3 * node + 1] = 0.0;
        if (patch == "outer" && std::abs(system.points[node].z() - 0.5 * thickness) < 1e-9)
            prescribed[3 * node + 2] = 0.0;
    }
    return prescribed;
}

/// The stress at a corner node, averaged over the tetrahedra that meet there.
Eigen::Matrix3d nodal_stress(const fem_reference::ElasticSystem &system, int node,
                             const std::vector<double> &displacement) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    int num_cells = 0;
    for (std::size_t first = 0; first < system.cell_nodes.size(); first += system.nodes_per_cell)
        for (int v = 0; v < 4; ++v)
            if (system.cell_nodes[first + v] == node) {
                const int cell = static_cast<int>(first) / system.nodes_per_cell;
                sum += tests::stress(
                    steel, tests::displacement_gradient(system, cell, Eigen::Vector4d::Unit(v), displacement));
                ++num_cells;
            }
    return sum / num_cells;
}

/// sigma_y at D [Pa]
double stress_at_d(const std::array<int, 3> &bricks) {
    const auto mesh = plate_mesh(bricks);
    const auto system = fem_reference::assemble(*tests::make_body(mesh, steel), 2);
    std::vector<double> load(3 * system.points.size(), 0.0);
    tests::add_traction(
        system, mesh, "upper", [](const Vector3 &) { return Vector3(0.0, 0.0, -1e6); }, load);
    fem_reference::ConstrainedSolver solver(compressed_rows(system.stiffness));
    const auto found = solver.solve(supports(mesh, system), load);
    EXPECT_TRUE(found.unique);
    const Vector3 d(2.0, 0.0, thickness);
    const auto nearest =
        std::ranges::min_element(mesh.points, {}, [&](const Vector3 &point) { return (point - d).norm(); });
    EXPECT_LT((*nearest - d).norm(), 1e-9);
    return nodal_stress(system, static_cast<int>(nearest - mesh.points.begin()), found.displacement)(1, 1);
}

} // namespace

TEST(FemNafemsLe10, StressConvergesToTheTarget) {
    std::vector<double> stress;
    for (const int n : {1, 2, 4}) {
        stress.push_back(stress_at_d({4 * n, 6 * n, 2 * n}));
    }
    EXPECT_NEAR(stress[2], target_stress, 0.01 * std::abs(target_stress));
    // The differences to the target fall steadily, so that it is met by more than chance.
    EXPECT_LT(std::abs(stress[1] - target_stress), 0.6 * std::abs(stress[0] - target_stress));
    EXPECT_LT(std::abs(stress[2] - target_stress), 0.6 * std::abs(stress[1] - target_stress));
}

namespace {

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
            EXPECT_NEAR(l2, degree + 1.0, 0.2) << "L2 errors " << coarse.error.l2 << ", " << fine.error.l2;
            EXPECT_NEAR(h1, degree, 0.15) << "H1 errors " << coarse.error.h1 << ", " << fine.error.h1;
        }
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

using fem_reference::SolverChoice;

/// A rod of two materials, constrained at one end, with a side that may slide and is moved: pulled and hanging.
TEST(FemOfALargeBody, SolvesQuadraticElementsOnTwoLevelsAsWithAFactor) {
    auto problem = tests::shaken_rod(0.45, {20, 16, 12});
    tests::pull(problem.load_case, problem.body->mesh, "x_max", {20.0, -10.0, 5.0});
    const auto found = fem_reference::solve_static(problem, 2, SolverChoice::automatic);
    ASSERT_GT(found.degrees_of_freedom, fem_reference::largest_direct_quadratic_system);
    EXPECT_NE(found.solver.find("two levels over CHOLMOD"), std::string::npos) << found.solver;
    const auto expected = fem_reference::solve_static(problem, 2, SolverChoice::direct);
    ASSERT_EQ(found.status, core::SolutionStatus::ok) << found.message;
    EXPECT_LT(tests::relative_difference(found.displacement, expected.displacement), 1e-8);
    EXPECT_LT(tests::relative_difference(found.reaction, expected.reaction), 1e-8);
    EXPECT_NEAR(found.strain_energy, expected.strain_energy, 1e-8 * expected.strain_energy);
}

/// None keeps it from moving.
TEST(FemOfALargeBody, SaysWhenItIsFreeToMove) {
    auto problem = tests::shaken_rod(0.45, {20, 16, 12});
    for (int f = 0; f < problem.load_case.num_facets(); ++f)
        problem.load_case.free_facet(f);
    tests::pull(problem.load_case, problem.body->mesh, "x_max", {20.0, -10.0, 5.0});
    EXPECT_EQ(fem_reference::solve_static(problem, 2).status, core::SolutionStatus::not_converged);
}

} // namespace livermark
