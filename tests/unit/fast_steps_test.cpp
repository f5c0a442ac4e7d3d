#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <limits>
#include <random>

#include "msm/elastic_motion.hpp"
#include "msm/integrator.hpp"
#include "msm/inversion_guard.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/nodal_springs.hpp"
#include "msm/spring_network.hpp"
#include "msm/volume_term.hpp"
#include "tests/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using msm::FastSteps;
using msm::ForcePrecision;
using msm::State;

constexpr double step = 1e-4;

/// Point masses, where they are, and what is done to them.
struct Sample {
    msm::ElasticBody body{{}, {}};
    std::vector<Vector3> positions;
    msm::NodalConditions conditions;
};

double random_value(std::mt19937 &random, double lowest, double highest) {
    return std::uniform_real_distribution<double>(lowest, highest)(random);
}

Vector3 random_vector(std::mt19937 &random, double largest) {
    return {random_value(random, -largest, largest), random_value(random, -largest, largest),
            random_value(random, -largest, largest)};
}

/// Every fifth node is held, half of these in one direction only; the others bear loads.
msm::NodalConditions some_conditions(std::size_t num_nodes, std::mt19937 &random) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    msm::NodalConditions conditions;
    conditions.displacement.assign(num_nodes, Vector3::Constant(nan));
    conditions.constraint.assign(num_nodes, {-1, -1, -1});
    conditions.force.assign(num_nodes, Vector3::Zero());
    for (std::size_t i = 0; i < num_nodes; ++i)
        if (i % 5 != 2)
            conditions.force[i] = random_vector(random, 0.01);
        else if (i % 2 == 0)
            conditions.displacement[i].setZero();
        else
            conditions.displacement[i].y() = 0.0;
    return conditions;
}

/// Springs between nodes at random places, each with its neighbours in number and with some others.
Sample random_springs(int num_nodes) {
    std::mt19937 random(num_nodes);
    Sample sample;
    core::SpringNetwork springs;
    for (int i = 0; i < num_nodes; ++i) {
        sample.positions.emplace_back(random_vector(random, 0.1));
        springs.node_mass.push_back(random_value(random, 0.001, 0.003));
        for (int j = 0; j < i; ++j)
            if (i - j < 3 || random() % 50 == 0) {
                springs.edges.push_back({j, i});
                springs.rest_length.push_back((sample.positions[i] - sample.positions[j]).norm());
                springs.stiffness.push_back(random_value(random, 10.0, 100.0));
            }
    }
    sample.body = springs;
    sample.conditions = some_conditions(sample.positions.size(), random);
    return sample;
}

/// The first tetrahedra of a box of two materials.
core::Body two_materials(int num_tetrahedra, double soft_ratio, double hard_ratio) {
    auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {3, 3, 2});
    mesh.tetrahedra.resize(num_tetrahedra);
    mesh.region_names = {"soft", "hard"};
    mesh.region.assign(num_tetrahedra, 0);
    for (int t = 0; t < num_tetrahedra; ++t)
        mesh.region[t] = mesh.points[mesh.tetrahedra[t][0]].x() < 0.04 ? 0 : 1;
    return {.name = "two", .mesh = mesh, .materials = {{1060.0, 5e3, soft_ratio}, {1060.0, 2e4, hard_ratio}}};
}

/// A body with nothing that holds it together yet.
Sample loose(const core::Body &body) {
    Sample sample;
    sample.positions = body.mesh.points;
    std::mt19937 random(static_cast<unsigned>(body.mesh.num_tetrahedra()));
    sample.conditions = some_conditions(sample.positions.size(), random);
    sample.body.node_mass.assign(sample.positions.size(), 0.002); // nodes of no tetrahedron would have none
    return sample;
}

/// Tetrahedra with springs, a volume term if one is named, and the guard.
Sample tetrahedra(int num_tetrahedra, const std::string &volume_term) {
    const auto body = two_materials(num_tetrahedra, 0.4, 0.45);
    auto sample = loose(body);
    sample.body.terms = msm::ElasticBody(msm::spring_network(body, msm::all_spring_laws().front())).terms;
    for (const auto &term : msm::all_volume_terms())
        if (term.name == volume_term)
            sample.body.terms.push_back(term.make(body, {7e3, 2e4}));
    sample.body.terms.push_back(msm::inversion_guard(body));
    return sample;
}

/// Tetrahedra with springs that are coupled around nodes and the guard, and with means of the volume around nodes where
/// they have another Poisson's ratio than springs.
Sample coupled_tetrahedra(int num_tetrahedra, double soft_ratio, double hard_ratio) {
    const auto body = two_materials(num_tetrahedra, soft_ratio, hard_ratio);
    auto sample = loose(body);
    sample.body.terms = msm::nodal_springs_with_volume(body).terms;
    return sample;
}

/// So far from rest that some tetrahedra are inverted; held components stand still.
State shaken(const Sample &sample) {
    std::mt19937 random(5);
    const auto size = static_cast<Eigen::Index>(3 * sample.positions.size());
    State state{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
    for (std::size_t i = 0; i < sample.positions.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (std::isnan(sample.conditions.displacement[i][c])) {
                state.displacement[static_cast<Eigen::Index>(3 * i) + c] = random_value(random, -0.01, 0.01);
                state.velocity[static_cast<Eigen::Index>(3 * i) + c] = random_value(random, -0.5, 0.5);
            }
    return state;
}

State by_the_oracle(const Sample &sample, const core::RayleighDamping &damping, const std::string &integrator,
                    int num_steps) {
    const auto equation = msm::elastic_motion(sample.body, sample.positions, sample.conditions, damping);
    const auto take_step = msm::find_integrator(integrator).prepare(equation, step);
    auto state = shaken(sample);
    for (int s = 0; s < num_steps; ++s)
        take_step(state);
    return state;
}

State by_the_kernel(const Sample &sample, const core::RayleighDamping &damping, const std::string &integrator,
                    int num_steps, const msm::FastStepOptions &options) {
    auto steps =
        FastSteps::prepare(sample.body, sample.positions, sample.conditions, damping, integrator, step, options);
    EXPECT_TRUE(steps.has_value());
    steps->set_state(shaken(sample));
    steps->take(num_steps);
    return steps->state();
}

/// Largest difference of velocities and displacements, as parts of the largest changes that the steps have made.
double error(const State &found, const State &expected, const Sample &sample) {
    const auto start = shaken(sample);
    const auto part = [](const Eigen::VectorXd &difference, const Eigen::VectorXd &change) {
        const double largest = difference.lpNorm<Eigen::Infinity>();
        return largest > 0.0 ? largest / change.lpNorm<Eigen::Infinity>() : 0.0;
    };
    return std::max(part(found.velocity - expected.velocity, expected.velocity - start.velocity),
                    part(found.displacement - expected.displacement, expected.displacement - start.displacement));
}

double tolerance(ForcePrecision precision) {
    return precision == ForcePrecision::double_precision ? 1e-12 : 1e-5;
}

constexpr auto both_precisions = {ForcePrecision::single_precision, ForcePrecision::double_precision};

/// A vector unit that this machine has and this binary was built for.
class EveryVectorUnit : public testing::TestWithParam<int64_t> {
  protected:
    EveryVectorUnit() { choose(GetParam()); }
    ~EveryVectorUnit() override { choose(0); }

  private:
    /// Nought stands for the best one.
    static void choose(int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
};

TEST_P(EveryVectorUnit, MovesAnyNumberOfNodesAsTheOracleDoes) {
    for (const int num_nodes : {0, 1, 2, 3, 5, 7, 8, 9, 15, 16, 17, 31, 32, 33, 300})
        for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}})
            for (const auto precision : both_precisions) {
                SCOPED_TRACE(num_nodes);
                const auto sample = random_springs(num_nodes);
                const auto expected = by_the_oracle(sample, damping, "symplectic_euler", 3);
                const auto found = by_the_kernel(sample, damping, "symplectic_euler", 3, {.precision = precision});
                if (num_nodes > 0) {
                    EXPECT_LT(error(found, expected, sample), tolerance(precision));
                }
            }
}

TEST_P(EveryVectorUnit, MovesAnyNumberOfTetrahedraAsTheOracleDoes) {
    for (const int count : {1, 2, 15, 16, 17, 33, 108})
        for (const auto *term : {"", "mean_nodal_volume", "nodal_volume", "tetrahedral_volume"})
            for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}})
                for (const auto precision : both_precisions) {
                    SCOPED_TRACE(testing::Message() << count << " " << term);
                    const auto sample = tetrahedra(count, term);
                    const auto expected = by_the_oracle(sample, damping, "symplectic_euler", 3);
                    const auto found = by_the_kernel(sample, damping, "symplectic_euler", 3, {.precision = precision});
                    EXPECT_LT(error(found, expected, sample), tolerance(precision));
                }
}

TEST_P(EveryVectorUnit, MovesSpringsThatAreCoupledAroundNodesAsTheOracleDoes) {
    for (const int count : {1, 2, 15, 16, 17, 33, 108})
        for (const auto &[soft_ratio, hard_ratio] :
             {std::pair(0.25, 0.25), std::pair(0.45, 0.45), std::pair(0.25, 0.4)})
            for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}})
                for (const auto precision : both_precisions) {
                    SCOPED_TRACE(testing::Message() << count << " " << soft_ratio << " " << hard_ratio);
                    const auto sample = coupled_tetrahedra(count, soft_ratio, hard_ratio);
                    const auto expected = by_the_oracle(sample, damping, "symplectic_euler", 3);
                    const auto found = by_the_kernel(sample, damping, "symplectic_euler", 3, {.precision = precision});
                    EXPECT_LT(error(found, expected, sample), tolerance(precision));
                }
}

TEST_P(EveryVectorUnit, KnowsEveryExplicitIntegrator) {
    const auto sample = tetrahedra(108, "nodal_volume");
    for (const auto &integrator : msm::all_integrators()) {
        if (!integrator.is_explicit)
            continue;
        for (const auto precision : both_precisions) {
            SCOPED_TRACE(integrator.name);
            const core::RayleighDamping damping{3.0, 0.002};
            const auto expected = by_the_oracle(sample, damping, integrator.name, 4);
            const auto found = by_the_kernel(sample, damping, integrator.name, 4, {.precision = precision});
            EXPECT_LT(error(found, expected, sample), tolerance(precision));
        }
    }
}

TEST_P(EveryVectorUnit, GivesTheSameForAnyNumberOfThreads) {
    for (const auto &sample : {tetrahedra(108, "nodal_volume"), coupled_tetrahedra(108, 0.4, 0.45)})
        for (const auto precision : both_precisions) {
            const auto one = by_the_kernel(sample, {3.0, 0.002}, "runge_kutta_4", 10, {precision, 1});
            for (const int num_threads : {2, 3, 7, 20}) {
                const auto many = by_the_kernel(sample, {3.0, 0.002}, "runge_kutta_4", 10, {precision, num_threads});
                EXPECT_EQ(one.displacement, many.displacement) << num_threads;
                EXPECT_EQ(one.velocity, many.velocity) << num_threads;
            }
        }
}

INSTANTIATE_TEST_SUITE_P(FastSteps, EveryVectorUnit, testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto &info) { return std::string(hwy::TargetName(info.param)); });

TEST(FastSteps, GoOnWhereTheyStopped) {
    const auto sample = tetrahedra(108, "nodal_volume");
    const core::RayleighDamping damping{3.0, 0.002};
    auto steps = FastSteps::prepare(sample.body, sample.positions, sample.conditions, damping, "velocity_verlet", step);
    ASSERT_TRUE(steps.has_value());
    steps->set_state(shaken(sample));
    for (int s = 0; s < 5; ++s)
        steps->take(1);
    EXPECT_EQ(steps->state().velocity, by_the_kernel(sample, damping, "velocity_verlet", 5, {}).velocity);
}

/// A spring is kept at both ends with 12 bytes each, and slices are filled up with few that are none.
TEST(FastSteps, NeedLittleMemoryForASpring) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {12, 12, 12});
    const auto body = tests::make_body(mesh, {1060.0, 5e3, 0.25});
    const auto springs = msm::spring_network(*body, msm::all_spring_laws().front());
    msm::NodalConditions conditions;
    conditions.displacement.assign(mesh.points.size(), Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    conditions.force.assign(mesh.points.size(), Vector3::Zero());
    const auto steps = FastSteps::prepare(springs, mesh.points, conditions, {}, "symplectic_euler", step);
    constexpr double node_bytes = 2 * 24 + 12 + 2 * 16; // position and velocity, inverse mass, two rows
    const double of_nodes = node_bytes * (static_cast<double>(mesh.points.size()) + 32.0);
    EXPECT_LT((static_cast<double>(steps->working_set()) - of_nodes) / static_cast<double>(springs.edges.size()), 30.0);
}

TEST(FastSteps, AreNotThereForImplicitIntegrators) {
    const auto sample = random_springs(5);
    EXPECT_FALSE(
        FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, "implicit_euler", step).has_value());
}

} // namespace
} // namespace livermark
