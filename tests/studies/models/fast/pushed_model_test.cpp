#include <Eigen/Eigenvalues>
#include <cmath>
#include <gtest/gtest.h>

#include "core/support/input_error.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/pushed_model.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::models {
namespace {

const std::vector<core::InteriorPlace> pushed_places{{{0.021, 0.014, 0.03}, 0.008}, {{0.02, 0.015, 0.015}, 0.008}};

core::Problem pushed_block(bool is_held = true) {
    const auto body = tests::make_body(tests::box_mesh({0.04, 0.03, 0.03}, {4, 3, 3}), {1060.0, 5e3, 0.45});
    core::Problem problem{body, tests::empty_load_case(body->mesh)};
    if (is_held)
        tests::prescribe(problem.load_case, body->mesh, "z_min", core::Vector3::Zero());
    return problem;
}

core::Model model_of(const std::string &name) {
    return support::find_named(all_models(), name, "model");
}

std::unique_ptr<core::PushedBody> body_of(const std::string &name, const core::Problem &problem) {
    return pushed_model(model_of(name))->prepare(problem, pushed_places, 0, nullptr);
}

const Eigen::VectorXd full_force = (Eigen::VectorXd(6) << 0.05, 0.0, -0.3, 0.1, -0.05, -0.1).finished();

/// A model of each kind, with the linear body that it is at rest.
const std::vector<std::pair<std::string, std::string>> pushed_names{{"fem_p1_neo_hookean", "fem_p1"},
                                                                    {"fem_p2_neo_hookean", "fem_p2"},
                                                                    {"fem_p2p1_neo_hookean", "fem_p2p1"},
                                                                    {"lloyd", "lloyd"},
                                                                    {"patch_nodal_volume", "patch_nodal_volume"},
                                                                    {"nodal_springs", "nodal_springs"},
                                                                    {"nodal_neo_hookean", "nodal_neo_hookean"},
                                                                    {"nodal_neo_hookean_f", "nodal_neo_hookean_f"},
                                                                    {"edge_neo_hookean", "edge_neo_hookean"}};

TEST(PushedModel, GivesWayAsItsComplianceSaysUnderSmallForces) {
    const auto problem = pushed_block();
    for (const auto &[name, linear] : pushed_names) {
        const Eigen::MatrixXd compliance = model_of(linear).compliance(problem, pushed_places).matrix;
        const auto body = body_of(name, problem);
        EXPECT_LT((body->compliance() - compliance).norm(), 1e-3 * compliance.norm()) << name;
        const Eigen::VectorXd force = 1e-3 * full_force, expected = compliance * force;
        const auto found = body->push(force);
        ASSERT_TRUE(found) << name;
        EXPECT_LT((found->displacement - expected).norm(), 3e-3 * expected.norm()) << name;
        EXPECT_NEAR(found->stored, 0.5 * force.dot(expected), 5e-3 * found->stored) << name;
    }
}

TEST(PushedModel, StoresTheWorkOfTheForces) {
    const auto problem = pushed_block();
    constexpr int steps = 20;
    for (const auto &[name, linear] : pushed_names) {
        const bool folds = name == "lloyd"; // springs without a volume, under more than this
        const Eigen::VectorXd all = (folds ? 0.2 : 1.0) * full_force;
        const auto body = body_of(name, problem);
        Eigen::VectorXd last = Eigen::VectorXd::Zero(6);
        double work = 0.0, stored = 0.0;
        for (int step = 1; step <= steps; ++step) {
            const auto found = body->push(all * step / steps);
            ASSERT_TRUE(found) << name;
            work += all.dot(found->displacement - last) * (step - 0.5) / steps;
            last = found->displacement;
            stored = found->stored;
        }
        EXPECT_NEAR(stored, work, 3e-3 * work) << name;
        const Eigen::VectorXd linear_displacement = body->compliance() * all;
        EXPECT_TRUE(folds || (last - linear_displacement).norm() > 0.01 * last.norm()) << name << " moves far";
    }
}

/// Whatever it was pushed with before.
TEST(PushedModel, ComesToTheSamePlaceFromElsewhere) {
    const auto problem = pushed_block();
    for (const auto *name : {"fem_p2p1_neo_hookean", "nodal_neo_hookean"}) {
        const auto body = body_of(name, problem);
        const auto at_once = body->push(full_force);
        ASSERT_TRUE(body->push(-0.5 * full_force)) << name;
        const auto again = body->push(full_force);
        ASSERT_TRUE(at_once && again) << name;
        EXPECT_LT((at_once->displacement - again->displacement).norm(), 1e-5 * again->displacement.norm()) << name;
    }
}

TEST(PushedModel, HasFinerMeshesWhereTheModelHas) {
    EXPECT_EQ(pushed_model(model_of("fem_p2p1_neo_hookean_refined"))->num_meshes, 3);
    EXPECT_EQ(pushed_model(model_of("fem_p2p1_neo_hookean"))->num_meshes, 1);
    EXPECT_FALSE(pushed_model(model_of("fem_p2p1")).has_value());
    EXPECT_FALSE(pushed_model(model_of("corotational_implicit")).has_value());
}

TEST(PushedModel, OfABodyThatIsFreeIsRefused) {
    for (const auto *name : {"fem_p1_neo_hookean", "lloyd"})
        EXPECT_THROW(body_of(name, pushed_block(false)), support::InputError) << name;
}

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
