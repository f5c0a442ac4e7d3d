#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numbers>

#include "fem_reference/solvers/constrained_solver.hpp"
#include "tests/samples/lagrange_elements.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {

namespace {

using core::Vector3;

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
        RecordProperty(fmt::format("sigma_y_{}", n), fmt::format("{:.4e}", stress.back()));
    }
    EXPECT_NEAR(stress[2], target_stress, 0.01 * std::abs(target_stress));
    // The differences to the target fall steadily, so that it is met by more than chance.
    EXPECT_LT(std::abs(stress[1] - target_stress), 0.6 * std::abs(stress[0] - target_stress));
    EXPECT_LT(std::abs(stress[2] - target_stress), 0.6 * std::abs(stress[1] - target_stress));
}

} // namespace livermark
