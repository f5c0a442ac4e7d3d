#include "msm/cutting/cut_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <set>

#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/springs_with_volume.hpp"
#include "tests/samples/cut_bodies.hpp"
#include "tests/samples/moving_samples.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// Springs that a body may have.
struct Springs {
    std::string name;
    std::function<msm::ElasticBody(const core::Body &)> make;
    std::function<std::optional<msm::SpringSource>(const core::Body &)> source;
};

std::vector<Springs> all_springs() {
    std::vector<Springs> all;
    const auto add = [&](const msm::SpringLaw &law, const std::string &volume) {
        all.push_back({law.name + " with " + volume,
                       [=](const core::Body &body) {
                           return msm::springs_with_volume(body, msm::springs_beside_volume(body, law),
                                                           msm::find_volume_term(volume))
                               .body;
                       },
                       [=](const core::Body &body) {
                           msm::SpringSource source{law, body};
                           for (auto &material : source.body.materials)
                               material = {material.density, 2.5 * material.shear_modulus(), 0.25};
                           return source;
                       }});
    };
    for (const auto &law : msm::all_spring_laws())
        add(law, "nodal_volume");
    add(msm::all_spring_laws().front(), "tetrahedral_volume");
    for (const auto &coupled : msm::all_coupled_springs())
        if (msm::are_in_kernels(coupled))
            all.push_back({coupled.name,
                           [=](const core::Body &body) { return msm::coupled_springs_with_volume(body, coupled); },
                           [](const core::Body &) { return std::nullopt; }});
    return all;
}

class CutParts : public testing::TestWithParam<Springs> {
  protected:
    core::Body body = tests::crooked_box({0.07, 0.06, 0.05}, {6, 5, 4});
    msm::ElasticBody elastic = GetParam().make(body);
    msm::CutParts parts = msm::CutParts::prepare(body, elastic, GetParam().source(body)).value();
    std::set<int> removed;

    std::vector<int> next_cut(double x, double distance) {
        auto near = tests::tetrahedra_near(body, {x, 0.03, 0.05}, distance);
        std::erase_if(near, [&](int t) { return removed.contains(t); });
        removed.insert(near.begin(), near.end());
        return near;
    }
};

TEST_P(CutParts, HaveTheNumbersOfTheCutBodySetUpAnew) {
    parts.remove(next_cut(0.03, 0.018));
    parts.remove(next_cut(0.045, 0.02));
    ASSERT_GT(removed.size(), 60U);
    const auto [rest, number] = tests::without(body, removed);
    const auto elastic_of_rest = GetParam().make(rest);
    const auto anew = msm::step_parts(elastic_of_rest).value();
    const auto &now = parts.parts();
    for (std::size_t i = 0; i < number.size(); ++i)
        EXPECT_EQ(parts.node_mass()[i], number[i] < 0 ? 0.0 : elastic_of_rest.node_mass[number[i]]) << i;
    std::map<std::array<int, 2>, std::size_t> spring;
    for (std::size_t s = 0; s < anew.edges.size(); ++s)
        spring[anew.edges[s]] = s;
    std::size_t num_springs = 0;
    for (std::size_t s = 0; s < now.edges.size(); ++s) {
        const auto [i, j] = now.edges[s];
        const auto found = spring.find({number[i], number[j]});
        EXPECT_EQ(now.stiffness[s], found == spring.end() ? 0.0 : anew.stiffness[found->second]) << s;
        num_springs += found != spring.end();
    }
    EXPECT_EQ(num_springs, anew.edges.size());
    std::size_t t_anew = 0;
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t) {
        EXPECT_EQ(now.is_there(t), !removed.contains(t)) << t;
        if (removed.contains(t))
            continue;
        for (std::size_t k = 0; k < 4 && !anew.corner_volume.empty(); ++k) {
            const int c = now.corner_volume[t][k], d = anew.corner_volume[t_anew][k];
            if (!anew.volume_stiffness.empty()) {
                EXPECT_EQ(now.volume_stiffness[c], anew.volume_stiffness[d]) << c;
            }
            if (!anew.coupled_modulus.empty()) {
                EXPECT_EQ(now.coupled_modulus[c], anew.coupled_modulus[d]) << c;
            }
        }
        for (std::size_t e = 0; e < 6 && !anew.edge_part.empty(); ++e)
            EXPECT_EQ(now.edge_modulus[now.edge_part[t][e]], anew.edge_modulus[anew.edge_part[t_anew][e]]) << t;
        ++t_anew;
    }
    EXPECT_EQ(t_anew, anew.tetrahedra.size());
}

template <class T> void expect_equal(const msm::SlicedBody<T> &is, const msm::SlicedBody<T> &should) {
    EXPECT_EQ(is.spring, should.spring);
    EXPECT_EQ(is.neighbour, should.neighbour);
    EXPECT_EQ(is.corner, should.corner);
    EXPECT_EQ(is.force_slot, should.force_slot);
    EXPECT_EQ(is.rest_volume, should.rest_volume);
    EXPECT_EQ(is.volume_share, should.volume_share);
    EXPECT_EQ(is.tetrahedron_stiffness, should.tetrahedron_stiffness);
    EXPECT_EQ(is.least_volume, should.least_volume);
    EXPECT_EQ(is.guard_stiffness, should.guard_stiffness);
    EXPECT_EQ(is.rest_gradient, should.rest_gradient);
    EXPECT_EQ(is.inner_modulus, should.inner_modulus);
    EXPECT_EQ(is.volume_modulus, should.volume_modulus);
    EXPECT_EQ(is.coupled_modulus, should.coupled_modulus);
    EXPECT_EQ(is.inverse_volume, should.inverse_volume);
    EXPECT_EQ(is.volume_stiffness, should.volume_stiffness);
    EXPECT_EQ(is.mean_start, should.mean_start);
    EXPECT_EQ(is.mean_node, should.mean_node);
    EXPECT_EQ(is.mean_gradient, should.mean_gradient);
    EXPECT_EQ(is.mean_volume, should.mean_volume);
    EXPECT_EQ(is.mean_weight, should.mean_weight);
    EXPECT_EQ(is.star_start, should.star_start);
    EXPECT_EQ(is.star_corner, should.star_corner);
    EXPECT_EQ(is.star_slot, should.star_slot);
    EXPECT_EQ(is.star_tetrahedron, should.star_tetrahedron);
    EXPECT_EQ(is.star_modulus, should.star_modulus);
    EXPECT_EQ(is.star_inverse_volume, should.star_inverse_volume);
    EXPECT_EQ(is.star_stiffness, should.star_stiffness);
    EXPECT_EQ(is.sum, should.sum);
    EXPECT_EQ(is.member, should.member);
    EXPECT_EQ(is.longest_star, should.longest_star);
}

TEST_P(CutParts, AreSlicedAsBySlicingAllAgain) {
    const auto &points = body.mesh.points;
    const auto check = [&]<class T>(T /*precision*/) {
        removed.clear();
        parts = msm::CutParts::prepare(body, elastic, GetParam().source(body)).value();
        msm::SlicedPlan plan;
        auto sliced = msm::sliced_body<T>(parts.parts(), points, &plan);
        for (const double x : {0.03, 0.05, 0.01}) {
            const auto &changes = parts.remove(next_cut(x, 0.02));
            ASSERT_FALSE(changes.nodes.empty());
            msm::update_sliced_body(parts.parts(), changes, plan, sliced);
            expect_equal(sliced, msm::sliced_body<T>(parts.parts(), points));
        }
    };
    check(float());
    check(double());
}

/// Steps that go on after a cut, and those of the cut body from the same state.
TEST_P(CutParts, MoveAsTheCutBodySetUpAnew) {
    msm::NodalConditions conditions;
    std::mt19937 random(11);
    conditions = tests::some_conditions(body.mesh.points.size(), random);
    for (const double beta : {0.0, 1e-5}) {
        removed.clear();
        parts = msm::CutParts::prepare(body, elastic, GetParam().source(body)).value();
        constexpr double step = 2e-5;
        const core::RayleighDamping damping{.alpha = 1.0, .beta = beta};
        auto steps = msm::FastSteps::prepare(elastic, body.mesh.points, conditions, damping, "symplectic_euler", step,
                                             {.precision = msm::ForcePrecision::double_precision, .may_be_cut = true});
        ASSERT_TRUE(steps);
        msm::State state = steps->state();
        for (int i = 0; i < static_cast<int>(body.mesh.points.size()); ++i)
            if (conditions.displacement[i].array().isNaN().all())
                msm::of_node(state.displacement, i) = tests::random_vector(random, 0.0004);
        steps->set_state(state);
        steps->take(20);
        for (const double x : {0.03, 0.05}) {
            const auto &changes = parts.remove(next_cut(x, 0.02));
            EXPECT_TRUE(steps->cut(parts.parts(), parts.node_mass(), changes));
        }
        const auto [rest, number] = tests::without(body, removed);
        msm::NodalConditions of_rest;
        const auto before = steps->state();
        msm::State start{Eigen::VectorXd(3 * rest.mesh.num_nodes()), Eigen::VectorXd(3 * rest.mesh.num_nodes())};
        for (std::size_t i = 0; i < number.size(); ++i)
            if (number[i] >= 0) {
                of_rest.displacement.push_back(conditions.displacement[i]);
                of_rest.force.push_back(conditions.force[i]);
                msm::of_node(start.displacement, number[i]) = msm::of_node(before.displacement, static_cast<int>(i));
                msm::of_node(start.velocity, number[i]) = msm::of_node(before.velocity, static_cast<int>(i));
            }
        auto anew =
            msm::FastSteps::prepare(GetParam().make(rest), rest.mesh.points, of_rest, damping, "symplectic_euler", step,
                                    {.precision = msm::ForcePrecision::double_precision});
        anew->set_state(start);
        steps->take(30);
        anew->take(30);
        const auto is = steps->state(), should = anew->state();
        double largest = 0.0, difference = 0.0;
        for (std::size_t i = 0; i < number.size(); ++i) {
            const Vector3 velocity = msm::of_node(is.velocity, static_cast<int>(i));
            if (number[i] < 0) {
                EXPECT_EQ(velocity, Vector3::Zero()) << i;
                EXPECT_EQ(Vector3(msm::of_node(is.displacement, static_cast<int>(i))),
                          Vector3(msm::of_node(before.displacement, static_cast<int>(i))))
                    << i;
                continue;
            }
            const Vector3 expected = msm::of_node(should.velocity, number[i]);
            largest = std::max(largest, expected.norm());
            difference = std::max(difference, (velocity - expected).norm());
        }
        EXPECT_GT(largest, 1e-3);
        EXPECT_LT(difference, 1e-9 * largest) << beta;
    }
}

std::string name_of_springs(const testing::TestParamInfo<Springs> &info) {
    std::string name = info.param.name;
    std::ranges::replace(name, ' ', '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(AllSprings, CutParts, testing::ValuesIn(all_springs()), name_of_springs);

} // namespace
} // namespace livermark
