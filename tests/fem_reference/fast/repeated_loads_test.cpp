#include "fem_reference/linear/repeated_loads.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "fem_reference/linear/linear_elasticity.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::fem_reference {
namespace {

constexpr int no_factor = 0;

/// A box that is constrained at one end, and pulled at the other.
struct Pulled {
    explicit Pulled(double poisson_ratio) {
        body = tests::make_body(tests::box_mesh({0.09, 0.03, 0.03}, {9, 3, 3}), {1000.0, 5000.0, poisson_ratio});
        constrained = tests::empty_load_case(body->mesh);
        tests::prescribe(constrained, body->mesh, "x_min", core::Vector3::Zero());
    }
    core::LoadCase load(const core::Vector3 &traction) const {
        auto load_case = constrained;
        tests::pull(load_case, body->mesh, "x_max", traction);
        return load_case;
    }
    std::shared_ptr<const core::Body> body;
    core::LoadCase constrained;
};

double relative_error(const std::vector<core::Vector3> &found, const std::vector<core::Vector3> &expected) {
    double off = 0.0, size = 0.0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        off = std::max(off, (found.at(i) - expected[i]).norm());
        size = std::max(size, expected[i].norm());
    }
    return off / size;
}

TEST(RepeatedLoads, AgreeWithTheStaticSolverWithAndWithoutAFactor) {
    for (const double poisson_ratio : {0.3, 0.45, 0.49}) {
        const Pulled pulled(poisson_ratio);
        StaticSolver expected(pulled.body, 2);
        std::vector<std::string> told;
        const auto tell = [&](const std::string &sentence) { told.push_back(sentence); };
        RepeatedLoads factor(*pulled.body, pulled.constrained, tell);
        RepeatedLoads levels(*pulled.body, pulled.constrained, tell, no_factor);
        EXPECT_EQ(told.size(), 4U);
        std::vector<double> last_of_factor, last_of_levels;
        for (const core::Vector3 &traction : {core::Vector3(100.0, 0.0, 0.0), {0.0, 50.0, -20.0}}) {
            const auto load_case = pulled.load(traction);
            const auto solution = expected.solve(load_case);
            const auto exact = factor.solve(load_case, last_of_factor);
            EXPECT_TRUE(exact.has_converged);
            EXPECT_LT(relative_error(exact.displacement, solution.displacement), 1e-9);
            EXPECT_NEAR(exact.work, 2.0 * solution.strain_energy, 1e-9 * exact.work);
            const auto near = levels.solve(load_case, last_of_levels);
            EXPECT_TRUE(near.has_converged);
            EXPECT_GT(near.iterations, 1);
            EXPECT_LT(relative_error(near.displacement, solution.displacement), 1e-4) << poisson_ratio;
            EXPECT_NEAR(near.work, exact.work, 1e-4 * exact.work);
        }
    }
}

/// StaticSolver finds what a newton on each place does at all of them.
TEST(RepeatedLoads, MoveUnderForcesOnPlacesInside) {
    const Pulled pulled(0.45);
    const core::Vector3 middle(0.045, 0.015, 0.015);
    RepeatedLoads::InnerForces inner{{{middle, 0.008}, {middle + core::Vector3(0.004, 0.0, 0.0), 0.008}},
                                     {{3.0, -1.0, 2.0}, {0.0, 4.0, 1.0}}};
    StaticSolver solver(pulled.body, 2);
    const auto compliance = solver.compliance(pulled.constrained, inner.places);
    const Eigen::VectorXd force = Eigen::Map<const Eigen::VectorXd>(inner.forces.front().data(), 6);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, pulled.constrained, [](const std::string &) {}, largest);
        std::vector<double> last;
        const auto found = loads.solve(pulled.constrained, last, inner);
        ASSERT_TRUE(found.has_converged);
        EXPECT_NEAR(found.work, force.dot(compliance.matrix * force), 1e-4 * found.work);
    }
    inner.places.front().middle.x() += 100.0;
    RepeatedLoads loads(*pulled.body, pulled.constrained, [](const std::string &) {});
    std::vector<double> last;
    EXPECT_THROW(loads.solve(pulled.constrained, last, inner), std::invalid_argument);
}

TEST(RepeatedLoads, NeedFewerIterationsNearTheLastSolution) {
    const Pulled pulled(0.45);
    RepeatedLoads levels(
        *pulled.body, pulled.constrained, [](const std::string &) {}, no_factor);
    std::vector<double> last;
    const auto first = levels.solve(pulled.load({0.0, 50.0, 0.0}), last);
    const auto same = levels.solve(pulled.load({0.0, 50.0, 0.0}), last);
    EXPECT_LE(same.iterations, 1);
    EXPECT_LT(relative_error(same.displacement, first.displacement), 1e-5);
    const auto near = levels.solve(pulled.load({0.0, 50.5, 0.0}), last);
    EXPECT_GT(near.iterations, 0);
    EXPECT_LT(near.iterations, first.iterations);
}

TEST(RepeatedLoads, ClearTheLastSolutionWhenNothingPulls) {
    const Pulled pulled(0.45);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, pulled.constrained, [](const std::string &) {}, largest);
        std::vector<double> last;
        loads.solve(pulled.load({0.0, 50.0, 0.0}), last);
        const auto displacement = loads.solve(pulled.constrained, last).displacement;
        ASSERT_EQ(displacement.size(), pulled.body->mesh.points.size());
        for (const auto &u : displacement)
            EXPECT_EQ(u.norm(), 0.0);
    }
}

TEST(RepeatedLoads, SayWhenNothingHoldsTheBody) {
    const Pulled pulled(0.45);
    const auto free = tests::empty_load_case(pulled.body->mesh);
    for (const int largest : {no_factor, RepeatedLoads::largest_factor}) {
        RepeatedLoads loads(
            *pulled.body, free, [](const std::string &) {}, largest);
        std::vector<double> last;
        const auto solution = loads.solve(free, last);
        EXPECT_FALSE(solution.is_unique);
        EXPECT_FALSE(solution.has_converged);
        EXPECT_TRUE(last.empty());
    }
}

} // namespace
} // namespace livermark::fem_reference
