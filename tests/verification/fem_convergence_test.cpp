#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "fem_reference/constrained_solver.hpp"
#include "fem_reference/elastic_system.hpp"
#include "tests/verification/fem_test_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
const core::Material material{1000.0, 5000.0, 0.3};

/// An exact solution of Navier's equation without body force, by Papkovich and Neuber:
/// u = 4 (1 - nu) B - grad(x . B) with B = (psi, 0, 0) and psi = e^(a x) cos(b y) cos(c z) harmonic, a^2 = b^2 + c^2.
Vector3 exact_displacement(const Vector3 &point) {
    const double a = 2.5, b = 1.5, c = 2.0;
    const double e = std::exp(a * point.x());
    const double psi = e * std::cos(b * point.y()) * std::cos(c * point.z());
    const Vector3 gradient(a * psi, -b * e * std::sin(b * point.y()) * std::cos(c * point.z()),
                           -c * e * std::cos(b * point.y()) * std::sin(c * point.z()));
    return Vector3((3.0 - 4.0 * material.poisson_ratio) * psi, 0.0, 0.0) - point.x() * gradient;
}

/// Shape functions of the four or ten nodes at barycentric coordinates.
std::vector<double> shape_functions(int nodes_per_cell, const Eigen::Vector4d &bary) {
    std::vector<double> shape;
    for (int v = 0; v < 4; ++v)
        shape.push_back(nodes_per_cell == 4 ? bary[v] : bary[v] * (2.0 * bary[v] - 1.0));
    if (nodes_per_cell == 10)
        for (const auto &[a, b] : {std::pair{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}})
            shape.push_back(4.0 * bary[a] * bary[b]);
    return shape;
}

/// Points and weights (of sum 1) on a tetrahedron, exact far beyond degree 4: Gauss points of a cube, collapsed.
std::vector<std::pair<Eigen::Vector4d, double>> fine_quadrature() {
    constexpr std::array<double, 4> node{0.069431844202973714, 0.330009478207571868, 0.669990521792428132,
                                         0.930568155797026286};
    constexpr std::array<double, 4> weight{0.173927422568726929, 0.326072577431273071, 0.326072577431273071,
                                           0.173927422568726929};
    std::vector<std::pair<Eigen::Vector4d, double>> points;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k) {
                const double x = node[i], y = node[j] * (1.0 - x), z = node[k] * (1.0 - x - y);
                points.emplace_back(Eigen::Vector4d(1.0 - x - y - z, x, y, z),
                                    6.0 * weight[i] * weight[j] * weight[k] * (1.0 - x) * (1.0 - x - y));
            }
    return points;
}

/// L2 norm of the error relative to that of the exact solution, on a unit cube of n^3 bricks.
double error_on_bricks(int degree, int n) {
    const auto body = tests::make_body(tests::shaken_box_mesh({1.0, 1.0, 1.0}, {n, n, n}), material);
    const auto system = fem_reference::assemble(*body, degree);
    std::vector<double> prescribed(3 * system.points.size(), std::numeric_limits<double>::quiet_NaN());
    for (const int node : system.facet_nodes) {
        const Vector3 exact = exact_displacement(system.points[node]);
        std::copy_n(exact.data(), 3, prescribed.begin() + 3 * node);
    }
    fem_reference::ConstrainedSolver solver(system.stiffness);
    const auto found = solver.solve(prescribed, std::vector<double>(prescribed.size(), 0.0));
    EXPECT_TRUE(found.unique);

    const auto volumes = core::tetrahedron_volumes(body->mesh);
    double error = 0.0, size = 0.0;
    for (const auto &[bary, weight] : fine_quadrature()) {
        const auto shape = shape_functions(system.nodes_per_cell, bary);
        for (std::size_t t = 0; t < volumes.size(); ++t) {
            const int *const nodes = system.cell_nodes.data() + t * system.nodes_per_cell;
            Vector3 point = Vector3::Zero(), displacement = Vector3::Zero();
            for (int v = 0; v < 4; ++v)
                point += bary[v] * system.points[nodes[v]];
            for (int a = 0; a < system.nodes_per_cell; ++a)
                displacement += shape[a] * Vector3::Map(&found.displacement[3 * nodes[a]]);
            const Vector3 exact = exact_displacement(point);
            error += volumes[t] * weight * (displacement - exact).squaredNorm();
            size += volumes[t] * weight * exact.squaredNorm();
        }
    }
    return std::sqrt(error / size);
}

} // namespace

/// Parameter: degree p of the elements; the error falls with h^(p + 1).
class FemConvergence : public testing::TestWithParam<int> {};

TEST_P(FemConvergence, HasTheOrderOfItsElements) {
    const int degree = GetParam();
    const int bricks = degree == 1 ? 8 : 4; // linear elements come later to their asymptotic order
    const double coarse = error_on_bricks(degree, bricks);
    const double fine = error_on_bricks(degree, 2 * bricks);
    const double order = std::log2(coarse / fine);
    RecordProperty("order", std::to_string(order));
    EXPECT_NEAR(order, degree + 1.0, 0.1) << "errors " << coarse << ", " << fine;
    EXPECT_LT(fine, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Degree, FemConvergence, testing::Values(1, 2));

} // namespace livermark
