#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <random>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/kernels/thread_pool.hpp"
#include "msm/springs/springs.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using msm::FastSteps;
using msm::State;
using tests::Sample;

std::vector<std::pair<std::string, Sample>> odd_samples() {
    const auto body = tests::lumpy_bar({6, 2, 2}, 20.0); // whose 63 nodes fill no slice
    auto sample = tests::loose(body);
    for (std::size_t i = 0; i < sample.positions.size(); ++i) // parts whose masses are scaled are free
        sample.conditions.displacement[i].setConstant(
            sample.positions[i].x() == 0.0 ? 0.0 : std::numeric_limits<double>::quiet_NaN());
    std::vector<std::pair<std::string, Sample>> samples;
    const auto add = [&](const std::string &name, const msm::ElasticBody &springs) {
        sample.body = springs;
        sample.body.terms.push_back(msm::inversion_guard(body));
        samples.emplace_back(name, sample);
    };
    const auto &law = msm::all_spring_laws().front();
    add(law.name, msm::ElasticBody(msm::spring_network(body, law)));
    add("with volumes",
        msm::springs_with_volume(body, msm::springs_beside_volume(body, law), msm::find_volume_term("nodal_volume"))
            .body);
    for (const auto &springs : msm::all_coupled_springs())
        if (msm::are_in_kernels(springs))
            add(springs.name, msm::coupled_springs_with_volume(body, springs));
    return samples;
}

/// So near rest that no energy is without bounds there.
State stirred(const Sample &sample) {
    auto state = tests::shaken(sample);
    state.displacement *= 0.05;
    return state;
}

/// Steps that have met what is no number, and are set to a state then.
void expect_nothing_left(const Sample &sample, const std::string &integrator, const msm::FastStepOptions &options) {
    for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 1e-4}}) {
        const auto prepare = [&] {
            return *FastSteps::prepare(sample.body, sample.positions, sample.conditions, damping, integrator,
                                       tests::sample_step, options);
        };
        auto fresh = prepare(), lost = prepare();
        const auto size = static_cast<Eigen::Index>(3 * sample.positions.size());
        const Eigen::VectorXd nothing = Eigen::VectorXd::Constant(size, std::numeric_limits<double>::quiet_NaN());
        lost.set_state({nothing, nothing});
        lost.take(3);
        for (auto *steps : {&fresh, &lost}) {
            steps->set_state(stirred(sample));
            steps->take(5);
        }
        EXPECT_TRUE(fresh.state().velocity.allFinite());
        EXPECT_EQ(lost.state().displacement, fresh.state().displacement);
        EXPECT_EQ(lost.state().velocity, fresh.state().velocity);
    }
}

TEST(FastStepsAfterALoss, KeepNothingOfItWhenAStateIsSet) {
    for (const auto &[name, sample] : odd_samples())
        for (const auto precision : tests::both_precisions)
            for (const auto &integrator : msm::all_integrators()) {
                if (!integrator.is_explicit)
                    continue;
                SCOPED_TRACE(name + " " + integrator.name);
                expect_nothing_left(sample, integrator.name, {.precision = precision});
            }
}

TEST(FastStepsAfterALoss, KeepNothingOfItInScaledMasses) {
    for (const auto &[name, sample] : odd_samples())
        for (const auto precision : tests::both_precisions) {
            SCOPED_TRACE(name);
            const auto scaling = msm::scale_masses(tests::lumpy_bar({6, 2, 2}, 20.0), sample.body, sample.conditions);
            ASSERT_EQ(scaling.parts.size(), 1U);
            expect_nothing_left(sample, "symplectic_euler", {.precision = precision, .scaling = scaling});
        }
}

/// Steps twice as long as the body bears.
TEST(FastStepsWithALimit, GoNoFasterHoweverLongStepsAre) {
    const auto sample = tests::tetrahedra(108, "nodal_volume");
    for (const auto precision : tests::both_precisions) {
        auto steps = *FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, "symplectic_euler", 0.02,
                                         {.precision = precision, .largest_speed = 0.5});
        steps.set_state(tests::shaken(sample));
        for (int s = 0; s < 200; ++s) {
            steps.take(1);
            ASSERT_LE(steps.state().velocity.lpNorm<Eigen::Infinity>(), 0.5);
        }
        EXPECT_EQ(steps.state().velocity.lpNorm<Eigen::Infinity>(), 0.5) << "without it they would go faster";
    }
}

TEST(FastStepsWithALimit, MoveAsWithoutOneWhereNobodyReachesIt) {
    const auto sample = tests::tetrahedra(108, "nodal_volume");
    for (const auto precision : tests::both_precisions) {
        const auto without = tests::by_the_kernel(sample, {}, "symplectic_euler", 10, {.precision = precision}),
                   with = tests::by_the_kernel(sample, {}, "symplectic_euler", 10,
                                               {.precision = precision, .largest_speed = 100.0});
        EXPECT_LT(without.velocity.lpNorm<Eigen::Infinity>(), 100.0);
        EXPECT_EQ(with.displacement, without.displacement);
        EXPECT_EQ(with.velocity, without.velocity);
    }
}

using msm::SpringLane;

/// A neighbour is shared if, and only if, both nodes of the lane have a spring to it, and the nodes of a lane have one
/// between them wherever there was a choice.
TEST(SpringLanes, FetchOnceWhatBothNodesOfALaneNeed) {
    std::size_t num_between = 0, num_shared = 0, num_alone = 0;
    msm::StepParts parts;
    parts.edges = core::edge_table(tests::box_mesh({0.1, 0.1, 0.1}, {5, 4, 3}).tetrahedra).edges;
    const auto lanes = msm::spring_lanes(parts, 6 * 5 * 4);
    for (const auto &lane : lanes) {
        num_between += lane.between >= 0;
        num_shared += lane.shared.size();
        num_alone += lane.alone[0].size() + lane.alone[1].size();
        EXPECT_GE(lane.alone[0].size(), lane.alone[1].size());
        for (const auto &neighbour : lane.shared)
            EXPECT_TRUE(neighbour.spring[0] >= 0 && neighbour.spring[1] >= 0);
        for (const auto &neighbour : lane.alone[0])
            EXPECT_TRUE(std::ranges::none_of(lane.alone[1], [&](const auto &n) { return n.node == neighbour.node; }));
    }
    EXPECT_GT(num_between, lanes.size() * 8 / 10);
    EXPECT_GT(2 * num_shared, num_alone); // most of the ends outside lanes
}

SpringLane lane(int num_shared, int num_first, int num_second) {
    SpringLane lane;
    lane.shared.resize(num_shared);
    lane.alone[0].resize(num_first);
    lane.alone[1].resize(num_second);
    return lane;
}

/// Whether neighbours find a line each, by the rule that fewest_lines() has.
bool fits(const SpringLane &lane, const msm::LineCounts &count) {
    const int split = std::max(0, static_cast<int>(lane.shared.size()) - count.shared);
    const int room = count.shared - static_cast<int>(lane.shared.size()) + split;
    int missing = 0;
    for (const int side : {0, 1})
        missing += std::max(0, static_cast<int>(lane.alone[side].size()) + split - count.alone[side]);
    return missing <= room;
}

/// No other counts that are enough cost less: to fetch a line as much as the forces of one.
TEST(SpringLanes, FindTheFewestLinesForLanesThatDiffer) {
    std::mt19937 random(3);
    const auto cost = [](const msm::LineCounts &c) { return c.total() + c.num_springs(); };
    for (int sample = 0; sample < 20; ++sample) {
        std::vector<SpringLane> lanes;
        for (int l = 0; l < 5; ++l) {
            const int first = static_cast<int>(random() % 6), second = static_cast<int>(random() % 6);
            lanes.push_back(lane(static_cast<int>(random() % 6), std::max(first, second), std::min(first, second)));
        }
        const auto found = msm::fewest_lines(lanes, 0, lanes.size());
        EXPECT_TRUE(std::ranges::all_of(lanes, [&](const auto &l) { return fits(l, found); }));
        for (int shared = 0; shared < 16; ++shared)
            for (int first = 0; first < 16; ++first)
                for (int second = 0; second < 16; ++second) {
                    const msm::LineCounts other{shared, {first, second}};
                    if (cost(other) < cost(found)) {
                        EXPECT_FALSE(std::ranges::all_of(lanes, [&](const auto &l) { return fits(l, other); }));
                    }
                }
    }
}

/// Fast kernels take other means for those over corners.
TEST(FastStepsBesideMeansOfVolumes, KnowThoseOverCornersAlone) {
    const auto body = tests::two_materials(108, 0.45, 0.45);
    const auto parts = msm::nodal_parts(body);
    for (const bool are_known : {true, false}) {
        auto volumes = msm::mean_volumes_around_nodes(parts, {1e4, 1e4});
        volumes.measure = msm::logarithm_of_volume;
        if (!are_known)
            volumes.mean.setIdentity();
        const msm::ElasticBody springs({}, {msm::coupled_springs(body, msm::find_coupled_springs("edge_neo_hookean")),
                                            msm::volume_penalty(body.mesh, volumes)});
        EXPECT_EQ(msm::step_parts(springs).has_value(), are_known);
    }
}

int sum_of_numbers(msm::ThreadPool &pool) {
    std::atomic<int> sum = 0;
    pool.run([&](int thread, msm::Barrier &barrier) {
        sum += thread;
        barrier.wait();
        sum += 100;
    });
    return sum;
}

class ThreadPools : public testing::TestWithParam<int> {};

TEST_P(ThreadPools, WorkInAProcessThatWasForkedBetweenTwoRuns) {
    const int size = GetParam(), expected = 100 * size + size * (size - 1) / 2;
    msm::ThreadPool pool(size);
    EXPECT_EQ(sum_of_numbers(pool), expected);
    const auto child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        alarm(60); // ends what waits for threads that are not there
        bool is_right = true;
        for (int run = 0; run < 100; ++run)
            is_right = is_right && sum_of_numbers(pool) == expected;
        { msm::ThreadPool another(size); }
        _exit(is_right ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status)) << strsignal(WTERMSIG(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_EQ(sum_of_numbers(pool), expected);
}

TEST_P(ThreadPools, EndInAProcessThatWasForkedWhileTheyRan) {
    auto pool = std::make_unique<msm::ThreadPool>(GetParam());
    std::atomic<pid_t> child = 0;
    pool->run([&](int thread, msm::Barrier &) {
        if (thread == 0)
            child = fork();
        if (child == 0 && thread == 0) { // the other threads are not there
            alarm(60);
            pool.reset();
            _exit(0);
        }
    });
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status)) << strsignal(WTERMSIG(status));
}

INSTANTIATE_TEST_SUITE_P(Sizes, ThreadPools, testing::Values(1, 2, 5));

} // namespace
} // namespace livermark

namespace livermark::msm {
namespace {

TEST(ThreadPool, DoesItsWorkOnceInEachThread) {
    ThreadPool pool(3);
    for (int round = 0; round < 100; ++round) {
        std::atomic<int> sum = 0;
        pool.run([&](int thread, Barrier &) { sum += 1 + thread; });
        ASSERT_EQ(sum, 6);
    }
}

#ifndef __SANITIZE_ADDRESS__
/// In a process of its own, whose memory is not enough for the stacks of so many.
TEST(ThreadPool, SaysWhenThereAreNoMoreThreads) {
    const pid_t child = fork();
    if (child == 0) {
        alarm(30);
        std::uint64_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        const auto room = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + (std::uint64_t{100} << 20);
        const rlimit limit{room, room};
        setrlimit(RLIMIT_AS, &limit);
        try {
            const ThreadPool pool(500);
        } catch (const std::system_error &) {
            _exit(3);
        }
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status)) << "it waited for threads that are told nothing";
    EXPECT_EQ(WEXITSTATUS(status), 3);
}
#endif

} // namespace
} // namespace livermark::msm
