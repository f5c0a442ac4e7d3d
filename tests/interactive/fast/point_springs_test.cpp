// A capsule and vessels as springs beside the elements of every method.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/elements/point_springs.hpp"
#include "interactive/equilibrium.hpp"
#include "interactive/method.hpp"
#include "msm/springs/springs.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/equilibria.hpp"
#include "tests/oracles/slow_methods.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/even_foundation.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;
using interactive::Scene;
using tests::noise;
using tests::turned;

const Vector3 sides_of_bar{0.06, 0.03, 0.03};

/// A trunk through a bar, and a branch that leaves it.
const core::VesselTree veins{
    .points = {{-0.005, 0.012, 0.013}, {0.03, 0.016, 0.017}, {0.065, 0.02, 0.014}, {0.04, 0.02, 0.04}},
    .radius = {3e-3, 3e-3, 2e-3, 2e-3},
    .segments = {{0, 1}, {1, 2}, {1, 3}},
    .wall_ratio = 0.2,
    .wall_modulus = 4e5};

Scene with_body(Scene scene, std::shared_ptr<const core::Body> body) {
    scene.body = std::move(body);
    return scene;
}

Scene with_vessels(const Scene &scene) {
    return with_body(scene, tests::vessels::with_vessels(scene.body, veins));
}

Scene with_both(const Scene &scene) {
    return with_body(scene, tests::covered::with_capsule(with_vessels(scene).body));
}

Scene uneven_with_both(bool is_constrained) {
    return with_both(tests::uneven_scene({5, 3, 3}, is_constrained, 5.0));
}

double energy_of_springs(const std::vector<interactive::PointSpring> &springs, const Field &x) {
    return interactive::PointSpringEnergy(springs).value(x);
}

/// Over every method of the table.
struct SpringsBesideElements : testing::TestWithParam<std::string> {
    const interactive::Method &fast = interactive::find_method(GetParam());
    const interactive::Method slow = tests::slow_method(GetParam());
};

/// Derivatives where tubes are pulled and pressed.
TEST_P(SpringsBesideElements, HaveDerivativesOfTheirEnergyAsForcesAndStiffness) {
    const auto simulation = fast.prepare(uneven_with_both(false));
    const auto &energy = simulation->energy();
    const Field x = turned(simulation->positions()) + noise(simulation->positions().cols(), 4e-4, 1);
    interactive::Energy::Triplets triplets;
    energy.add_hessian(x, false, triplets);
    Field forces = Field::Zero(3, x.cols());
    energy.add_forces(x, forces);
    for (unsigned seed = 2; seed < 4; ++seed) {
        const Field way = noise(x.cols(), 1e-7, seed);
        const double change = energy.value(x + 10.0 * way) - energy.value(x - 10.0 * way);
        EXPECT_NEAR(change, -20.0 * forces.cwiseProduct(way).sum(), 1e-5 * std::abs(change));
        Field difference = Field::Zero(3, x.cols()), product = difference;
        energy.add_forces(x - way, difference);
        difference *= -1.0;
        energy.add_forces(x + way, difference);
        for (const auto &entry : triplets)
            product.data()[entry.row()] -= 2.0 * entry.value() * way.data()[entry.col()];
        EXPECT_LT((difference - product).norm(), 1e-5 * product.norm());
    }
}

/// Another code has vessels in linear elements.
TEST_P(SpringsBesideElements, StoreWhatVesselsInSpringsStore) {
    const auto scene = tests::uneven_scene({5, 3, 3}, false);
    const auto without = fast.prepare(scene), with = fast.prepare(with_vessels(scene));
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + tests::covered::some_strain();
    const Field corners = interactive::rest_positions(scene);
    Field x = f * with->positions(), on_corners = f * corners;
    if (with->scene().own_nodes.empty()) {
        on_corners += noise(corners.cols(), 5e-4, 1);
        x = on_corners;
    }
    const double expected = msm::vessel_lines(*with->scene().body)
                                ->energy(Eigen::Map<const Eigen::VectorXd>(on_corners.data(), on_corners.size()));
    EXPECT_NEAR(with->energy().value(x) - without->energy().value(x), expected, 1e-8 * expected);
    EXPECT_GT(expected, 0.01 * without->energy().value(x));
}

TEST_P(SpringsBesideElements, LeaveABodyAtRest) {
    const auto simulation = fast.prepare(uneven_with_both(true));
    const Field rest = simulation->positions();
    for (int i = 0; i < 5; ++i)
        simulation->step(2e-3, fast.is_explicit ? 40 : 10);
    const bool is_position_based = GetParam().starts_with("xpbd");
    EXPECT_LE((simulation->positions() - rest).cwiseAbs().maxCoeff(), is_position_based ? 1e-7 : 0.0);
}

/// Steps of a frame, and iterations of each: as many explicit ones as are stable.
std::pair<int, int> effort_of_frame(const interactive::Method &method, const interactive::Simulation &simulation) {
    if (!method.is_explicit)
        return {7, 10};
    return {1, static_cast<int>(std::ceil(interactive::frame_time / (0.8 * simulation.critical_time_step())))};
}

/// A centimetre in ten frames, with external forces.
Field dragged_with_tool(interactive::Simulation &simulation, const std::pair<int, int> &effort, int frames = 10) {
    const auto [steps, iterations] = effort;
    const Field start = simulation.targets();
    simulation.set_external_forces(Vector3(1e-3, 0.0, -4e-3).replicate(1, simulation.scene().body->mesh.num_nodes()));
    simulation.set_state(simulation.positions(), noise(simulation.positions().cols(), 0.02, 5));
    for (int step = 1; step <= frames * steps; ++step) {
        simulation.set_targets(start.colwise() + step / (10.0 * steps) * Vector3(2e-3, 4e-3, -1e-2));
        simulation.step(interactive::frame_time / steps, iterations);
    }
    return simulation.positions();
}

TEST_P(SpringsBesideElements, MoveOnVectorsAsInDoublePrecision) {
    for (const bool is_constrained : {true, false}) {
        const auto scene = uneven_with_both(is_constrained);
        const auto single = fast.prepare(scene), in_double = slow.prepare(scene);
        const Field rest = single->positions();
        const auto effort = effort_of_frame(fast, *single);
        const Field expected = dragged_with_tool(*in_double, effort);
        const double distance = (dragged_with_tool(*single, effort) - expected).norm() / (expected - rest).norm();
        EXPECT_LT(distance, GetParam().starts_with("xpbd") ? 8e-4 : 1e-4) << is_constrained;
        EXPECT_GT(distance, 0.0) << "both are the same code";
        EXPECT_GT((expected - rest).norm(), 0.05);
    }
}

TEST_P(SpringsBesideElements, MoveToTheSameBitsOnAnyVectorsThatMultiplyAndAddAtOnce) {
    const auto scene = uneven_with_both(true);
    const auto end_on = [&](std::int64_t target) {
        const tests::ChosenVectorUnit unit(target);
        const auto simulation = fast.prepare(scene);
        return dragged_with_tool(*simulation, fast.is_explicit ? std::pair(1, 300) : std::pair(2, 5), 2);
    };
    const Field expected = end_on(0);
    for (const auto target : hwy::SupportedAndGeneratedTargets())
        if ((target & (HWY_SCALAR | HWY_SSSE3 | HWY_SSE4)) == 0) {
            EXPECT_EQ(end_on(target), expected) << hwy::TargetName(target);
        }
}

Scene bar_with_both() {
    return with_both(tests::bar_scene(true, 0.45, 5.0));
}

/// A bar that has moved and moves.
std::unique_ptr<interactive::Simulation> moving_with_both(const interactive::Method &method) {
    auto simulation = method.prepare(bar_with_both());
    const Eigen::Index n = simulation->positions().cols();
    Field away = noise(n, 2e-4, 2);
    const auto is_free = interactive::free_nodes(simulation->scene());
    for (Eigen::Index i = 0; i < n; ++i)
        if (!is_free[i])
            away.col(i).setZero();
    simulation->set_state(simulation->positions() + away, 100.0 * away);
    simulation->set_external_forces(noise(n, 5e-3, 3));
    return simulation;
}

/// Steps come to what has the forces of the energy, however a method finds it.
TEST_P(SpringsBesideElements, TakeTheStepOfTheirEnergy) {
    const auto simulation = moving_with_both(slow);
    const Eigen::Index n = simulation->positions().cols();
    if (fast.is_explicit) {
        const auto on_vectors = moving_with_both(fast);
        on_vectors->set_state(on_vectors->positions(), Field::Zero(3, n));
        Field forces = on_vectors->elastic_forces() + on_vectors->external_forces();
        const double h = 1e-5;
        on_vectors->step(h, 1);
        for (const int node : on_vectors->scene().constrained_nodes)
            forces.col(node).setZero();
        for (const auto &follower : on_vectors->scene().followers)
            forces.col(follower.node).setZero();
        const auto &mass = on_vectors->scene().node_mass;
        const Field found = (1.0 + 2.5 * h) / h * on_vectors->velocities() *
                            Eigen::Map<const Eigen::VectorXd>(mass.data(), n).asDiagonal();
        EXPECT_LT((found - forces).norm(), 1e-5 * forces.norm());
        return;
    }
    if (GetParam().starts_with("xpbd")) { // gradients of constraints turn on the way
        simulation->step(1e-3, 5000);
        Field forces = Field::Zero(3, n);
        simulation->energy().add_forces(simulation->positions(), forces);
        EXPECT_LT((simulation->elastic_forces() - forces).norm(), 1e-6 * forces.norm());
        return;
    }
    if (GetParam() == "corotational_implicit") { // is linearised
        const auto pulled = slow.prepare(bar_with_both());
        pulled->set_external_forces(Vector3(2e-3, 0.0, -8e-3).replicate(1, n));
        const auto expected = tests::equilibrium(*pulled);
        ASSERT_TRUE(expected.converged);
        const Field rest = pulled->positions();
        EXPECT_TRUE(tests::settle(*pulled, 0.1, 300, 1e-10, 500).converged);
        EXPECT_LT((pulled->positions() - expected.positions).norm(), 1e-6 * (expected.positions - rest).norm());
        return;
    }
    const auto expected = tests::backward_euler(*simulation, 5e-3);
    ASSERT_TRUE(expected.converged);
    const Field predicted = interactive::inertia(*simulation, 5e-3).predicted;
    simulation->step(5e-3, 1500);
    EXPECT_LT((simulation->positions() - expected.positions).norm(), 1e-6 * (expected.positions - predicted).norm());
}

/// A bar of 30 mm that stands on springs while its top is pushed by 20 um: without Poisson's ratio its stress is the
/// same everywhere, E (top - u) / L = k u. Springs alone have their own Poisson's ratio.
TEST_P(SpringsBesideElements, StandOnAFoundationAsABarDoes) {
    constexpr double stiffness = 2e5, young_modulus = 5000.0, top = -2e-5;
    auto scene = tests::scene_of(tests::soft_bar(0.0), false, 0.0);
    const auto &mesh = scene.body->mesh;
    for (int i = 0; i < mesh.num_nodes(); ++i)
        if (mesh.points[i].z() > sides_of_bar.z() - 1e-9)
            scene.constrained_nodes.push_back(i);
    const auto simulation = fast.prepare(scene);
    std::vector<int> bottom;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == "z_min")
            bottom.push_back(f);
    simulation->set_targets(simulation->targets().colwise() + Vector3(0.0, 0.0, top));
    const bool is_of_springs = GetParam() == "fast_mass_spring" || GetParam() == "xpbd_springs";
    const double area = sides_of_bar.x() * sides_of_bar.y(), elastic = young_modulus / sides_of_bar.z();
    for (const bool normal_only : {true, false}) {
        const auto foundation = tests::even_foundation(bottom, stiffness, normal_only);
        const auto rest = interactive::equilibria(*simulation, {1.0}, 1e-9, 0.0, &foundation).back();
        ASSERT_TRUE(rest.converged);
        const Field moved = rest.positions - interactive::rest_positions(simulation->scene());
        const auto held = interactive::reactions_to(simulation->scene(), rest.elastic_forces);
        if (is_of_springs) { // what pushes is borne
            EXPECT_LT(held.row(2).sum(), 0.1 * area * elastic * top);
            continue;
        }
        const double expected = top * elastic / (elastic + stiffness);
        for (Eigen::Index i = 0; i < moved.cols(); ++i) {
            if (rest.positions(2, i) < 1e-3) {
                EXPECT_NEAR(moved(2, i), expected, 1e-3 * std::abs(expected));
            }
        }
        EXPECT_NEAR(held.row(2).sum(), area * stiffness * expected, 1e-3 * area * stiffness * std::abs(expected));
        const double whole = 0.5 * area * stiffness * expected * top, body = whole * (top - expected) / top;
        const interactive::OnFoundation standing(simulation->energy(), simulation->scene(), foundation);
        EXPECT_NEAR(standing.value(rest.positions), whole, 2e-3 * whole);
        EXPECT_NEAR(simulation->energy().value(rest.positions), body, 2e-3 * body);
    }
}

INSTANTIATE_TEST_SUITE_P(All, SpringsBesideElements, testing::ValuesIn(tests::method_names()),
                         [](const auto &of) { return of.param; });

/// A tube along a bar whose ends are held and moved: both have one strain, and the force is that of both sections.
struct TubeAlongABar : testing::TestWithParam<std::string> {};

TEST_P(TubeAlongABar, PullsWithTheStiffnessOfBoth) {
    const auto tube = tests::vessels::rod({-0.01, 0.0143, 0.0161}, {0.07, 0.0143, 0.0161}, 4e-3, 2e5);
    auto scene = tests::bar_scene(true, 0.0);
    scene.body = tests::vessels::with_vessels(scene.body, tube);
    for (int i = 0; i < scene.body->mesh.num_nodes(); ++i)
        if (scene.body->mesh.points[i].x() > sides_of_bar.x() - 1e-9)
            scene.constrained_nodes.push_back(i);
    const auto force = [&](double strain) {
        const auto simulation = interactive::find_method(GetParam()).prepare(scene);
        Field targets = simulation->targets();
        targets.row(0) *= 1.0 + strain;
        simulation->set_targets(targets);
        const auto state = tests::equilibrium(*simulation);
        EXPECT_TRUE(state.converged);
        const Field reactions = interactive::reactions_to(simulation->scene(), state.elastic_forces);
        double sum = 0.0;
        for (Eigen::Index c = 0; c < targets.cols(); ++c)
            if (targets(0, c) > 0.5 * sides_of_bar.x())
                sum += reactions(0, c);
        return sum;
    };
    constexpr double strain = 1e-4;
    const double found = (force(strain) - force(-strain)) / (2.0 * strain);
    const double bar_stiffness = 5000.0 * sides_of_bar.y() * sides_of_bar.z(),
                 tube_stiffness = tube.axial_stiffness(0, 5000.0);
    EXPECT_GT(tube_stiffness, bar_stiffness);
    EXPECT_NEAR(found, bar_stiffness + tube_stiffness, 1e-5 * found);
}

INSTANTIATE_TEST_SUITE_P(All, TubeAlongABar, testing::ValuesIn(tests::method_names([](const auto &method) {
                             return method.name != "xpbd_springs" && method.name != "fast_mass_spring"; // have no E
                         })),
                         [](const auto &of) { return of.param; });

TEST(CapsuleEdges, StoreInQuadraticElementsWhatTheyStoreInLinearOnesWhereAllStrainsAreTheSame) {
    const auto scene = with_both(tests::bar_scene(false));
    const auto quadratic = interactive::quadratic_scene(scene);
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + tests::covered::some_strain();
    const Field linear_x = f * interactive::rest_positions(scene),
                quadratic_x = f * interactive::rest_positions(quadratic);
    const double expected = energy_of_springs(interactive::capsule_edges(scene), linear_x);
    EXPECT_GT(expected, 0.0);
    EXPECT_NEAR(energy_of_springs(interactive::capsule_edges(quadratic), quadratic_x), expected, 1e-9 * expected);
}

TEST(VesselFibres, StoreTheEnergyOfTheClosedFormWhereAllStrainsAreTheSame) {
    const auto scene = with_both(tests::bar_scene(false));
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + tests::covered::some_strain();
    const double expected = tests::vessels::energy(*scene.body, sides_of_bar, f);
    for (const auto &of : {scene, interactive::quadratic_scene(scene)})
        EXPECT_NEAR(energy_of_springs(interactive::vessel_fibres(of), f * interactive::rest_positions(of)), expected,
                    1e-4 * expected);
}

/// Methods of springs on edges have the capsule in these.
TEST(CapsuleEdges, AreWhatEdgesOfSpringsAreStifferBy) {
    const auto bare = tests::uneven_scene({5, 3, 3}, false), covered = with_both(bare);
    const Field x = interactive::rest_positions(bare) + noise(bare.body->mesh.num_nodes(), 1e-3, 4);
    const auto on_edges = [&](const Scene &scene) {
        return interactive::SpringEnergy(interactive::springs_with_shear_modulus(*scene.body)).value(x);
    };
    const double expected = on_edges(covered) - on_edges(bare);
    EXPECT_GT(expected, 0.0);
    EXPECT_NEAR(energy_of_springs(interactive::capsule_edges(covered), x), expected, 1e-9 * on_edges(covered));
}

TEST(PointSprings, AreNoneWhereABodyHasNoCapsuleAndNoVesselsOrTheseAreAsSoftAsIt) {
    const auto bare = tests::bar_scene(false);
    EXPECT_TRUE(interactive::capsule_and_vessels(bare).empty());
    auto soft = veins;
    soft.wall_modulus = 1.0;
    EXPECT_TRUE(interactive::vessel_fibres(with_body(bare, tests::vessels::with_vessels(bare.body, soft))).empty());
}

/// A cut takes away half of a bar, and opens its capsule there.
TEST(PointSprings, GoWithTheirElementsInACut) {
    const auto scene = uneven_with_both(false);
    const auto &all = scene.body->mesh;
    auto left = *scene.body;
    left.mesh.tetrahedra.clear();
    left.mesh.region.clear();
    for (std::size_t t = 0; t < all.tetrahedra.size(); ++t) {
        double sum = 0.0;
        for (const int node : all.tetrahedra[t])
            sum += 0.25 * all.points[node].x();
        if (sum > 0.5 * sides_of_bar.x())
            continue;
        left.mesh.tetrahedra.push_back(all.tetrahedra[t]);
        left.mesh.region.push_back(all.region[t]);
    }
    const auto is_left = [&](const auto &spring) {
        return std::ranges::any_of(left.mesh.tetrahedra, [&](const auto &tetrahedron) {
            return std::ranges::all_of(
                spring.nodes, [&](int node) { return std::ranges::find(tetrahedron, node) != tetrahedron.end(); });
        });
    };
    const auto sorted = [](std::array<int, 3> nodes) {
        std::ranges::sort(nodes);
        return nodes;
    };
    left.mesh.patch_names = {"surface", std::string(core::wound_patch)};
    left.mesh.boundary_triangles = core::outer_faces(left.mesh.tetrahedra);
    left.mesh.boundary_patch.clear();
    int num_covered = 0;
    for (const auto &nodes : left.mesh.boundary_triangles) {
        const bool was_outside = std::ranges::any_of(all.boundary_triangles,
                                                     [&](const auto &other) { return sorted(other) == sorted(nodes); });
        num_covered += was_outside ? 1 : 0;
        left.mesh.boundary_patch.push_back(was_outside ? 0 : 1);
    }
    ASSERT_LT(num_covered, left.mesh.num_boundary_triangles());
    const auto cut = with_body(scene, std::make_shared<const core::Body>(left));
    const Field x = interactive::rest_positions(scene) + noise(left.mesh.num_nodes(), 1e-3, 4);
    auto expected = interactive::vessel_fibres(scene);
    const auto num_before = expected.size();
    std::erase_if(expected, [&](const auto &spring) { return !is_left(spring); });
    EXPECT_LT(expected.size(), num_before);
    EXPECT_GT(expected.size(), 10U);
    EXPECT_NEAR(energy_of_springs(interactive::vessel_fibres(cut), x), energy_of_springs(expected, x),
                1e-9 * energy_of_springs(expected, x));
    double stiffness = 0.0;
    for (const auto &spring : interactive::capsule_edges(cut))
        stiffness += spring.stiffness;
    const double per_facet = 3.0 * std::sqrt(3.0) / 4.0 * tests::covered::capsule.stiffness();
    EXPECT_NEAR(stiffness, num_covered * per_facet, 1e-9 * stiffness);
}

/// Both bounds of the longest stable step.
TEST(PointSprings, MakeExplicitStepsShorter) {
    for (const auto *const name : {"tled", "tled_nodal_pressure", "tled_quadratic"}) {
        const auto bare = tests::bar_scene(true), scene = with_both(bare);
        const auto &method = interactive::find_method(name);
        const double critical = method.prepare(scene)->critical_time_step();
        EXPECT_LT(critical, 0.95 * method.prepare(bare)->critical_time_step()) << name;
        const auto largest_after = [&](double step) {
            const auto simulation = method.prepare(scene);
            const Field rest = simulation->positions();
            simulation->set_state(rest, noise(rest.cols(), 1e-4, 8));
            simulation->step(1000.0 * step, 1000);
            return (simulation->positions() - rest).norm();
        };
        EXPECT_LT(largest_after(0.97 * critical), 1e-4) << name;
        EXPECT_FALSE(largest_after(1.05 * critical) < 1e-2) << name;
    }
}

} // namespace
} // namespace livermark
