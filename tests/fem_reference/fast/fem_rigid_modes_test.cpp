// Rigid motions of a discretised body, and columns that are put in balance by them.

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "core/problem.hpp"
#include "fem_reference/dynamics/mass_matrix.hpp"
#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/multigrid/rigid_modes.hpp"
#include "meshes/generators/box_generator.hpp"
#include "tests/not_a_number.hpp"

namespace livermark {
namespace {

using core::Vector3;
using fem_reference::RigidModes;

using tests::nan;

fem_reference::ElasticSystem bar() {
    core::Body body;
    body.name = "bar";
    body.mesh = meshes::generate_box({0.3, 0.1, 0.1}, 0.05);
    body.materials = {{.density = 1000.0, .young_modulus = 5000.0, .poisson_ratio = 0.4}};
    return fem_reference::assemble(body, 2);
}

std::vector<double> multiply(const fem_reference::ElasticSystem &system, const std::vector<double> &u) {
    std::vector<double> out(u.size());
    system.stiffness.multiply(u, out);
    return out;
}

double norm(const std::vector<double> &vector) {
    return std::sqrt(fem_reference::dot(vector, vector));
}

TEST(RigidModes, TakeNoForce) {
    const auto system = bar();
    const RigidModes modes(system.points);
    for (int m = 0; m < RigidModes::count; ++m) {
        std::vector<double> u;
        for (const auto &point : system.points)
            for (int i = 0; i < 3; ++i)
                u.push_back(modes.at(point)(i, m));
        const auto rows = compressed_rows(system.stiffness);
        const double stiffest = *std::ranges::max_element(rows.value);
        EXPECT_LT(norm(multiply(system, u)), 1e-12 * stiffest * norm(u)) << m;
    }
}

/// Columns that constrain one end, or three nodes in six ways, and that begin out of balance by chance.
class Balance : public testing::Test {
  protected:
    Balance() {
        std::vector<double> at_end(num_unknowns, nan), in_six_ways = at_end;
        int first = -1, second = -1, third = -1;
        for (int node = 0; node < system.num_nodes(); ++node) {
            const auto &x = system.points[node];
            if (x.x() < 1e-9)
                for (int i = 0; i < 3; ++i)
                    at_end[3 * node + i] = 0.0;
            if (x.norm() < 1e-9)
                first = node;
            else if ((x - Vector3(0.3, 0.0, 0.0)).norm() < 1e-9)
                second = node;
            else if ((x - Vector3(0.0, 0.1, 0.0)).norm() < 1e-9)
                third = node;
        }
        for (const int dof : {3 * first, 3 * first + 1, 3 * first + 2, 3 * second + 1, 3 * second + 2, 3 * third + 2})
            in_six_ways[dof] = 0.0;
        free = fem_reference::free_unknowns(
            std::vector<std::span<const double>>{at_end, in_six_ways}); // two of four lanes
        std::mt19937 generator(5);
        std::normal_distribution<double> number;
        for (std::size_t i = 0; i < num_unknowns; ++i) {
            load.push_back(number(generator));
            for (int c = 0; c < 2; ++c)
                u[4 * i + c] = is_free(c, i) ? 1e-3 * number(generator) : 0.0;
        }
    }
    bool is_free(int column, std::size_t i) const { return free.sets[free.set[column]][i]; }
    std::vector<double> column(int c) const { return fem_reference::separated(u, 4, 2)[c]; }
    /// r = f - K u where free
    std::vector<double> residual(int c) const {
        auto out = multiply(system, column(c));
        for (std::size_t i = 0; i < num_unknowns; ++i)
            out[i] = is_free(c, i) ? load[i] - out[i] : 0.0;
        return out;
    }
    std::vector<double> residuals() const {
        std::vector<double> together(4 * num_unknowns, 0.0);
        for (int c = 0; c < 2; ++c) {
            const auto of_column = residual(c);
            for (std::size_t i = 0; i < num_unknowns; ++i)
                together[4 * i + c] = of_column[i];
        }
        return together;
    }
    double energy(int c) const { // 1/2 u^T K u - f^T u
        const auto displacement = column(c);
        return 0.5 * fem_reference::dot(displacement, multiply(system, displacement)) -
               fem_reference::dot(displacement, load);
    }

    fem_reference::ElasticSystem system = bar();
    std::size_t num_unknowns = 3 * system.points.size();
    fem_reference::FreeUnknowns free;
    std::vector<double> load, u = std::vector<double>(4 * num_unknowns, 0.0);
};

TEST_F(Balance, LeavesNeitherResultantNorMoment) {
    fem_reference::balance(system, free, residuals(), u);
    for (int c = 0; c < 2; ++c) {
        const auto left = residual(c);
        Vector3 resultant = Vector3::Zero(), moment = resultant;
        for (int node = 0; node < system.num_nodes(); ++node) {
            const auto force = Vector3::Map(&left[3 * node]);
            resultant += force;
            moment += system.points[node].cross(force);
        }
        EXPECT_LT(resultant.norm(), 1e-10 * norm(left)) << c;
        EXPECT_LT(moment.norm(), 1e-10 * norm(left)) << c;
        for (std::size_t i = 0; i < num_unknowns; ++i) {
            if (!is_free(c, i)) {
                EXPECT_EQ(u[4 * i + c], 0.0);
            }
        }
    }
    for (std::size_t i = 0; i < num_unknowns; ++i)
        EXPECT_EQ(u[4 * i + 2], 0.0); // no column needs this lane
}

TEST_F(Balance, GoesDownInTheEnergyAndThenStays) {
    const std::array before{energy(0), energy(1)};
    fem_reference::balance(system, free, residuals(), u);
    const auto once = u;
    for (int c = 0; c < 2; ++c)
        EXPECT_LT(energy(c), before[c]);
    fem_reference::balance(system, free, residuals(), u);
    for (std::size_t i = 0; i < u.size(); ++i)
        EXPECT_NEAR(u[i], once[i], 1e-9);
}

} // namespace
} // namespace livermark
