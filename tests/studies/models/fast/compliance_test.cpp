#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "core/support/input_error.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::models {
namespace {

core::Problem held_block(int bricks) {
    const auto body =
        tests::make_body(tests::box_mesh({0.06, 0.05, 0.04}, {bricks, bricks, bricks}), {1000.0, 5000.0, 0.45});
    core::Problem problem{body, tests::empty_load_case(body->mesh)};
    tests::prescribe(problem.load_case, body->mesh, "z_min", core::Vector3::Zero());
    return problem;
}

const std::vector<core::InteriorPlace> places{{{0.031, 0.024, 0.04}, 0.01}, {{0.03, 0.025, 0.02}, 0.01}};

core::Compliance compliance_of(const char *name, const core::Problem &problem) {
    const auto models = all_models();
    return support::find_named(models, name, "model").compliance(problem, places);
}

TEST(Compliance, OfEachModelIsSymmetricAndPositive) {
    const auto problem = held_block(3);
    int num_models = 0;
    for (const auto &model : all_models()) {
        if (!model.compliance || model.only == core::Regime::large)
            continue;
        ++num_models;
        const auto matrix = model.compliance(problem, places).matrix;
        ASSERT_EQ(matrix.rows(), 6);
        EXPECT_LT((matrix - matrix.transpose()).norm(), 1e-4 * matrix.norm()) << model.name;
        EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues().minCoeff(), 0.0) << model.name;
    }
    EXPECT_GT(num_models, 10);
}

/// The energy of a stiffer discretisation is lower: what gives way is the displacement under its own force.
TEST(Compliance, OfElementsGrowsAsTheyAreRefined) {
    const auto problem = held_block(3);
    const auto linear = compliance_of("fem_p1", problem).matrix.diagonal().sum();
    const auto quadratic = compliance_of("fem_p2", problem).matrix.diagonal().sum();
    const auto refined = compliance_of("fem_p2p1_refined", problem);
    EXPECT_LT(linear, quadratic);
    EXPECT_LT(quadratic, refined.matrix.diagonal().sum());
    ASSERT_EQ(refined.on_coarser.size(), 2U);
    const auto change = [&](const Eigen::MatrixXd &coarser) { return (refined.matrix - coarser).norm(); };
    EXPECT_LT(change(refined.on_coarser[1]), change(refined.on_coarser[0]));
    EXPECT_LT(change(refined.on_coarser[1]), 0.02 * refined.matrix.norm());
}

TEST(Compliance, OfABodyThatIsFreeIsRefused) {
    const auto problem = held_block(2);
    const core::Problem free{problem.body, tests::empty_load_case(problem.body->mesh)};
    for (const auto *name : {"fem_p1", "fem_p2p1", "lloyd"})
        EXPECT_THROW(compliance_of(name, free), support::InputError) << name;
}

} // namespace
} // namespace livermark::models
