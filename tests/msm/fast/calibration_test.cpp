#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "core/error_norms.hpp"
#include "msm/calibration.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/statics/equilibrium.hpp"
#include "msm/volume_term.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"

namespace livermark {
namespace {

using core::Vector3;

using tests::nan;

/// A box constrained at one end, under random forces on its other nodes; springs of the first law and the nodal volume.
class Calibration : public testing::Test {
  protected:
    Calibration() {
        for (const auto &point : body_->mesh.points)
            constrained_.emplace_back(Vector3::Constant(point.x() == 0.0 ? 0.0 : nan));
        for (const auto &term : msm::all_volume_terms())
            if (term.name == "nodal_volume")
                volume_ = term.make(*body_, {4e3});
        task_.points = body_->mesh.points;
        task_.springs = msm::spring_network(*body_, msm::all_spring_laws().front());
        task_.other_stiffness = volume_->hessian(msm::to_unknowns(task_.points), msm::Tangent::material);
        task_.constrained = constrained_;
        task_.nodal_volume = core::nodal_volumes(body_->mesh);
    }

    double random() { return std::uniform_real_distribution<double>(-1.0, 1.0)(generator_); }

    /// The springs with every stiffness changed by a factor of up to exp(amount).
    core::SpringNetwork perturbed(double amount) {
        auto springs = task_.springs;
        for (auto &stiffness : springs.stiffness)
            stiffness *= std::exp(amount * random());
        return springs;
    }

    std::vector<Vector3> random_force() {
        std::vector<Vector3> force;
        for (std::size_t i = 0; i < task_.points.size(); ++i)
            force.emplace_back(random(), random(), random());
        return force;
    }

    /// By the code that solves load cases.
    std::vector<Vector3> linear_solution(const core::SpringNetwork &springs, const std::vector<Vector3> &force) const {
        const msm::ElasticBody elastic(springs.node_mass, {msm::spring_term(springs), volume_});
        msm::NodalConditions conditions;
        conditions.displacement = constrained_;
        conditions.constraint.assign(constrained_.size(), {-1, -1, -1});
        conditions.force = force;
        msm::EquilibriumOptions linear_only;
        linear_only.max_iterations = 0;
        return msm::find_equilibrium(elastic, task_.points, conditions, linear_only).linear_displacement;
    }

    void add_solves(const core::SpringNetwork &springs, int num_training, int num_held_out) {
        for (int l = 0; l < num_training + num_held_out; ++l) {
            auto force = random_force();
            for (auto &value : force)
                value *= 1e-4;
            auto displacement = linear_solution(springs, force);
            (l < num_training ? task_.training : task_.held_out).push_back({std::move(force), std::move(displacement)});
        }
    }

    std::shared_ptr<const core::Body> body_ =
        tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2}), {1060.0, 5e3, 0.25});
    std::shared_ptr<const msm::ElasticTerm> volume_;
    std::vector<Vector3> constrained_;
    msm::CalibrationTask task_;
    std::mt19937 generator_{1};
};

double largest(const std::vector<double> &values) {
    return *std::ranges::max_element(values);
}

TEST_F(Calibration, GradientIsThatOfFiniteDifferences) {
    add_solves(perturbed(0.5), 3, 1);
    task_.penalty = 0.1;
    msm::CalibrationObjective objective(task_);
    Eigen::VectorXd point = objective.start();
    for (auto &value : point)
        value += 0.3 * random();
    const auto state = objective.evaluate(point);
    constexpr double step = 1e-4;
    Eigen::VectorXd differences(point.size());
    for (Eigen::Index s = 0; s < point.size(); ++s) {
        auto beside = point;
        beside[s] = point[s] + step;
        const double above = objective.evaluate(beside).objective;
        beside[s] = point[s] - step;
        differences[s] = (above - objective.evaluate(beside).objective) / (2.0 * step);
    }
    // The error of the differences goes with the square of the step.
    EXPECT_LT((state.gradient - differences).norm(), 1e-7 * differences.norm());
}

TEST_F(Calibration, ErrorsAreThoseOfTheComparisonWithTheReference) {
    add_solves(perturbed(0.5), 2, 1);
    const auto other = perturbed(0.5);
    msm::CalibrationObjective objective(task_);
    const Eigen::VectorXd point =
        Eigen::VectorXd::Map(other.stiffness.data(), static_cast<Eigen::Index>(other.stiffness.size())).array().log();
    const auto state = objective.evaluate(point);
    const auto expected = [&](const msm::ExpectedSolution &solution) {
        core::Solution found, reference;
        found.displacement = linear_solution(other, solution.force);
        reference.displacement = solution.displacement;
        return core::compare(body_->mesh, {}, found, reference, "reference").relative_l2;
    };
    ASSERT_EQ(state.training_errors.size(), 2u);
    ASSERT_EQ(state.held_out_errors.size(), 1u);
    double mean_square = 0.0;
    for (std::size_t l = 0; l < 2; ++l) {
        EXPECT_NEAR(state.training_errors[l], expected(task_.training[l]), 1e-10);
        mean_square += 0.5 * state.training_errors[l] * state.training_errors[l];
    }
    EXPECT_NEAR(state.held_out_errors[0], expected(task_.held_out[0]), 1e-10);
    EXPECT_NEAR(state.objective, mean_square, 1e-12);
}

TEST_F(Calibration, FindsTheSpringsThatMadeTheSolutions) {
    const auto wanted = perturbed(0.5);
    add_solves(wanted, 20, 4);
    msm::CalibrationObjective objective(task_);
    const auto before = objective.evaluate(objective.start());
    ASSERT_GT(largest(before.held_out_errors), 0.05);
    auto stiffness = task_.springs.stiffness;
    for (int round = 0; round < 10; ++round)
        stiffness = msm::calibration_round(objective, stiffness, 50, 100.0);
    const auto after = objective.evaluate(
        Eigen::VectorXd::Map(stiffness.data(), static_cast<Eigen::Index>(stiffness.size())).array().log());
    EXPECT_LT(largest(after.training_errors), 1e-3);
    EXPECT_LT(largest(after.held_out_errors), 1e-3);
}

TEST_F(Calibration, RoundsDoNotDependOnWhoRunsThem) {
    add_solves(perturbed(0.5), 3, 1);
    task_.penalty = 1e-3;
    msm::CalibrationObjective one(task_);
    const auto first = msm::calibration_round(one, task_.springs.stiffness, 7, 100.0);
    const auto second = msm::calibration_round(one, first, 7, 100.0);
    msm::CalibrationObjective other(task_);
    EXPECT_EQ(msm::calibration_round(other, first, 7, 100.0), second);
}

TEST_F(Calibration, StaysWithinTheBoundsAndNeverGetsWorse) {
    add_solves(perturbed(0.5), 3, 1);
    msm::CalibrationObjective objective(task_);
    constexpr double widest = 1.1;
    const auto stiffness = msm::calibration_round(objective, task_.springs.stiffness, 30, widest);
    double farthest = 1.0;
    for (std::size_t s = 0; s < stiffness.size(); ++s) {
        const double ratio = stiffness[s] / task_.springs.stiffness[s];
        farthest = std::max({farthest, ratio, 1.0 / ratio});
    }
    EXPECT_NEAR(farthest, widest, 1e-12);
    const double before = objective.evaluate(objective.start()).objective;
    const double after =
        objective
            .evaluate(Eigen::VectorXd::Map(stiffness.data(), static_cast<Eigen::Index>(stiffness.size())).array().log())
            .objective;
    EXPECT_LT(after, before);
}

TEST_F(Calibration, PenaltyKeepsTheSpringsNearTheirStart) {
    add_solves(perturbed(0.5), 3, 1);
    const auto change = [&](double penalty) {
        task_.penalty = penalty;
        msm::CalibrationObjective objective(task_);
        const auto stiffness = msm::calibration_round(objective, task_.springs.stiffness, 50, 100.0);
        double sum = 0.0;
        for (std::size_t s = 0; s < stiffness.size(); ++s)
            sum += std::pow(std::log(stiffness[s] / task_.springs.stiffness[s]), 2.0);
        return sum;
    };
    EXPECT_LT(change(1.0), 0.1 * change(0.0));
}

} // namespace
} // namespace livermark
