#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "msm/dynamics/histories.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/relaxation.hpp"
#include "msm/springs/springs.hpp"
#include "tests/oracles/relaxing_steps.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
constexpr double free_component = std::numeric_limits<double>::quiet_NaN();
constexpr double side = 0.1;

/// A standard linear solid.
const core::PronySeries one_branch{"one", {0.6}, {2.0}};
const core::PronySeries two_branches{"two", {0.3, 0.25}, {0.4, 5.0}};

core::SlowHistory history_of(const core::PronySeries &series, int steps, double step, double rise,
                             double (*factor)(double)) {
    core::SlowHistory history{.relaxation = series, .times = {0.0}, .factors = {0.0}};
    if (rise > 0.0) {
        history.times.push_back(rise);
        history.factors.push_back(factor(0.0));
    }
    for (int k = 1; k <= steps; ++k) {
        history.times.push_back(rise + k * step);
        history.factors.push_back(factor(k * step));
    }
    return history;
}

double held(double /*time*/) {
    return 1.0;
}
double waving(double time) {
    return std::pow(std::sin(2.0 * time), 2);
}

/// A cube that three sides hold so that it stays a brick, and the fourth pulls.
struct Cube {
    explicit Cube(core::Regime regime = core::Regime::small) {
        body = tests::make_body(tests::box_mesh({side, side, side}, {2, 2, 2}), {1060.0, 5e3, 0.4});
        load_case = tests::empty_load_case(body->mesh);
        load_case.regime = regime;
        tests::prescribe(load_case, body->mesh, "x_min", {0.0, free_component, free_component});
        tests::prescribe(load_case, body->mesh, "y_min", {free_component, 0.0, free_component});
        tests::prescribe(load_case, body->mesh, "z_min", {free_component, free_component, 0.0});
    }
    msm::ElasticBody springs() const { return msm::spring_network(*body, msm::all_spring_laws().front()); }
    msm::ElasticBody coupled(const std::string &name) const {
        return msm::coupled_springs_with_volume(*body, msm::find_coupled_springs(name));
    }
    msm::FollowedHistory follow(const msm::ElasticBody &elastic, const core::SlowHistory &history) const {
        auto problem = core::Problem{body, load_case};
        problem.load_case.slow_history = history;
        auto followed = msm::follow_history(elastic, problem, elastic.node_mass);
        EXPECT_EQ(followed.end.status, core::SolutionStatus::ok) << followed.end.message;
        EXPECT_EQ(followed.points.size(), history.times.size());
        return followed;
    }
    /// Along x in the mean over the side that is pulled.
    double elongation(const core::PathPoint &point) const {
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = 0; i < body->mesh.points.size(); ++i)
            if (body->mesh.points[i].x() > side - 1e-9) {
                sum += static_cast<double>(point.displacement[i].x());
                ++count;
            }
        return sum / count;
    }

    std::shared_ptr<const core::Body> body;
    core::LoadCase load_case;
};

double fading(const core::PronySeries &series, double time) {
    double left = series.remaining();
    for (std::size_t k = 0; k < series.moduli.size(); ++k)
        left += series.moduli[k] * std::exp(-time / series.times[k]);
    return left;
}

/// Growth of a strain under a stress that is held, of one branch: J(t) / J(0).
double creep(double modulus, double time_constant, double time) {
    const double left = 1.0 - modulus;
    return (1.0 - modulus * std::exp(-left * time / time_constant)) / left;
}

constexpr double jump = 1e-9; ///< [s], in which loads rise

TEST(SlowHistory, SpringsThatAreHeldRelaxAsTheSeriesSays) {
    for (const auto regime : {core::Regime::small, core::Regime::large}) {
        Cube cube(regime);
        tests::prescribe(cube.load_case, cube.body->mesh, "x_max", {0.01, free_component, free_component});
        const auto followed = cube.follow(cube.springs(), history_of(two_branches, 12, 0.5, jump, held));
        const double first = followed.points[1].reaction.back().x();
        EXPECT_GT(std::abs(first), 0.1);
        for (int k = 0; k <= 12; ++k)
            EXPECT_NEAR(followed.points[static_cast<std::size_t>(k + 1)].reaction.back().x(),
                        first * fading(two_branches, 0.5 * k), 2e-8 * std::abs(first));
    }
}

/// Under a stretch that grows evenly the force is the integral of the series, for any length of the steps.
TEST(SlowHistory, ForceOfAnEvenStretchIsExactInEveryStep) {
    Cube cube;
    tests::prescribe(cube.load_case, cube.body->mesh, "x_max", {0.01, free_component, free_component});
    const auto elastic = cube.follow(cube.springs(), history_of({}, 1, 1.0, jump, held)).points.back().reaction.back();
    for (const int steps : {1, 7}) {
        const auto history = history_of(two_branches, steps, 3.0 / steps, 0.0, [](double time) { return time / 3.0; });
        double expected = two_branches.remaining() * 3.0;
        for (std::size_t b = 0; b < 2; ++b)
            expected -= two_branches.moduli[b] * two_branches.times[b] * std::expm1(-3.0 / two_branches.times[b]);
        const auto followed = cube.follow(cube.springs(), history);
        EXPECT_NEAR(followed.points.back().reaction.back().x(), elastic.x() * expected / 3.0,
                    1e-9 * std::abs(elastic.x()));
    }
}

/// A lattice of springs keeps its Poisson's ratio, so all of it is one standard linear solid.
TEST(SlowHistory, LatticeCreepsAsAStandardLinearSolidOfSecondOrderInTheStep) {
    Cube cube;
    tests::pull(cube.load_case, cube.body->mesh, "x_max", {5.0, 0.0, 0.0});
    const double time = 4.0;
    std::vector<double> error;
    for (const int steps : {8, 16}) {
        const auto points = cube.follow(cube.springs(), history_of(one_branch, steps, time / steps, jump, held)).points;
        error.push_back(cube.elongation(points.back()) / cube.elongation(points[1]) - creep(0.6, 2.0, time));
    }
    EXPECT_LT(std::abs(error[1]), 1e-3);
    EXPECT_NEAR(error[0] / error[1], 4.0, 0.2);
}

/// Under one stress along x the strain is sigma (1 / (9 K) + 1 / (3 G)), and only G relaxes.
TEST(SlowHistory, CoupledSpringsCreepInShapeAlone) {
    const auto material = core::Material{1060.0, 5e3, 0.4};
    const double g = material.shear_modulus(), k = material.lame_lambda() + 2.0 / 3.0 * g, stress = 5.0;
    for (const auto *const name : {"nodal_springs", "edge_neo_hookean", "nodal_neo_hookean_f"})
        for (const auto regime : {core::Regime::small, core::Regime::large}) {
            Cube cube(regime);
            tests::pull(cube.load_case, cube.body->mesh, "x_max", {stress, 0.0, 0.0});
            const int steps = regime == core::Regime::small ? 64 : 16;
            const auto points =
                cube.follow(cube.coupled(name), history_of(one_branch, steps, 4.0 / steps, jump, held)).points;
            const auto expected = [&](double time) {
                return side * stress * (1.0 / (9.0 * k) + creep(0.6, 2.0, time) / (3.0 * g));
            };
            // What is left of the step, and where it is large of the strain of 0.003.
            const double tolerance = regime == core::Regime::small ? 1e-4 : 6e-3;
            EXPECT_NEAR(cube.elongation(points[1]), expected(0.0), tolerance * expected(0.0)) << name;
            EXPECT_NEAR(cube.elongation(points.back()), expected(4.0), tolerance * expected(4.0)) << name;
            EXPECT_GT(expected(4.0), 1.5 * expected(0.0));
        }
}

TEST(SlowHistory, TimesOfZeroAndInfinityAreTheElasticLimits) {
    for (const auto regime : {core::Regime::small, core::Regime::large}) {
        Cube cube(regime);
        tests::pull(cube.load_case, cube.body->mesh, "x_max", {50.0, 30.0, 0.0});
        const auto body = cube.coupled("nodal_neo_hookean");
        const auto elongation_with = [&](const core::PronySeries &series, const msm::ElasticBody &of) {
            return cube.elongation(
                cube.follow(of, history_of(series, 2, 1.0, 0.0, [](double time) { return 0.5 * time; })).points.back());
        };
        const double at_once = elongation_with({}, body), at_last = elongation_with({}, msm::relaxed(body, 0.4));
        EXPECT_GT(at_last, 1.3 * at_once);
        EXPECT_NEAR(elongation_with({"never", {0.6}, {1e12}}, body), at_once, 1e-6 * at_once);
        EXPECT_NEAR(elongation_with({"at once", {0.6}, {1e-12}}, body), at_last, 1e-6 * at_last);
    }
}

/// Work that comes in is stored or has become heat, but for the error of the steps, and heat is never taken back.
TEST(SlowHistory, BalancesItsEnergyAndNeverCreatesAny) {
    for (const auto regime : {core::Regime::small, core::Regime::large})
        for (const bool is_pressed : {false, true}) {
            Cube cube(regime);
            if (is_pressed)
                tests::press(cube.load_case, cube.body->mesh, "x_max", {-1.0, 0.0, 0.0}, 0.004);
            else
                tests::pull(cube.load_case, cube.body->mesh, "x_max", {60.0, 20.0, 0.0});
            const auto followed =
                cube.follow(cube.coupled("nodal_springs"), history_of(two_branches, 40, 0.05, 0.0, waving));
            double heat = 0.0, most_stored = 0.0;
            for (const auto &point : followed.points) {
                EXPECT_GE(point.dissipated_energy, heat);
                heat = point.dissipated_energy;
                most_stored = std::max(most_stored, point.strain_energy);
                EXPECT_NEAR(point.work, point.strain_energy + heat, 0.01 * most_stored);
            }
            EXPECT_GT(heat, 0.1 * most_stored);
        }
}

/// At depth 0 the body still pushes or pulls what pressed it: the force is the multiplier of the depth there, too.
TEST(SlowHistory, PressesAlsoWhereTheDepthReturnsToZero) {
    Cube cube;
    tests::press(cube.load_case, cube.body->mesh, "x_max", {-1.0, 0.0, 0.0}, 0.004);
    const auto springs = cube.springs();
    auto history = history_of(one_branch, 2, 1.0, 0.0, [](double time) { return time == 1.0 ? 1.0 : 0.0; });
    const auto points = cube.follow(springs, history).points;
    EXPECT_LT(cube.elongation(points[1]), -0.003);
    EXPECT_NEAR(cube.elongation(points[2]), 0.0, 1e-8);
    const double down = points[1].reaction.back().x(), up = points[2].reaction.back().x();
    // h(n+1) = exp(-x) h(n) + gain (s(n+1) - s(n)) with x = 1 / 2
    const double fade = std::exp(-0.5), gain = 0.6 * (1.0 - fade) / 0.5;
    EXPECT_LT(down, -0.01);
    EXPECT_NEAR(up / down, (fade * gain - gain) / (0.4 + gain), 1e-6);
}

/// Loads so small that nothing is nonlinear.
TEST(SlowHistory, LargeRegimeIsTheSmallOneAtSmallLoads) {
    std::vector<msm::FollowedHistory> both;
    for (const auto regime : {core::Regime::small, core::Regime::large}) {
        Cube cube(regime);
        tests::pull(cube.load_case, cube.body->mesh, "x_max", {2e-2, 4e-2, -2e-2});
        both.push_back(cube.follow(cube.coupled("nodal_neo_hookean"), history_of(two_branches, 6, 0.3, 0.0, waving)));
    }
    ASSERT_EQ(both[0].points.size(), both[1].points.size());
    for (std::size_t k = 1; k < both[0].points.size(); ++k) {
        const auto &small = both[0].points[k], &large = both[1].points[k];
        double difference = 0.0, size = 0.0;
        for (std::size_t i = 0; i < small.displacement.size(); ++i) {
            difference += (small.displacement[i] - large.displacement[i]).squaredNorm();
            size += small.displacement[i].squaredNorm();
        }
        EXPECT_LT(difference, 1e-8 * size);
        EXPECT_NEAR(small.strain_energy, large.strain_energy, 1e-4 * small.strain_energy);
        EXPECT_NEAR(small.dissipated_energy, large.dissipated_energy, 1e-4 * small.dissipated_energy);
        EXPECT_NEAR(small.work, large.work, 1e-4 * small.work);
    }
}

TEST(SlowHistory, IsOfSecondOrderInTheStepAtLargeStrains) {
    Cube cube(core::Regime::large);
    tests::pull(cube.load_case, cube.body->mesh, "x_max", {900.0, 0.0, 0.0});
    const auto body = cube.coupled("nodal_neo_hookean");
    const auto elongation_in = [&](int steps) {
        return cube.elongation(
            cube.follow(body, history_of(one_branch, steps, 4.0 / steps, 0.0,
                                         [](double time) { return 0.5 * time < 1.0 ? 0.5 * time : 1.0; }))
                .points.back());
    };
    const double first = elongation_in(4), second = elongation_in(8), third = elongation_in(16);
    EXPECT_GT(third, 0.2 * side);
    EXPECT_NEAR((first - second) / (second - third), 4.0, 0.8);
}

TEST(SlowHistory, GivesTheFieldsOfTheLastRecordOfTheWholeLoad) {
    Cube cube;
    tests::pull(cube.load_case, cube.body->mesh, "x_max", {60.0, 20.0, 0.0});
    auto history = history_of(one_branch, 3, 1.0, 0.0, held);
    history.times.push_back(4.0);
    history.factors.push_back(0.5);
    const auto followed = cube.follow(cube.springs(), history);
    const auto &whole = followed.points[3];
    for (std::size_t i = 0; i < whole.displacement.size(); ++i)
        EXPECT_EQ(whole.displacement[i], followed.end.displacement[i].cast<float>());
    EXPECT_EQ(followed.stored_energy, whole.strain_energy);
}

using msm::State;

/// One mass on one spring along x.
struct OneMass {
    static constexpr double stiffness = 50.0, mass = 0.02, length = 0.1, start = 0.01;
    std::vector<Vector3> positions{Vector3::Zero(), Vector3(length, 0.0, 0.0)};
    core::SpringNetwork springs{
        .node_mass = {mass, mass}, .edges = {{0, 1}}, .stiffness = {stiffness}, .rest_length = {length}};
    msm::NodalConditions conditions{
        .displacement = {Vector3::Zero(), Vector3(std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0)},
        .constraint = {},
        .force = {Vector3::Zero(), Vector3::Zero()}};

    /// Its place after it was pulled at once and let go.
    double moved(const core::PronySeries &series, double time, int num_steps) const {
        const double step = time / num_steps;
        State state{Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)};
        state.displacement[3] = start;
        state.velocity[3] = 0.5 * step * stiffness / mass * start; // half a step before
        msm::RelaxingBody body(springs, series);
        body.go_on(msm::to_unknowns(positions) + state.displacement, 0.0);
        tests::RelaxingSteps steps(std::move(body), positions, conditions, {}, step);
        steps.take(state, num_steps);
        return state.displacement[3];
    }

    /// The same in steps of an integrator that hold branches in between.
    double moved_with(const char *integrator, const core::PronySeries &series, double time, int num_steps,
                      int num_held) const {
        State state{Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)};
        state.displacement[3] = start;
        msm::HeldSteps steps(springs, series, positions, conditions, {}, msm::find_integrator(integrator),
                             time / num_steps, num_held);
        steps.take(state, num_steps);
        return state.displacement[3];
    }

    /// The same of (x, v, h_1, ...)' = A (x, v, h_1, ...): with one branch an equation of third order in x.
    static double exact(const core::PronySeries &series, double time) {
        const auto size = static_cast<Eigen::Index>(2 + series.moduli.size());
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
        Eigen::VectorXd at(size);
        matrix(0, 1) = 1.0;
        matrix(1, 0) = -series.remaining() * stiffness / mass;
        at[0] = start, at[1] = 0.0;
        for (Eigen::Index b = 2; b < size; ++b) {
            const double modulus = series.moduli[static_cast<std::size_t>(b - 2)];
            matrix(1, b) = -1.0 / mass;
            matrix(b, 1) = modulus * stiffness;
            matrix(b, b) = -1.0 / series.times[static_cast<std::size_t>(b - 2)];
            at[b] = modulus * stiffness * start;
        }
        const Eigen::EigenSolver<Eigen::MatrixXd> eigen(matrix);
        const Eigen::VectorXcd parts = eigen.eigenvectors().partialPivLu().solve(at.cast<std::complex<double>>());
        const Eigen::VectorXcd grown = (eigen.eigenvalues() * time).array().exp() * parts.array();
        return (eigen.eigenvectors() * grown)[0].real();
    }
};

TEST(RelaxingSteps, MoveAMassAsItsEquationOfThirdOrderSaysAndOfSecondOrderInTheStep) {
    const OneMass one; // 0.126 s is a period
    for (const auto &series :
         {core::PronySeries{"fast", {0.5}, {0.004}}, core::PronySeries{"like", {0.5}, {0.05}},
          core::PronySeries{"slow", {0.5}, {3.0}}, core::PronySeries{"two", {0.3, 0.4}, {0.02, 0.3}}}) {
        const double time = 0.21, expected = OneMass::exact(series, time);
        const double coarse = one.moved(series, time, 200) - expected, fine = one.moved(series, time, 400) - expected;
        EXPECT_LT(std::abs(fine), 2e-3 * OneMass::start) << series.name;
        EXPECT_NEAR(coarse / fine, 4.0, 0.1) << series.name;
    }
}

TEST(HeldSteps, MoveAMassAsItsEquationSaysAndOfSecondOrderInTheTimeThatBranchesAreHeld) {
    const OneMass one;
    const double time = 0.21;
    for (const auto &series :
         {core::PronySeries{"like", {0.5}, {0.05}}, core::PronySeries{"two", {0.3, 0.4}, {0.02, 0.3}}})
        for (const auto *integrator : {"runge_kutta_4", "velocity_verlet"})
            for (const int num_held : {1, 4}) {
                // The last steps end in the middle of what they hold branches for.
                const int steps = 400 + num_held / 2, twice = 2 * steps;
                const double expected = OneMass::exact(series, time);
                const double coarse = one.moved_with(integrator, series, time, steps, num_held) - expected;
                const double fine = one.moved_with(integrator, series, time, twice, num_held) - expected;
                EXPECT_LT(std::abs(fine), 2e-3 * OneMass::start) << integrator << " " << num_held << series.name;
                EXPECT_NEAR(coarse / fine, 4.0, num_held == 1 ? 0.2 : 1.0) << integrator << " " << num_held;
            }
}

/// A block that is held on one side, pushed at random.
struct PushedBlock {
    PushedBlock() {
        auto load_case = tests::empty_load_case(body->mesh);
        tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
        conditions = msm::nodal_conditions({body, load_case}, elastic.node_mass);
        critical = 2.0 / msm::largest_angular_frequency(elastic, points(), conditions);
        std::mt19937 random(5);
        state = {Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(points().size())), {}};
        for (std::size_t i = 0; i < points().size(); ++i)
            for (int c = 0; c < 3; ++c)
                if (std::isnan(conditions.displacement[i][c]))
                    state.displacement[3 * static_cast<Eigen::Index>(i) + c] = 1e-7 * (random() / 2147483648.0 - 1.0);
        state.velocity = Eigen::VectorXd::Zero(state.displacement.size());
    }
    const std::vector<Vector3> &points() const { return body->mesh.points; }
    tests::RelaxingSteps steps(const core::PronySeries &series, double step) const {
        msm::RelaxingBody relaxing(elastic, series);
        relaxing.go_on(msm::to_unknowns(points()) + state.displacement, 0.0);
        return {std::move(relaxing), points(), conditions, {}, step};
    }

    std::shared_ptr<const core::Body> body =
        tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {2, 1, 1}), {1060.0, 5e3, 0.4});
    msm::ElasticBody elastic = msm::coupled_springs_with_volume(*body, msm::find_coupled_springs("nodal_neo_hookean"));
    msm::NodalConditions conditions;
    double critical = 0.0; ///< step without branches [s]
    State state;
};

TEST(RelaxingSteps, AreStableWhereElasticOnesAreHoweverShortTheTimes) {
    const PushedBlock block;
    const auto grown = [&](double time_constant, double step, int num_steps) {
        auto steps = block.steps({"one", {0.7}, {time_constant}}, step);
        auto state = block.state;
        steps.take(state, num_steps);
        return state.displacement.norm() / block.state.displacement.norm();
    };
    EXPECT_GT(grown(1e12, 1.03 * block.critical, 20), 50.0); // nothing relaxes in time
    for (const double ratio : {1e-9, 0.1, 1.0, 10.0, 1e6})
        EXPECT_LT(grown(ratio * block.critical, 0.995 * block.critical, 400), 20.0) << ratio;
}

TEST(RelaxingSteps, LoseExactlyWhatBecomesHeat) {
    const PushedBlock block;
    const double step = 0.05 * block.critical;
    auto steps = block.steps({"two", {0.3, 0.3}, {3.0 * block.critical, 40.0 * block.critical}}, step);
    const auto equation = msm::elastic_motion(block.elastic, block.points(), block.conditions, {});
    const auto rest = msm::to_unknowns(block.points());
    auto state = block.state;
    const double start = steps.body().stored_energy(rest + state.displacement);
    double heat = 0.0;
    for (int s = 0; s < 400; ++s) {
        // Velocities stand half a step before positions: those of both neighbours make the one there.
        auto next = state;
        steps.take(next, 1);
        EXPECT_GE(steps.body().dissipated_energy(), heat);
        heat = steps.body().dissipated_energy();
        auto after = next;
        tests::RelaxingSteps copy = steps;
        copy.take(after, 1);
        const State middle{next.displacement, 0.5 * (next.velocity + after.velocity)};
        EXPECT_NEAR(msm::kinetic_energy(equation, middle) + steps.body().stored_energy(rest + next.displacement) + heat,
                    start, 0.01 * start);
        state = next;
    }
    EXPECT_GT(heat, 0.1 * start);
}

} // namespace
} // namespace livermark
