// Cuts of bodies with a capsule, vessels as lines and a map of stiffness.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "meshes/cutting/cut.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/dynamics/spring_stepper.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/springs/springs.hpp"
#include "tests/samples/cut_bodies.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/springs_to_cut.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// Two materials with a map of stiffness, covered all over, with a vessel along it and another across.
core::Body covered_box() {
    auto body = tests::crooked_box({0.07, 0.06, 0.05}, {6, 5, 4});
    body.capsule = core::Capsule{.thickness = 1e-4, .young_modulus = 4e5};
    body.vessels = core::VesselTree{
        .points = {{0.002, 0.03, 0.04}, {0.068, 0.032, 0.035}, {0.03, 0.002, 0.03}, {0.031, 0.058, 0.041}},
        .radius = {2e-3, 1e-3, 1e-3, 1e-3},
        .segments = {{0, 1}, {2, 3}},
        .wall_ratio = 0.2,
        .wall_modulus = 1e6};
    std::mt19937 random(5);
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        body.modulus_factor.push_back(tests::random_value(random, 0.5, 2.0));
    return body;
}

class CutCoveredBox : public testing::TestWithParam<tests::SpringsToCut> {
  protected:
    core::Body body = covered_box();

    msm::ElasticBody springs_of(const core::Body &of) const { return msm::with_vessel_lines(GetParam().make(of), of); }
    msm::State moved_on(const core::NodalProblem &problem, msm::State state, msm::ForcePrecision precision) const;
};

TEST_P(CutCoveredBox, HasTheNumbersOfTheCutBodySetUpAnew) {
    auto now = body;
    std::set<int> removed;
    auto parts = msm::CutParts::prepare(body, springs_of(body), GetParam().source(body)).value();
    const auto remove_near = [&](double x) {
        auto near = tests::tetrahedra_near(now, {x, 0.03, 0.05}, 0.018);
        std::erase_if(near, [&](int t) { return removed.contains(t); });
        removed.insert(near.begin(), near.end());
        parts.remove(near);
        tests::expect_numbers_of_set_up(parts, GetParam(), now, removed);
    };
    const auto part_at = [&](double x) {
        parts.part(tests::part_by_blade(now, removed, {x, 0.03, 0.0}, {1.0, 0.2, 0.0}, 0.015));
        tests::expect_numbers_of_set_up(parts, GetParam(), now, removed);
    };
    remove_near(0.03);
    ASSERT_GT(removed.size(), 20U);
    part_at(0.035);
    ASSERT_GT(now.mesh.num_nodes(), body.mesh.num_nodes() + 6);
    part_at(0.055);
    remove_near(0.05);
}

/// Fixed where x is about zero, under their weight.
core::NodalProblem hanging(std::shared_ptr<const core::Body> body) {
    core::NodalProblem problem{std::move(body), {}, {}};
    const auto &points = problem.body->mesh.points;
    problem.node_mass = msm::lumped_masses(*problem.body);
    problem.conditions = msm::free_nodes(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        problem.conditions.force[i] = problem.node_mass[i] * Vector3(0.0, 0.0, -9.81);
        if (points[i].x() < 0.002)
            problem.conditions.displacement[i].setZero();
    }
    return problem;
}

constexpr double covered_step = 2e-5;
const core::RayleighDamping covered_damping{.alpha = 1.0, .beta = 1e-5};

std::unique_ptr<msm::SpringStepper> stepper_of(const tests::SpringsToCut &springs, const core::NodalProblem &problem,
                                               msm::ForcePrecision precision) {
    const auto &body = *problem.body;
    msm::MovingSprings moving{.springs = msm::with_vessel_lines(springs.make(body), body),
                              .source = springs.source(body),
                              .damping = covered_damping,
                              .options = {.precision = precision, .may_be_cut = true}};
    auto steps = std::make_unique<msm::SpringStepper>(problem.body, std::move(moving), problem.conditions);
    steps->prepare(covered_step);
    return steps;
}

void move_on(msm::SpringStepper &steps, int count) {
    for (int k = 0; k < count; ++k)
        steps.step(covered_step, 1);
}

/// Cuts that a body is given one after the other: a side goes, a blade parts, and one with a thickness takes.
std::vector<meshes::Cut> some_cuts() {
    const auto blade = [](double x, double depth, double thickness) {
        return meshes::Cut{.tool = meshes::BladeCut{.corners = {Vector3(x, -0.01, 0.06),
                                                                {x, 0.07, 0.06},
                                                                {x + 0.004, 0.07, depth},
                                                                {x + 0.004, -0.01, depth}},
                                                    .thickness = thickness}};
    };
    return {{.tool = meshes::HalfSpaceCut{{0.056, 0.0, 0.0}, {1.0, 0.0, 0.1}}},
            blade(0.02, 0.02, 0.0),
            blade(0.02, 0.01, 0.0),
            blade(0.035, 0.03, 0.004)};
}

/// Twenty steps of a body that is set up anew: in double precision those of the slow forces.
msm::State CutCoveredBox::moved_on(const core::NodalProblem &problem, msm::State state,
                                   msm::ForcePrecision precision) const {
    if (precision == msm::ForcePrecision::double_precision) {
        msm::make_stepper(springs_of(*problem.body), problem.body->mesh.points, problem.conditions, covered_damping,
                          msm::find_integrator("symplectic_euler"), covered_step, msm::StepKernel::scalar)
            .take(state, 20);
        return state;
    }
    const auto steps = stepper_of(GetParam(), problem, precision);
    steps->set_state(state);
    move_on(*steps, 20);
    return steps->state();
}

TEST_P(CutCoveredBox, MovesOnAsTheSameBodyThatWasCutAtRest) {
    using enum msm::ForcePrecision;
    for (const auto precision : {double_precision, single_precision}) {
        auto problem = hanging(std::make_shared<const core::Body>(body));
        const auto steps = stepper_of(GetParam(), problem, precision);
        msm::KeptNumbers numbers(body.mesh);
        std::mt19937 random(11);
        auto start = steps->state();
        for (int i = 0; i < body.mesh.num_nodes(); ++i)
            if (!problem.conditions.constrains(static_cast<std::size_t>(i)))
                msm::node_part(start.displacement, i) = tests::random_vector(random, 0.0006);
        steps->set_state(start);
        int num_parted = 0;
        for (const auto &cut : some_cuts()) {
            move_on(*steps, 20);
            auto result = meshes::cut(*problem.body, cut);
            problem = hanging(std::make_shared<const core::Body>(std::move(result.body)));
            num_parted +=
                static_cast<int>(numbers.follow(problem.body->mesh, result.parents.front()).parting.parent_node.size());
            steps->cut(problem, result.parents.front());
            const auto from = steps->state();
            auto own = msm::State{Eigen::VectorXd(3 * problem.body->mesh.num_nodes()),
                                  Eigen::VectorXd(3 * problem.body->mesh.num_nodes())};
            for (std::size_t i = 0; i < numbers.nodes().size(); ++i)
                for (auto field : {&msm::State::displacement, &msm::State::velocity})
                    msm::node_part(own.*field, static_cast<int>(i)) =
                        Vector3(msm::node_part(from.*field, numbers.nodes()[i]));
            move_on(*steps, 20);
            const auto is = steps->state(), should = moved_on(problem, std::move(own), precision);
            double largest = 0.0, off = 0.0;
            for (std::size_t i = 0; i < numbers.nodes().size(); ++i) {
                const Vector3 expected = msm::node_part(should.velocity, static_cast<int>(i));
                largest = std::max(largest, expected.norm());
                off = std::max(off, (msm::node_part(is.velocity, numbers.nodes()[i]) - expected).norm());
            }
            EXPECT_GT(largest, 1e-3);
            EXPECT_LT(off, (precision == double_precision ? 1e-9 : 1e-4) * largest) << numbers.nodes().size();
        }
        EXPECT_GT(num_parted, 8);
    }
}

INSTANTIATE_TEST_SUITE_P(AllSprings, CutCoveredBox, testing::ValuesIn(tests::all_springs_to_cut()),
                         tests::name_of_springs_to_cut);

/// Remains of a term beside the kernels after a cut, by the numbers that are kept.
struct CutTerm {
    std::shared_ptr<const msm::ElasticTerm> term;
    std::vector<Vector3> points; ///< at rest [m]
    tests::Rest rest;            ///< the same body by its own numbers
};

template <class MakeTerm> CutTerm cut_term(const MakeTerm &make_term, double least_z) {
    auto now = covered_box();
    const auto whole = make_term(now);
    const auto springs = msm::coupled_springs_with_volume(now, msm::find_coupled_springs("nodal_neo_hookean"));
    auto parts = msm::CutParts::prepare(now, springs, std::nullopt).value();
    const auto near = tests::tetrahedra_near(now, {0.055, 0.03, 0.05}, 0.018);
    const std::set<int> removed(near.begin(), near.end());
    parts.remove(near);
    const auto parting = tests::part_by_blade(now, removed, {0.035, 0.03, 0.0}, {1.0, 0.0, 0.0}, least_z);
    if (!parting.tetrahedra.empty())
        parts.part(parting);
    const auto at_rest = msm::to_unknowns(now.mesh.points);
    return {whole->after_cut({at_rest, parts.tetrahedra(), parts.parts().is_removed}), now.mesh.points,
            tests::without(now, removed)};
}

/// Foundation of a body at the side that cuts go into, every third facet along its normal alone.
std::shared_ptr<const msm::ElasticTerm> springs_below(const core::Body &body, double stiffness) {
    const auto &mesh = body.mesh;
    core::Foundation foundation;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[static_cast<std::size_t>(mesh.boundary_patch[f])] == "z_max") {
            // By the place, which a cut does not change.
            const double x = mesh.points[static_cast<std::size_t>(mesh.boundary_triangles[f][0])].x();
            foundation.facets.push_back(f);
            foundation.stiffness.push_back(stiffness * (1.0 + x / 0.07));
            foundation.normal_only.push_back(x < 0.025 ? 1 : 0);
        }
    return msm::foundation_springs(mesh, foundation);
}

TEST(TermsBesideKernels, AreAfterACutThoseOfTheCutBody) {
    std::mt19937 random(3);
    const auto expect_same = [&](const auto &make_term) {
        const auto [term, points, rest] = cut_term(make_term, 0.02);
        const auto expected = make_term(rest.body);
        const auto at_rest = msm::to_unknowns(points);
        Eigen::VectorXd x = at_rest, v(x.size()), own(3 * rest.body.mesh.num_nodes()), own_v(own.size());
        for (int i = 0; i < static_cast<int>(points.size()); ++i) {
            msm::node_part(x, i) += tests::random_vector(random, 0.001);
            msm::node_part(v, i) = tests::random_vector(random, 0.1);
            if (const int number = rest.number[i]; number >= 0) {
                msm::node_part(own, number) = Vector3(msm::node_part(x, i));
                msm::node_part(own_v, number) = Vector3(msm::node_part(v, i));
            }
        }
        const double energy = expected->energy(own);
        EXPECT_GT(energy, 1e-6);
        EXPECT_NEAR(term->energy(x), energy, 1e-12 * energy);
        EXPECT_LT(std::abs(term->energy(at_rest)), 1e-12 * energy);
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size()), own_force = Eigen::VectorXd::Zero(own.size());
        term->add_force(x, v, 1e-3, force);
        expected->add_force(own, own_v, 1e-3, own_force);
        for (int i = 0; i < static_cast<int>(points.size()); ++i) {
            const Vector3 should =
                rest.number[i] < 0 ? Vector3::Zero() : Vector3(msm::node_part(own_force, rest.number[i]));
            EXPECT_LT((msm::node_part(force, i) - should).norm(), 1e-12 * own_force.norm()) << i;
        }
    };
    expect_same(msm::coupled_capsule);
    expect_same(msm::vessel_lines);
    expect_same([](const core::Body &body) { return springs_below(body, 1e5); });
}

TEST(TermsBesideKernels, AreThemselvesWhereNothingIsCut) {
    const auto body = covered_box();
    const auto at_rest = msm::to_unknowns(body.mesh.points);
    Eigen::VectorXd x = at_rest;
    std::mt19937 random(4);
    for (int i = 0; i < body.mesh.num_nodes(); ++i)
        msm::node_part(x, i) += tests::random_vector(random, 0.001);
    const std::vector<char> is_removed(body.mesh.tetrahedra.size(), 0);
    for (const auto &term : {msm::coupled_capsule(body), msm::vessel_lines(body), springs_below(body, 1e5)}) {
        const auto left = term->after_cut({at_rest, body.mesh.tetrahedra, is_removed});
        EXPECT_GT(term->energy(x), 1e-6);
        EXPECT_EQ(left->energy(x), term->energy(x));
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size()), force_left = force;
        term->add_force(x, at_rest, 1e-3, force);
        left->add_force(x, at_rest, 1e-3, force_left);
        EXPECT_EQ(force_left, force);
    }
}

/// A part has the springs below its own facets.
TEST(TermsBesideKernels, AreInAPartThoseOfTheWholeBody) {
    const auto body = covered_box();
    const auto whole = springs_below(body, 1e5);
    const auto near = tests::tetrahedra_near(body, {0.055, 0.03, 0.05}, 0.025);
    std::vector<char> is_in(body.mesh.tetrahedra.size(), 0);
    for (const int t : near)
        is_in[t] = 1;
    const auto part = msm::part_of_body(body, is_in, hanging(std::make_shared<const core::Body>(body)).conditions);
    EXPECT_EQ(part.tetrahedron, near);
    const auto term = msm::term_of_part(*whole, part, is_in.size());
    std::vector<char> is_out;
    for (const char in : is_in)
        is_out.push_back(in == 0 ? 1 : 0);
    const auto at_rest = msm::to_unknowns(body.mesh.points);
    const auto left = whole->after_cut({at_rest, body.mesh.tetrahedra, is_out});
    std::mt19937 random(4);
    Eigen::VectorXd x = msm::to_unknowns(part.body.mesh.points), all = at_rest;
    for (int i = 0; i < static_cast<int>(part.node.size()); ++i) {
        msm::node_part(x, i) += tests::random_vector(random, 0.001);
        msm::node_part(all, part.node[i]) = Vector3(msm::node_part(x, i));
    }
    EXPECT_GT(term->energy(x), 1e-6);
    EXPECT_EQ(term->energy(x), left->energy(all));
    EXPECT_LT(term->hessian(x, msm::Tangent::exact).diagonal().sum(),
              0.9 * whole->hessian(all, msm::Tangent::exact).diagonal().sum());
}

/// A capsule and vessels that are cut through bear nothing between the two parts of a body.
TEST(TermsBesideKernels, FreeTheEndsOfWhatIsCutThrough) {
    const auto expect_free = [](const auto &make_term) {
        const auto [term, points, rest] = cut_term(make_term, -1.0);
        const auto [uncut, points_before, rest_before] = cut_term(make_term, 1.0);
        ASSERT_GT(points.size(), points_before.size());
        // Each node moves with its part: the one where x is large.
        const auto owners = [&] {
            std::vector<char> moves(points.size(), 0);
            for (const auto &nodes : rest.body.mesh.tetrahedra) {
                Vector3 middle = Vector3::Zero();
                for (const int node : nodes)
                    middle += 0.25 * rest.body.mesh.points[node];
                for (const int node : nodes)
                    if (middle.x() > 0.035)
                        moves[std::ranges::find(rest.number, node) - rest.number.begin()] = 1;
            }
            return moves;
        }();
        const auto pulled_apart = [&](std::size_t num_nodes) {
            auto x = points;
            x.resize(num_nodes);
            for (std::size_t i = 0; i < num_nodes; ++i)
                x[i].x() += owners[i] != 0 ? 0.005 : 0.0;
            return msm::to_unknowns(x);
        };
        const auto force_of = [](const msm::ElasticTerm &of, const Eigen::VectorXd &x) {
            Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
            of.add_force(x, Eigen::VectorXd::Zero(x.size()), 0.0, force);
            return force.norm();
        };
        const double before = force_of(*uncut, pulled_apart(points_before.size()));
        EXPECT_GT(before, 0.01);
        EXPECT_LT(force_of(*term, pulled_apart(points.size())), 1e-10 * before);
    };
    expect_free(msm::coupled_capsule);
    expect_free(msm::vessel_lines);
}

/// Highest frequency after a cut, around it and before it.
struct Frequencies {
    double around, before, after; // [rad/s]
};

/// @param below  what bears a body, or nothing
Frequencies
frequencies_of_a_cut(const core::Body &body,
                     const std::function<std::shared_ptr<const msm::ElasticTerm>(const core::Body &)> &below) {
    constexpr double tolerance = 1e-6;
    const auto make = [](const core::Body &of, const std::shared_ptr<const msm::ElasticTerm> &on) {
        auto springs = msm::with_vessel_lines(
            msm::coupled_springs_with_volume(of, msm::find_coupled_springs("nodal_neo_hookean")), of);
        if (on)
            springs.add(on);
        return springs;
    };
    const auto near = tests::tetrahedra_near(body, {0.045, 0.03, 0.05}, 0.014);
    std::vector<char> is_removed(body.mesh.tetrahedra.size(), 0);
    std::set<int> nodes;
    for (const int t : near) {
        is_removed[t] = 1;
        nodes.insert(body.mesh.tetrahedra[t].begin(), body.mesh.tetrahedra[t].end());
    }
    const auto highest = [&](const core::Body &of) {
        return msm::largest_angular_frequency(make(of, below(of)), of.mesh.points,
                                              hanging(std::make_shared<const core::Body>(of)).conditions, {},
                                              tolerance);
    };
    const auto whole = below(body);
    const double around = msm::frequency_around(
        body, is_removed, std::vector<int>(nodes.begin(), nodes.end()),
        [&](const msm::PartOfBody &part) {
            return make(part.body, whole ? msm::term_of_part(*whole, part, is_removed.size()) : nullptr);
        },
        hanging(std::make_shared<const core::Body>(body)).conditions, tolerance);
    return {around, highest(body), highest(tests::without(body, {near.begin(), near.end()}).body)};
}

TEST(FrequencyAround, TellsThatOfTheCutBodyWithItsCapsuleAndVessels) {
    const auto [around, before, after] =
        frequencies_of_a_cut(covered_box(), [](const core::Body & /*body*/) { return nullptr; });
    EXPECT_LT(around, after * (1.0 + 1e-4));
    EXPECT_GT(std::max(around, before), 0.99 * after);
}

/// On springs that are so stiff that the highest frequency is theirs.
TEST(FrequencyAround, TellsThatOfTheCutBodyOnAFoundation) {
    const auto below = [](const core::Body &body) { return springs_below(body, 1e9); };
    const auto [around, before, after] = frequencies_of_a_cut(covered_box(), below);
    const auto without = frequencies_of_a_cut(covered_box(), [](const core::Body & /*body*/) { return nullptr; });
    EXPECT_GT(around, 3.0 * without.around);
    EXPECT_GT(after, 3.0 * without.after);
    EXPECT_LT(around, after * (1.0 + 1e-4));
    EXPECT_GT(std::max(around, before), 0.99 * after);
}

} // namespace
} // namespace livermark
