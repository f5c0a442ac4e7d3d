#include <gtest/gtest.h>

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

#include "fem_reference/solvers/constrained_solver.hpp"
#include "meshes/generators/box_generator.hpp"
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
    RecordProperty("errors", fmt::format("L2 {:.2e} H1 {:.2e} tip {:.2e}", error.l2, error.h1, tip / exact_tip - 1.0));
    EXPECT_LT(error.l2, 1e-4);
    EXPECT_LT(error.h1, 2e-3);
    EXPECT_NEAR(tip, exact_tip, 1e-4 * exact_tip);
}

INSTANTIATE_TEST_SUITE_P(PoissonRatio, FemCantilever, testing::Values(0.0, 0.25, 0.45, 0.49),
                         [](const auto &info) { return fmt::format("nu_0{:.0f}", 100.0 * info.param); });

} // namespace livermark
