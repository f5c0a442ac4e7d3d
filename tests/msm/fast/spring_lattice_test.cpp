#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "msm/statics/equilibrium.hpp"
#include "tests/not_a_number.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

using tests::nan;

/// A block of cubic cells with springs to the 18 nearest neighbours, k = 0.4 E a. Each cell gives a quarter of a spring
/// to each of its edges and half a spring to each diagonal of its faces, so that a cell alone already has the
/// elasticity of the continuum: E_eff = E and Poisson's ratio 1/4 exactly, boundary cells included.
struct Lattice {
    std::vector<Vector3> points;
    core::SpringNetwork springs;
};

constexpr int cells = 4;
constexpr double spacing = 0.01;
constexpr double lattice_modulus = 5000.0;

int node_at(int i, int j, int k) {
    return i + (cells + 1) * (j + (cells + 1) * k);
}

Lattice make_lattice() {
    Lattice lattice;
    for (int k = 0; k <= cells; ++k)
        for (int j = 0; j <= cells; ++j)
            for (int i = 0; i <= cells; ++i)
                lattice.points.emplace_back(spacing * i, spacing * j, spacing * k);
    const double k18 = 0.4 * lattice_modulus * spacing;
    std::map<std::array<int, 2>, double> stiffness;
    for (int cell = 0; cell < cells * cells * cells; ++cell) {
        const std::array origin{cell % cells, cell / cells % cells, cell / (cells * cells)};
        for (int a = 0; a < 8; ++a)
            for (int b = a + 1; b < 8; ++b) {
                const int differ = __builtin_popcount(static_cast<unsigned>(a ^ b));
                if (differ == 3)
                    continue; // the space diagonals are not among the 18
                const auto corner = [&](int c) {
                    return node_at(origin[0] + (c & 1), origin[1] + (c >> 1 & 1), origin[2] + (c >> 2 & 1));
                };
                stiffness[{corner(a), corner(b)}] += (differ == 1 ? 0.25 : 0.5) * k18;
            }
    }
    for (const auto &[edge, k] : stiffness) {
        lattice.springs.edges.push_back(edge);
        lattice.springs.stiffness.push_back(k);
        lattice.springs.rest_length.push_back((lattice.points[edge[1]] - lattice.points[edge[0]]).norm());
    }
    lattice.springs.node_mass.assign(lattice.points.size(), 1.0);
    return lattice;
}

/// Uniaxial traction along x on rollers: the linearised solution is the affine field of the continuum.
TEST(SpringLattice, With18NeighboursIsIsotropicElasticityWithPoissonOneQuarter) {
    const auto lattice = make_lattice();
    const double stress = 3.0;
    msm::NodalConditions conditions;
    conditions.displacement.assign(lattice.points.size(), Vector3::Constant(nan));
    conditions.constraint.assign(lattice.points.size(), {-1, -1, -1});
    conditions.force.assign(lattice.points.size(), Vector3::Zero());
    for (std::size_t n = 0; n < lattice.points.size(); ++n)
        for (int c = 0; c < 3; ++c)
            if (lattice.points[n][c] == 0.0) {
                conditions.displacement[n][c] = 0.0;
                conditions.constraint[n][static_cast<std::size_t>(c)] = 0;
            }
    for (int j = 0; j < cells; ++j)
        for (int k = 0; k < cells; ++k)
            for (const auto &[dj, dk] : {std::array{0, 0}, {1, 0}, {0, 1}, {1, 1}})
                conditions.force[node_at(cells, j + dj, k + dk)].x() += stress * spacing * spacing / 4.0;

    const auto result = msm::find_equilibrium(lattice.springs, lattice.points, conditions);
    ASSERT_EQ(result.status, core::SolutionStatus::ok) << result.message;
    const double strain = stress / lattice_modulus;
    const double scale = strain * spacing * cells;
    for (std::size_t n = 0; n < lattice.points.size(); ++n) {
        const auto &x = lattice.points[n];
        const Vector3 exact(strain * x.x(), -0.25 * strain * x.y(), -0.25 * strain * x.z());
        EXPECT_LT((result.linear_displacement[n] - exact).norm(), 1e-12 * scale);
    }

    // The springs themselves are geometrically non-linear: the difference is of the order of the strain.
    const double tip = result.displacement[node_at(cells, cells, cells)].x();
    EXPECT_NEAR(tip, scale, 2.0 * strain * scale);
    EXPECT_GT(std::abs(tip - scale), 0.01 * strain * scale);
}

} // namespace
} // namespace livermark
