#include <algorithm>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>
#include <string>

#include "interactive/method.hpp"
#include "tests/interactive/moving_scene.hpp"
#include "tests/oracles/slow_methods.hpp"

namespace livermark {
namespace {

using core::Vector3;
using interactive::Field;
using interactive::SceneCut;
using interactive::Simulation;

constexpr double step_of_cut_tests = 2e-3;

Vector3 middle_of(const core::TetraMesh &mesh, int tetrahedron) {
    Vector3 middle = Vector3::Zero();
    for (const int node : mesh.tetrahedra[tetrahedron])
        middle += 0.25 * mesh.points[node];
    return middle;
}

/// The rest of a body. Nodes that no tetrahedron has are left out, which gives those behind them other numbers.
SceneCut left_of(const core::Body &body, std::vector<std::array<int, 4>> tetrahedra, std::vector<Vector3> points,
                 std::vector<int> parents) {
    core::Body left{
        .name = body.name, .mesh = {}, .materials = body.materials, .capsule = body.capsule, .vessels = body.vessels};
    left.mesh.region_names = body.mesh.region_names;
    left.mesh.patch_names = {"surface"};
    std::vector<int> number(points.size(), -1);
    for (const auto &nodes : tetrahedra)
        for (const int node : nodes)
            number[node] = 0;
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] == 0) {
            number[i] = left.mesh.num_nodes();
            left.mesh.points.push_back(points[i]);
        }
    for (std::size_t t = 0; t < tetrahedra.size(); ++t) {
        auto &nodes = left.mesh.tetrahedra.emplace_back(tetrahedra[t]);
        for (int &node : nodes)
            node = number[node];
        left.mesh.region.push_back(body.mesh.region[parents[t]]);
    }
    left.mesh.boundary_triangles = core::outer_faces(left.mesh.tetrahedra);
    left.mesh.boundary_patch.assign(left.mesh.boundary_triangles.size(), 0);
    SceneCut cut{.body = std::make_shared<const core::Body>(std::move(left)),
                 .node_mass = {},
                 .parent_tetrahedron = std::move(parents)};
    cut.node_mass = msm::lumped_masses(*cut.body);
    return cut;
}

/// Takes away the tetrahedra at the corner (0.06, 0, 0) m.
SceneCut corner_removed(const core::Body &body) {
    std::vector<std::array<int, 4>> tetrahedra;
    std::vector<int> parents;
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        if ((middle_of(body.mesh, t) - Vector3(0.06, 0.0, 0.0)).norm() > 0.017) {
            tetrahedra.push_back(body.mesh.tetrahedra[t]);
            parents.push_back(t);
        }
    return left_of(body, std::move(tetrahedra), body.mesh.points, std::move(parents));
}

/// Parts tetrahedra on either side of y = 0.015 m, where z is above 0.015 m: the cut ends inside, so that parted edges
/// share the nodes of its end.
SceneCut parted_from_above(const core::Body &body) {
    auto tetrahedra = body.mesh.tetrahedra;
    auto points = body.mesh.points;
    std::map<int, int> copies;
    std::vector<bool> is_below(points.size(), false), is_beyond(points.size(), false);
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        for (const int node : tetrahedra[t])
            (middle_of(body.mesh, t).y() < 0.015 ? is_below : is_beyond)[node] = true;
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        if (middle_of(body.mesh, t).y() > 0.015)
            for (int &node : tetrahedra[t])
                if (is_below[node] && is_beyond[node] && body.mesh.points[node].z() > 0.02) {
                    const auto [found, is_new] = copies.try_emplace(node, static_cast<int>(points.size()));
                    if (is_new)
                        points.push_back(body.mesh.points[node]);
                    node = found->second;
                }
    std::vector<int> parents(tetrahedra.size());
    std::iota(parents.begin(), parents.end(), 0);
    return left_of(body, std::move(tetrahedra), std::move(points), std::move(parents));
}

struct KindOfCut {
    const char *name;
    SceneCut (*make)(const core::Body &body);
};
constexpr KindOfCut kinds_of_cuts[] = {{"removed", corner_removed}, {"parted", parted_from_above}};

/// A set-up of the cut body with the state of another.
/// @param orders  null to find them anew
std::unique_ptr<Simulation> set_up_anew(const interactive::Method &method, const Simulation &like, const SceneCut &cut,
                                        std::shared_ptr<const interactive::Orders> orders = nullptr) {
    auto fresh = method.prepare({.body = cut.body,
                                 .node_mass = cut.node_mass,
                                 .constrained_nodes = like.scene().constrained_nodes,
                                 .mass_damping = like.scene().mass_damping,
                                 .orders = std::move(orders)});
    fresh->set_external_forces(like.external_forces());
    fresh->set_targets(like.targets());
    fresh->set_state(like.positions(), like.velocities());
    return fresh;
}

/// A bar that swings, and is pulled.
std::unique_ptr<Simulation> swinging(const interactive::Method &method, const interactive::Scene &scene) {
    auto simulation = method.prepare(scene);
    simulation->set_external_forces(Vector3(1e-4, 0.0, -2e-4).replicate(1, simulation->scene().body->mesh.num_nodes()));
    Field v = tests::noise(simulation->positions().cols(), 0.02, 9).colwise() + Vector3(0.1, -0.2, 0.15);
    const auto is_free = interactive::free_nodes(simulation->scene());
    for (Eigen::Index i = 0; i < v.cols(); ++i)
        if (!is_free[i])
            v.col(i).setZero();
    simulation->set_state(simulation->positions(), v);
    for (int k = 0; k < 3; ++k)
        simulation->step(step_of_cut_tests, 20);
    return simulation;
}

std::unique_ptr<Simulation> swinging(const interactive::Method &method, bool is_constrained) {
    return swinging(method, tests::uneven_scene({6, 2, 2}, is_constrained, 2.0));
}

/// The same bar with a capsule and a vessel.
std::unique_ptr<Simulation> swinging_with_springs(const interactive::Method &method) {
    auto scene = tests::uneven_scene({6, 2, 2}, true, 2.0);
    auto body = *scene.body;
    body.capsule = core::Capsule{.thickness = 1e-4, .young_modulus = 2e5};
    body.vessels = core::VesselTree{.points = {{-0.005, 0.012, 0.013}, {0.065, 0.02, 0.014}},
                                    .radius = {3e-3, 3e-3},
                                    .segments = {{0, 1}},
                                    .wall_ratio = 0.2,
                                    .wall_modulus = 2e5};
    scene.body = std::make_shared<const core::Body>(std::move(body));
    return swinging(method, scene);
}

/// The node that each node of what is left was, or was parted from.
std::vector<int> parent_nodes(const core::TetraMesh &before, const SceneCut &cut) {
    std::vector<int> parents(cut.body->mesh.points.size());
    for (std::size_t t = 0; t < cut.parent_tetrahedron.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            parents[cut.body->mesh.tetrahedra[t][k]] = before.tetrahedra[cut.parent_tetrahedron[t]][k];
    return parents;
}

struct CutMotion : testing::TestWithParam<std::string> {
    const interactive::Method &method = interactive::find_method(GetParam());

    /// Nodes or constraints are moved one after the other, in an order that a cut keeps and a set-up chooses anew: both
    /// agree as iterations converge.
    bool visits_in_an_order() const {
        return GetParam() == "xpbd_springs" || GetParam() == "xpbd_neo_hookean" || GetParam() == "vertex_block_descent";
    }
    int iterations() const { return visits_in_an_order() ? 300 : 20; }

    /// Bound of positions, over the way of the steps; in double precision only factors are in another order.
    double tolerance(bool is_slow = false) const {
        if (visits_in_an_order()) // and gradients of constraints turn within a step, as the order has it
            return GetParam() == "vertex_block_descent" ? 0.02 : 0.05;
        return is_slow ? 1e-9 : 1e-3;
    }
};

TEST_P(CutMotion, IsThatOfTheCutBodySetUpAnew) {
    for (const bool is_slow : {false, true})
        for (const auto &kind : kinds_of_cuts) {
            const auto moved_by = is_slow ? tests::slow_method(GetParam()) : method;
            const auto before = swinging(moved_by, true);
            const auto cut = kind.make(*before->scene().body);
            const auto after = interactive::continue_after_cut(moved_by, *before, cut);
            const auto fresh = set_up_anew(moved_by, *after, cut);
            const Field start = after->positions();
            for (int k = 0; k < 2; ++k) {
                after->step(step_of_cut_tests, iterations());
                fresh->step(step_of_cut_tests, iterations());
            }
            EXPECT_LT((after->positions() - fresh->positions()).norm(),
                      tolerance(is_slow) * (fresh->positions() - start).norm())
                << kind.name << (is_slow ? ", double" : ", single");
            EXPECT_GT((fresh->positions() - start).norm(), 1e-3);
        }
}

TEST_P(CutMotion, IsToTheBitThatOfASetUpInTheSameOrders) {
    for (const auto &kind : kinds_of_cuts) {
        const auto before = swinging(method, true);
        const auto cut = kind.make(*before->scene().body);
        const auto after = interactive::continue_after_cut(method, *before, cut);
        const auto fresh = set_up_anew(method, *after, cut, after->scene().orders);
        after->step(step_of_cut_tests, 5);
        fresh->step(step_of_cut_tests, 5);
        EXPECT_EQ(after->positions(), fresh->positions()) << kind.name;
        EXPECT_EQ(after->velocities(), fresh->velocities()) << kind.name;
    }
}

TEST_P(CutMotion, IsThatOfTheCutBodySetUpAnewWithACapsuleAndAVessel) {
    for (const auto &kind : kinds_of_cuts) {
        const auto before = swinging_with_springs(method);
        const auto cut = kind.make(*before->scene().body);
        const auto after = interactive::continue_after_cut(method, *before, cut);
        const auto fresh = set_up_anew(method, *after, cut);
        const Field start = after->positions();
        for (auto *const moved : {after.get(), fresh.get()})
            moved->step(step_of_cut_tests, iterations());
        EXPECT_LT((after->positions() - fresh->positions()).norm(), tolerance() * (fresh->positions() - start).norm())
            << kind.name;
        EXPECT_GT((fresh->positions() - start).norm(), 5e-4);
    }
}

TEST_P(CutMotion, BeginsWhereEachNodeWasAndKeepsMomentum) {
    for (const auto &kind : kinds_of_cuts) {
        const auto before = swinging(method, false);
        const auto cut = kind.make(*before->scene().body);
        const auto after = interactive::continue_after_cut(method, *before, cut);
        const auto parents = parent_nodes(before->scene().body->mesh, cut);
        Vector3 momentum = Vector3::Zero(), expected = momentum;
        for (std::size_t i = 0; i < parents.size(); ++i) {
            const auto now = static_cast<Eigen::Index>(i);
            EXPECT_EQ(after->positions().col(now), before->positions().col(parents[i]));
            EXPECT_EQ(after->velocities().col(now), before->velocities().col(parents[i]));
            expected += cut.node_mass[i] * before->velocities().col(parents[i]);
            momentum += cut.node_mass[i] * after->velocities().col(now);
        }
        EXPECT_EQ(momentum, expected);
        if (kind.make == parted_from_above) { // nothing is gone
            const Vector3 all = tests::momentum_of(*before), force = before->external_forces().rowwise().sum();
            // Quadratic tetrahedra take the mean density around their nodes, and that of a copy is another one.
            EXPECT_LT((tests::momentum_of(*after) - all).norm(),
                      (GetParam() == "tled_quadratic" ? 2e-3 : 1e-12) * all.norm());
            EXPECT_LT((after->external_forces().rowwise().sum() - force).norm(), 1e-12 * force.norm());
        }
    }
}

TEST_P(CutMotion, KeepsConstrainedNodesAndTheirCopiesAtTheirTargets) {
    const auto before = swinging(method, true);
    before->set_targets(before->targets().colwise() + Vector3(1e-3, 0.0, 0.0));
    const auto cut = parted_from_above(*before->scene().body);
    const auto after = interactive::continue_after_cut(method, *before, cut);
    const auto &nodes = after->scene().constrained_nodes;
    EXPECT_GT(nodes.size(), before->scene().constrained_nodes.size());
    after->step(step_of_cut_tests, 20);
    for (std::size_t c = 0; c < nodes.size(); ++c)
        EXPECT_EQ(Vector3(after->positions().col(nodes[c])), cut.body->mesh.points[nodes[c]] + Vector3(1e-3, 0.0, 0.0));
}

TEST_P(CutMotion, KeepsTheOrdersOfTheBodyBefore) {
    const auto before = swinging(method, true);
    before->prepare(step_of_cut_tests);
    for (const auto &kind : kinds_of_cuts) {
        const auto after = interactive::continue_after_cut(method, *before, kind.make(*before->scene().body));
        const auto &expected = *after->scene().orders;
        const auto found = after->orders();
        if (before->scene().own_nodes.empty()) {
            EXPECT_EQ(found.rows, expected.rows);
        }
        EXPECT_EQ(found.rows.size(), expected.rows.size());
        EXPECT_EQ(found.fans.size(), expected.fans.size());
        EXPECT_EQ(found.tetrahedron_colour, expected.tetrahedron_colour);
        EXPECT_EQ(found.edge_colour, expected.edge_colour);
        EXPECT_EQ(found.node_colour, expected.node_colour);
        EXPECT_EQ(found.strips.size(), expected.strips.size());
    }
}

TEST_P(CutMotion, GoesOnAfterOneCutOnTheOther) {
    const auto before = swinging(method, true);
    const auto first = parted_from_above(*before->scene().body);
    auto once = interactive::continue_after_cut(method, *before, first);
    once->step(step_of_cut_tests, iterations());
    const auto second = corner_removed(*first.body);
    const auto twice = interactive::continue_after_cut(method, *once, second);
    const auto fresh = set_up_anew(method, *twice, second);
    const Field start = twice->positions();
    twice->step(step_of_cut_tests, iterations());
    fresh->step(step_of_cut_tests, iterations());
    EXPECT_LT((twice->positions() - fresh->positions()).norm(), tolerance() * (fresh->positions() - start).norm());
}

TEST_P(CutMotion, RefusesParentsThatAreNone) {
    const auto before = swinging(method, true);
    auto cut = corner_removed(*before->scene().body);
    cut.parent_tetrahedron.front() = cut.parent_tetrahedron.back();
    EXPECT_THROW(interactive::continue_after_cut(method, *before, cut), std::invalid_argument);
    cut.parent_tetrahedron.pop_back();
    EXPECT_THROW(interactive::continue_after_cut(method, *before, cut), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(All, CutMotion, testing::ValuesIn(tests::method_names()),
                         [](const auto &of) { return of.param; });

/// Orders of a method on a body, as a cut leaves them.
std::shared_ptr<const interactive::Orders> orders_as_cut(const char *method, const interactive::Scene &scene,
                                                         const SceneCut &cut) {
    const auto &of = interactive::find_method(method);
    return interactive::continue_after_cut(of, *of.prepare(scene), cut)->scene().orders;
}

template <std::size_t n>
void expect_apart(const std::vector<int> &colour, const std::vector<std::array<int, n>> &sets) {
    ASSERT_EQ(colour.size(), sets.size());
    std::set<std::pair<int, int>> seen;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        ASSERT_GE(colour[s], 0);
        for (const int node : sets[s])
            EXPECT_TRUE(seen.emplace(colour[s], node).second) << "node " << node << " twice in colour " << colour[s];
    }
}

TEST(OrdersOfACutBody, AreOrdersOfIt) {
    for (const auto &kind : kinds_of_cuts) {
        const auto scene = tests::uneven_scene({6, 2, 2}, true);
        const auto cut = kind.make(*scene.body);
        const auto &mesh = cut.body->mesh;
        const auto with_fans = orders_as_cut("tled", scene, cut),
                   with_edges = orders_as_cut("xpbd_springs", scene, cut),
                   with_nodes = orders_as_cut("vertex_block_descent", scene, cut);
        auto rows = with_fans->rows;
        std::ranges::sort(rows);
        std::vector<int> all(mesh.points.size());
        std::iota(all.begin(), all.end(), 0);
        EXPECT_EQ(rows, all);
        expect_apart(with_edges->tetrahedron_colour, mesh.tetrahedra);
        expect_apart(with_edges->edge_colour, core::edge_table(mesh.tetrahedra).edges);
        ASSERT_EQ(with_nodes->node_colour.size(), mesh.points.size());
        for (const auto &nodes : mesh.tetrahedra)
            for (std::size_t a = 0; a < 4; ++a)
                for (std::size_t b = a + 1; b < 4; ++b)
                    EXPECT_NE(with_nodes->node_colour[nodes[a]], with_nodes->node_colour[nodes[b]]);
        std::vector<int> times(mesh.tetrahedra.size(), 0);
        const auto &fans = with_fans->fans;
        for (std::size_t f = 0; f < fans.size(); ++f) {
            const auto rim = fans.rim(f), numbers = fans.tetrahedra(f);
            ASSERT_EQ(rim.size(), numbers.size() + 1);
            for (std::size_t k = 0; k < numbers.size(); ++k) {
                ++times[numbers[k]];
                auto nodes = mesh.tetrahedra[numbers[k]];
                std::array in_fan{fans.axis(f)[0], fans.axis(f)[1], rim[k], rim[k + 1]};
                std::ranges::sort(nodes);
                std::ranges::sort(in_fan);
                EXPECT_EQ(nodes, in_fan);
            }
        }
        EXPECT_EQ(std::ranges::count(times, 1), std::ssize(times));
    }
}

/// The edges of a table that knows nothing of the body before.
TEST(OrdersOfACutBody, HaveTheEdgesOfTheCutBodyInTheirOrder) {
    const auto scene = tests::uneven_scene({6, 2, 2}, false);
    for (const auto &kind : kinds_of_cuts) {
        const auto cut = kind.make(*scene.body);
        // Nodes may have any numbers, and tetrahedra may stand in any order.
        auto shuffled = cut;
        core::Body body = *cut.body;
        std::vector<int> number(body.mesh.points.size());
        std::iota(number.begin(), number.end(), 0);
        std::ranges::shuffle(number, std::mt19937(3));
        for (std::size_t i = 0; i < number.size(); ++i)
            body.mesh.points[number[i]] = cut.body->mesh.points[i];
        for (auto &nodes : body.mesh.tetrahedra)
            for (int &node : nodes)
                node = number[node];
        std::swap(body.mesh.tetrahedra.front(), body.mesh.tetrahedra.back());
        std::swap(body.mesh.region.front(), body.mesh.region.back());
        std::swap(shuffled.parent_tetrahedron.front(), shuffled.parent_tetrahedron.back());
        shuffled.body = std::make_shared<const core::Body>(std::move(body));
        for (const auto &of : {cut, shuffled}) {
            const auto found = orders_as_cut("xpbd_springs", scene, of)->edges;
            const auto expected = core::edge_table(of.body->mesh.tetrahedra);
            EXPECT_EQ(found.edges, expected.edges) << kind.name;
            EXPECT_EQ(found.tetrahedron_edge, expected.tetrahedron_edge) << kind.name;
        }
    }
}

TEST(OrdersOfACutBody, KeepStripsAwayFromTheCutAlone) {
    const auto scene = tests::uneven_scene({6, 2, 2}, false);
    for (const auto &kind : kinds_of_cuts) {
        const auto cut = kind.make(*scene.body);
        const auto &mesh = cut.body->mesh;
        const auto strips = orders_as_cut("vertex_block_descent", scene, cut)->strips;
        std::vector<int> num_kept(mesh.points.size(), 0), num_around = num_kept;
        for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
            for (const int node : mesh.tetrahedra[t])
                ++num_around[node];
        for (std::size_t i = 0; i < strips.size(); ++i)
            for (const auto &entry : strips[i])
                if (entry.triangle >= 0) {
                    ++num_kept[i];
                    const auto &nodes = mesh.tetrahedra[entry.triangle];
                    EXPECT_NE(std::ranges::find(nodes, entry.node), nodes.end());
                    EXPECT_NE(std::ranges::find(nodes, static_cast<int>(i)), nodes.end());
                }
        int num_nodes_kept = 0;
        for (std::size_t i = 0; i < num_kept.size(); ++i) {
            EXPECT_TRUE(num_kept[i] == 0 || num_kept[i] == num_around[i]) << i;
            num_nodes_kept += num_kept[i] > 0 ? 1 : 0;
        }
        EXPECT_GT(num_nodes_kept, 10) << kind.name;
        EXPECT_LT(num_nodes_kept, mesh.num_nodes()) << kind.name;
    }
}

} // namespace
} // namespace livermark
