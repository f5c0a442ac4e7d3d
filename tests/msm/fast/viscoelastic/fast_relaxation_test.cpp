#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/relaxation.hpp"
#include "msm/springs/springs.hpp"
#include "tests/oracles/relaxing_steps.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::PronySeries;
using msm::FastStepOptions;
using msm::FastSteps;
using msm::ForcePrecision;
using msm::State;
using tests::Sample;

constexpr double forever = std::numeric_limits<double>::infinity();
constexpr auto coupled_that_relax = {"nodal_springs", "nodal_neo_hookean", "nodal_neo_hookean_f", "edge_neo_hookean",
                                     "edge_neo_hookean_f"};

/// Stretched, sheared and turned by much, and every node somewhere else by a little.
State sheared_and_turned(const Sample &sample) {
    std::mt19937 random(7);
    auto state = tests::shaken(sample); // which has the velocities
    for (std::size_t i = 0; i < sample.positions.size(); ++i) {
        const auto &x = sample.positions[i];
        const core::Vector3 way = core::Vector3(0.2 * x.x() + 0.5 * x.y(), -0.3 * x.x() + 0.1 * x.z(), 0.0) +
                                  tests::random_vector(random, 0.0005);
        state.displacement.segment<3>(3 * static_cast<Eigen::Index>(i)) = way;
    }
    return state;
}

FastSteps fast_steps(const Sample &sample, const core::RayleighDamping &damping, double step,
                     const FastStepOptions &options) {
    return FastSteps::prepare(sample.body, sample.positions, sample.conditions, damping, "symplectic_euler", step,
                              options)
        .value();
}

/// The error that lets branches move once in so many steps, and no more.
double error_for(const PronySeries &series, int num_steps, double step) {
    double error = 0.0;
    for (std::size_t b = 0; b < series.moduli.size(); ++b)
        error -= series.moduli[b] * std::expm1(-num_steps * step / series.times[b]);
    return error * (1.0 + 1e-9);
}

/// Largest difference of velocities, as a part of their largest change.
double error_of(const State &found, const State &expected, const State &start) {
    return (found.velocity - expected.velocity).lpNorm<Eigen::Infinity>() /
           (expected.velocity - start.velocity).lpNorm<Eigen::Infinity>();
}

/// Some steps from there after the body has stayed for a while, with branches that move in each.
void expect_what_relaxing_steps_do(const Sample &sample) {
    const double step = tests::sample_step, stay = 5.0 * step;
    const PronySeries series{"two", {0.3, 0.4}, {2.0 * step, 40.0 * step}};
    const auto start = sheared_and_turned(sample);
    for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}}) {
        // It comes there within a step.
        msm::RelaxingBody body(sample.body, series);
        const Eigen::VectorXd x = msm::to_unknowns(sample.positions) + start.displacement;
        body.go_on(x, step);
        body.go_on(x, stay);
        tests::RelaxingSteps oracle(std::move(body), sample.positions, sample.conditions, damping, step);
        auto expected = start;
        oracle.take(expected, 4);
        for (const auto precision : tests::both_precisions) {
            auto steps = fast_steps(sample, damping, step,
                                    {.precision = precision, .relaxation = series, .relaxation_error = 0.0});
            EXPECT_EQ(steps.steps_between_relaxations(), 1);
            steps.set_state(start);
            steps.relax(stay);
            steps.take(4);
            EXPECT_LT(error_of(steps.state(), expected, start), tests::tolerance(precision)) << damping.beta;
        }
    }
}

/// The same with branches that are held for some steps.
void expect_what_held_steps_do(const Sample &sample, const char *integrator, int every) {
    const double step = tests::sample_step, stay = 5.0 * step;
    const PronySeries series{"two", {0.3, 0.4}, {8.0 * step, 40.0 * step}};
    const auto start = sheared_and_turned(sample);
    for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}}) {
        msm::HeldSteps oracle(sample.body, series, sample.positions, sample.conditions, damping,
                              msm::find_integrator(integrator), step, every);
        auto expected = start;
        oracle.relax(start.displacement, stay);
        oracle.take(expected, 9);
        for (const auto precision : tests::both_precisions) {
            auto steps = FastSteps::prepare(sample.body, sample.positions, sample.conditions, damping, integrator, step,
                                            {.precision = precision,
                                             .relaxation = series,
                                             .relaxation_error = every == 1 ? 0.0 : error_for(series, every, step)})
                             .value();
            ASSERT_EQ(steps.steps_between_relaxations(), every);
            steps.set_state(start);
            steps.relax(stay);
            steps.take(9);
            EXPECT_LT(error_of(steps.state(), expected, start), 4.0 * tests::tolerance(precision))
                << integrator << " " << every << " " << damping.beta;
        }
    }
}

std::vector<Sample> one_of_each_kind() {
    std::vector<Sample> samples{tests::tetrahedra(108, "")};
    for (const auto *springs : coupled_that_relax)
        samples.push_back(tests::coupled(springs, 108, 0.3, 0.45));
    return samples;
}

class RelaxingKernels : public tests::EveryVectorUnit {};

TEST_P(RelaxingKernels, MoveSpringsAsRelaxingStepsDo) {
    for (const int count : {1, 17, 108})
        for (const auto *term : {"", "nodal_volume"}) {
            SCOPED_TRACE(testing::Message() << count << " " << term);
            expect_what_relaxing_steps_do(tests::tetrahedra(count, term));
        }
}

TEST_P(RelaxingKernels, MoveCoupledSpringsAsRelaxingStepsDo) {
    for (const auto *springs : coupled_that_relax)
        for (const auto &[count, soft_ratio, hard_ratio] :
             {std::tuple(1, 0.45, 0.45), std::tuple(17, 0.25, 0.25), std::tuple(108, 0.25, 0.45)}) {
            SCOPED_TRACE(testing::Message() << springs << " " << count << " " << soft_ratio);
            expect_what_relaxing_steps_do(tests::coupled(springs, count, soft_ratio, hard_ratio));
        }
}

TEST_P(RelaxingKernels, HoldBranchesAsHeldStepsDoWithEveryIntegrator) {
    for (const auto &sample : {tests::tetrahedra(40, "nodal_volume"), tests::coupled("nodal_springs", 40, 0.3, 0.45),
                               tests::coupled("nodal_neo_hookean_f", 40, 0.3, 0.45)}) {
        expect_what_held_steps_do(sample, "symplectic_euler", 4);
        for (const auto *integrator :
             {"explicit_euler", "heun", "runge_kutta_4", "velocity_verlet", "runge_kutta_chebyshev"})
            for (const int every : {1, 4})
                expect_what_held_steps_do(sample, integrator, every);
    }
}

INSTANTIATE_TEST_SUITE_P(FastRelaxation, RelaxingKernels, testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         tests::name_of_unit);

TEST(FastRelaxation, GivesTheSameForAnyNumberOfThreads) {
    const PronySeries series{"one", {0.6}, {0.02}};
    for (const auto &sample : one_of_each_kind())
        for (const int every : {1, 4}) {
            const auto moved = [&](int num_threads) {
                auto steps = fast_steps(sample, {3.0, 0.002}, tests::sample_step,
                                        {.num_threads = num_threads,
                                         .relaxation = series,
                                         .relaxation_error = error_for(series, every, tests::sample_step)});
                EXPECT_EQ(steps.steps_between_relaxations(), every);
                steps.set_state(sheared_and_turned(sample));
                steps.take(7); // in two calls, neither of which ends where branches move
                steps.take(6);
                return steps.state();
            };
            const auto one = moved(1);
            for (const int num_threads : {2, 3, 7}) {
                EXPECT_EQ(one.displacement, moved(num_threads).displacement) << every << " " << num_threads;
                EXPECT_EQ(one.velocity, moved(num_threads).velocity) << every << " " << num_threads;
            }
        }
}

/// A block that is held on one side, stretched along x and let go.
struct StretchedBlock {
    explicit StretchedBlock(const char *springs)
        : elastic(springs == std::string("lloyd")
                      ? msm::ElasticBody(msm::spring_network(*body, msm::all_spring_laws().front()))
                      : msm::coupled_springs_with_volume(*body, msm::find_coupled_springs(springs))) {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
        sample = {elastic, body->mesh.points, msm::nodal_conditions({body, load_case}, elastic.node_mass)};
        critical = 2.0 / msm::largest_angular_frequency(elastic, sample.positions, sample.conditions);
        const auto size = static_cast<Eigen::Index>(3 * sample.positions.size());
        start = {Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
        for (std::size_t i = 0; i < sample.positions.size(); ++i)
            start.displacement[3 * static_cast<Eigen::Index>(i)] = 0.1 * sample.positions[i].x();
    }

    FastSteps steps(const PronySeries &series, double step, int every,
                    const std::string &integrator = "symplectic_euler") const {
        auto steps = FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, integrator, step,
                                        {.precision = ForcePrecision::double_precision,
                                         .relaxation = series,
                                         .relaxation_error = every == 1 ? 0.0 : error_for(series, every, step)})
                         .value();
        EXPECT_EQ(steps.steps_between_relaxations(), every);
        return steps;
    }
    /// Motion after many steps of a part of the critical length, over where it starts.
    double growth(const State &pushed, const std::string &integrator, double part, double time_constant,
                  int every) const {
        auto moved = steps({"one", {0.7}, {time_constant * critical}}, part * critical, every, integrator);
        moved.set_state(pushed);
        moved.take(600);
        return moved.state().displacement.norm() / pushed.displacement.norm();
    }

    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {2, 1, 1}), {1060.0, 5e3, 0.4});
    msm::ElasticBody elastic;
    Sample sample;
    double critical = 0.0; ///< step without branches [s]
    State start;
};

class FastRelaxationOfABlock : public testing::TestWithParam<const char *> {
  protected:
    StretchedBlock block{GetParam()};
};

TEST_P(FastRelaxationOfABlock, IsOfSecondOrderInTheTimeThatBranchesAreHeld) {
    const double step = 0.1 * block.critical;
    const PronySeries series{"two", {0.3, 0.3}, {100.0 * step, 3000.0 * step}};
    const auto moved = [&](int every) {
        auto steps = block.steps(series, step, every);
        steps.set_state(block.start);
        steps.take(160);
        return steps.state().displacement;
    };
    const auto exact = moved(1);
    const double coarse = (moved(16) - exact).norm(), middle = (moved(8) - exact).norm(),
                 fine = (moved(4) - exact).norm();
    EXPECT_LT(coarse, error_for(series, 16, step) * block.start.displacement.norm());
    EXPECT_GT(coarse / middle, 3.0);
    EXPECT_GT(middle / fine, 3.0);
}

/// Nothing is stored or lost but in the springs at rest after all time, the branches, and motion.
TEST_P(FastRelaxationOfABlock, NeverAddsEnergy) {
    const auto remains = msm::relaxed(block.elastic, 0.4);
    const auto equation = msm::elastic_motion(block.elastic, block.sample.positions, block.sample.conditions, {});
    const auto rest = msm::to_unknowns(block.sample.positions);
    const auto energy = [&](const msm::ElasticBody &of, const State &at) {
        double sum = msm::kinetic_energy(equation, at);
        for (const auto &term : of.terms)
            sum += term->energy(rest + at.displacement);
        return sum;
    };
    for (const int every : {1, 8}) {
        const double step = 0.2 * block.critical;
        auto steps = block.steps({"one", {0.6}, {120.0 * step}}, step, every);
        // Velocities stand half a step before positions: those of both neighbours make the one there.
        Eigen::VectorXd acceleration(rest.size());
        equation.acceleration(block.start.displacement, block.start.velocity, acceleration);
        steps.set_state({block.start.displacement, -0.5 * step * acceleration});
        const double start = energy(block.elastic, block.start);
        auto before = steps.state();
        double last = 0.0;
        for (int s = 0; s < 1200; ++s) {
            steps.take(1);
            const auto after = steps.state();
            last = energy(remains, {before.displacement, 0.5 * (before.velocity + after.velocity)});
            ASSERT_LT(last, 1.001 * start) << every << " " << s;
            before = after;
        }
        EXPECT_LT(last, 0.5 * start);
    }
}

TEST_P(FastRelaxationOfABlock, IsStableWhereElasticStepsAreHoweverLongBranchesAreHeld) {
    std::mt19937 random(5);
    State pushed = block.start;
    for (std::size_t i = 0; i < block.sample.positions.size(); ++i)
        for (Eigen::Index c = 0; c < 3; ++c)
            pushed.displacement[3 * static_cast<Eigen::Index>(i) + c] =
                std::isnan(block.sample.conditions.displacement[i][c]) ? 1e-7 * (random() / 2147483648.0 - 1.0) : 0.0;
    for (const int every : {1, 2, 3, 8, 17})
        for (const double time_constant : {0.3, 3.0, 30.0, 3e3}) {
            if (every > 10.0 * time_constant)
                continue; // all fades whatever the error
            EXPECT_LT(block.growth(pushed, "symplectic_euler", 0.99, time_constant, every), 20.0)
                << every << " " << time_constant;
        }
}

/// Integrators that are stable without damping, whose steps hold no invariant of branches.
TEST_P(FastRelaxationOfABlock, IsStableWithOtherIntegrators) {
    State pushed = block.start;
    pushed.displacement *= 1e-6;
    for (const auto &[integrator, longest] : {std::pair("velocity_verlet", 1.0), std::pair("runge_kutta_4", 1.41)})
        for (const int every : {1, 3, 8})
            for (const double time_constant : {3.0, 30.0, 3e3}) {
                if (every > 10.0 * time_constant)
                    continue; // all fades whatever the error
                EXPECT_LT(block.growth(pushed, integrator, 0.99 * longest, time_constant, every), 3.0)
                    << integrator << " " << every << " " << time_constant;
            }
}

TEST_P(FastRelaxationOfABlock, HasTheElasticLimits) {
    const double step = 0.5 * block.critical;
    const auto moved = [&](const PronySeries &series, double error) {
        auto steps = fast_steps(
            block.sample, {}, step,
            {.precision = ForcePrecision::double_precision, .relaxation = series, .relaxation_error = error});
        steps.set_state(block.start);
        if (error == 0.0)
            steps.relax(forever);
        steps.take(50);
        return steps.state().displacement;
    };
    const auto at_once = moved({}, 1e-3);
    EXPECT_EQ(moved({"infinite", {0.7}, {forever}}, 1e-3), at_once);
    const auto at_last = moved({"zero", {0.7}, {1e-14}}, 0.0);
    auto expected = block.start;
    msm::make_stepper(msm::relaxed(block.elastic, 0.3), block.sample.positions, block.sample.conditions, {},
                      msm::find_integrator("symplectic_euler"), step, msm::StepKernel::scalar)
        .take(expected, 50);
    EXPECT_LT((at_last - expected.displacement).norm(), 1e-9 * expected.displacement.norm());
    EXPECT_GT((at_once - at_last).norm(), 0.1 * at_once.norm());
}

INSTANTIATE_TEST_SUITE_P(FastRelaxation, FastRelaxationOfABlock,
                         testing::Values("lloyd", "nodal_springs", "nodal_neo_hookean", "nodal_neo_hookean_f",
                                         "edge_neo_hookean", "edge_neo_hookean_f"),
                         [](const auto &info) { return std::string(info.param); });

/// A mass so heavy that it stays, on a spring whose branch moves by less in a step than a float of its size can tell.
TEST(FastRelaxation, KeepsChangesOfSlowBranchesInSinglePrecision) {
    const double stiffness = 50.0, length = 0.1, stretch = 0.02, tau = 51.3, step = 1e-4, modulus = 0.3, heavy = 1e9;
    Sample sample;
    sample.positions = {core::Vector3::Zero(), core::Vector3(length, 0.0, 0.0)};
    sample.body = core::SpringNetwork{
        .node_mass = {heavy, heavy}, .edges = {{0, 1}}, .stiffness = {stiffness}, .rest_length = {length}};
    sample.conditions = {.displacement = {core::Vector3::Zero(), core::Vector3(std::nan(""), 0.0, 0.0)},
                         .constraint = {},
                         .force = {core::Vector3::Zero(), core::Vector3::Zero()}};
    auto steps = fast_steps(sample, {}, step, {.relaxation = {"slow", {modulus}, {tau}}, .relaxation_error = 0.0});
    State start{Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)};
    start.displacement[3] = stretch;
    steps.set_state(start);
    steps.relax(2.0 * tau);
    const auto force = [&](int num_steps) {
        const double before = steps.velocity(1).x();
        steps.take(num_steps);
        return (before - steps.velocity(1).x()) * heavy / (num_steps * step);
    };
    const double first = force(100);
    steps.take(19900);
    const double last = force(100);
    const double fallen = modulus * stiffness * stretch * std::exp(-2.0) * -std::expm1(-20000.0 * step / tau);
    EXPECT_NEAR(first - last, fallen, 0.01 * fallen);
}

TEST(FastRelaxation, MovesBranchesAsOftenAsTheErrorAsksFor) {
    const PronySeries liver{"liver", {0.3, 0.3}, {1.86, 51.3}};
    const auto moved_by = [&](int m) { return error_for(liver, m, 1e-4) / (1.0 + 1e-9); };
    for (const double error : {1e-4, 1e-3, 1e-2}) {
        const int m = msm::steps_between_turns(liver, error, 1e-4);
        EXPECT_LE(moved_by(m), error);
        EXPECT_GT(moved_by(m + 1), error);
    }
    EXPECT_EQ(msm::steps_between_turns(liver, 0.0, 1e-4), 1);
    EXPECT_EQ(msm::steps_between_turns({"fast", {0.3}, {1e-6}}, 1e-3, 1e-4), 1);
}

/// Branches of a body that is stepped in other lengths of time go on as if it had been stepped in one.
TEST(FastRelaxation, GoesOnInOtherSteps) {
    const StretchedBlock block("nodal_neo_hookean_f");
    const double step = 0.05 * block.critical;
    const PronySeries series{"one", {0.6}, {200.0 * step}};
    const auto moved = [&](int every, bool changes) {
        auto steps = block.steps(series, step, every);
        steps.set_state(block.start);
        steps.take(changes ? 203 : 803); // the first ends between two moves
        if (changes) {
            steps.set_time_step(0.5 * step);
            steps.take(1200);
        }
        return steps.state().displacement;
    };
    const auto expected = moved(1, false);
    EXPECT_LT((moved(8, true) - expected).norm(), 0.02 * block.start.displacement.norm());
    EXPECT_GT((block.start.displacement - expected).norm(), 0.2 * block.start.displacement.norm());
}

TEST(FastRelaxation, StartsAnewFromAStateThatIsSetAfterALoss) {
    const PronySeries series{"one", {0.6}, {0.02}};
    for (const auto &sample : one_of_each_kind())
        for (const int every : {1, 4}) {
            const auto prepare = [&] {
                return fast_steps(
                    sample, {}, tests::sample_step,
                    {.relaxation = series, .relaxation_error = error_for(series, every, tests::sample_step)});
            };
            auto steps = prepare(), others = prepare();
            auto lost = sheared_and_turned(sample);
            lost.velocity.setConstant(std::nan(""));
            steps.set_state(lost);
            steps.take(6);
            EXPECT_FALSE(steps.state().displacement.allFinite());
            for (auto *moved : {&steps, &others}) {
                moved->set_state(sheared_and_turned(sample));
                moved->take(6);
            }
            EXPECT_EQ(steps.state().displacement, others.state().displacement) << every;
        }
}

TEST(FastRelaxation, IsLeftToOthersWhereKernelsDoNotKnowIt) {
    const auto springs = tests::tetrahedra(17, "nodal_volume");
    const auto can = [&](const char *integrator, bool may_be_cut) {
        return FastSteps::prepare(springs.body, springs.positions, springs.conditions, {}, integrator,
                                  tests::sample_step, {.may_be_cut = may_be_cut, .relaxation = {"one", {0.5}, {1.0}}})
            .has_value();
    };
    EXPECT_TRUE(can("symplectic_euler", false));
    EXPECT_FALSE(can("implicit_euler", false));
    EXPECT_FALSE(can("symplectic_euler", true));
}

} // namespace
} // namespace livermark
