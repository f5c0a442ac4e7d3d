#include "app/server/sessions/live_fem.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include "app/live/find_cut.hpp"
#include "app/live/part_body.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "meshes/cutting/cut.hpp"
#include "results/hdf5/result_file.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/records/sample_result.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

namespace fs = std::filesystem;
using Rows = std::vector<std::array<double, 4>>;

/// Spread of all tractions here.
const core::RoundLoad shape{{0.3, 0.2, 0.1}, 0.9};

server::Message binary(Rows rows, const core::RoundLoad &load = shape) {
    rows.insert(rows.begin(), {load.middle.x(), load.middle.y(), load.middle.z(), load.radius});
    return {true, {reinterpret_cast<const char *>(rows.data()), sizeof(rows[0]) * rows.size()}};
}

double work(const server::Message &reply) {
    double value = 0.0;
    std::memcpy(&value, reply.bytes.data(), sizeof value);
    return value;
}

std::vector<Eigen::Vector3f> displacement(const server::Message &reply) {
    EXPECT_TRUE(reply.is_binary);
    const auto bytes = reply.bytes.size() - sizeof(double);
    EXPECT_EQ(bytes % sizeof(Eigen::Vector3f), 0U);
    std::vector<Eigen::Vector3f> rows(bytes / sizeof(Eigen::Vector3f));
    std::memcpy(static_cast<void *>(rows.data()), reply.bytes.data() + sizeof(double), bytes);
    return rows;
}

/// The sentence that it refuses with.
template <class Action> std::string fault_of(const Action &action) {
    try {
        action();
    } catch (const support::InputError &error) {
        return error.what();
    }
    return "no fault";
}

/// A folder with the file of a box of two materials, constrained at x_min, and of which z_max is constrained in z only;
/// standing.h5 is the same on a foundation.
class LiveFemTest : public testing::Test {
  protected:
    LiveFemTest() {
        fs::create_directories(folder);
        results::write_result(folder / "box.h5", result);
        results::write_result(folder / "standing.h5", tests::sample_result(4));
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
            const auto &patch = mesh.patch_names[mesh.boundary_patch[f]];
            (patch == "x_min" ? constrained : patch == "z_max" ? sliding : free).push_back(f);
        }
    }
    ~LiveFemTest() override { fs::remove_all(folder); }

    static constexpr auto report_to_nobody = [](const std::string &) { return true; };

    server::Session begin(const std::string &file = "box.h5",
                          const server::ReportProgress &report = report_to_nobody) const {
        return server::live_fem(folder, {{"file", file}}, report);
    }

    /// The same by the model itself, on a body and a load case made here.
    core::Solution solved(const Rows &rows, double parenchyma, double tumour,
                          const std::array<double, 2> &poisson_ratios,
                          const std::optional<core::RoundLoad> &spread = shape,
                          const std::string &model = "fem_p2") const {
        return solved_on(*result.problem.body, rows, parenchyma, tumour, poisson_ratios, spread, model);
    }
    core::Solution solved_on(const core::Body &whole, const Rows &rows, double parenchyma, double tumour,
                             const std::array<double, 2> &poisson_ratios,
                             const std::optional<core::RoundLoad> &spread = shape, const std::string &model = "fem_p2",
                             const std::optional<core::Foundation> &foundation = {}) const {
        auto body = std::make_shared<core::Body>(whole);
        body->materials = {{1060.0, parenchyma, poisson_ratios[0]}, {1100.0, tumour, poisson_ratios[1]}};
        auto load_case = tests::empty_load_case(mesh);
        tests::prescribe(load_case, mesh, "x_min", core::Vector3::Zero());
        load_case.foundation = foundation;
        load_case.conditions.push_back({"probe", core::ConditionKind::traction, spread});
        for (const auto &[facet, x, y, z] : rows) {
            load_case.condition_on[static_cast<int>(facet)] = 1;
            load_case.value[static_cast<int>(facet)] = {x, y, z};
        }
        return support::find_named(models::all_models(), model, "model").solve({body, load_case});
    }

    /// Foundation of standing.h5, below what is not held.
    core::Foundation foundation() const {
        std::vector<int> whole(mesh.boundary_triangles.size());
        for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
            whole[f] = std::ranges::find(constrained, f) == constrained.end() ? f : -1;
        auto below = tests::sample_result(4).problem.load_case.foundation.value();
        below.move_to_parts(whole);
        return below;
    }

    static void expect_same(const server::Message &reply, const core::Solution &solution) {
        EXPECT_NEAR(work(reply), 2.0 * solution.strain_energy, 1e-6 * work(reply));
        expect_same_displacement(reply, solution);
    }

    static void expect_same_displacement(const server::Message &reply, const core::Solution &solution) {
        const auto found = displacement(reply);
        const auto &expected = solution.displacement;
        ASSERT_EQ(found.size(), expected.size());
        double largest = 0.0;
        for (const auto &u : expected)
            largest = std::max(largest, u.norm());
        EXPECT_GT(largest, 1e-6);
        for (std::size_t i = 0; i < found.size(); ++i)
            EXPECT_LT((found[i].cast<double>() - expected[i]).norm(), 1e-6 * largest) << "node " << i;
    }

    void expect_solved_after_a_cut(const core::Body &whole, const std::string &file,
                                   const std::optional<core::Foundation> &below = {}) const;

    const fs::path folder = fs::canonical(fs::temp_directory_path()) / fmt::format("livermark_live_{}", getpid());
    const results::Result result = [] {
        auto sample = tests::sample_result(4);
        sample.problem.load_case.foundation.reset();
        return sample;
    }();
    const core::TetraMesh &mesh = result.problem.body->mesh;
    std::vector<int> constrained, sliding, free;
};

TEST_F(LiveFemTest, AnswersAsTheModelDoes) {
    const auto converse = begin();
    const Rows rows{{1.0 * free[0], 30.0, -20.0, 10.0}, {1.0 * sliding[1], 0.0, 0.0, -50.0}};
    expect_same(converse(binary(rows)), solved(rows, 4000.0, 20000.0, {0.45, 0.48}));
    EXPECT_EQ(converse({false, "young_modulus=6000&poisson_ratio=0.3"}).bytes, "chosen=fem_p2");
    expect_same(converse(binary(rows)), solved(rows, 6000.0, 30000.0, {0.3, 0.3}));
    const Rows others{{1.0 * free.back(), 5.0, 0.0, 0.0}};
    expect_same(converse(binary(others)), solved(others, 6000.0, 30000.0, {0.3, 0.3}));
    EXPECT_FALSE(converse({false, "poisson_ratio=0.3&young_modulus=1e3"}).is_binary);
    expect_same(converse(binary(rows)), solved(rows, 1000.0, 5000.0, {0.3, 0.3}));
    expect_same(converse(binary(rows, {})), solved(rows, 1000.0, 5000.0, {0.3, 0.3}, std::nullopt));
}

/// Beside the same cut by another way, and the model on that.
void LiveFemTest::expect_solved_after_a_cut(const core::Body &whole, const std::string &file,
                                            const std::optional<core::Foundation> &below) const {
    const auto box = core::bounding_box(mesh.points);
    const core::Vector3 place = box.min() + 0.7 * box.diagonal();
    const auto cut = meshes::cut(whole, {meshes::HalfSpaceCut{place, {1.0, 0.0, 0.0}}});
    const auto &left = cut.body.mesh;
    std::string gone;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t)
        if (!std::ranges::binary_search(cut.parents.front(), t))
            gone += fmt::format("{}{}", gone.empty() ? "" : ",", t);
    ASSERT_FALSE(gone.empty());
    std::set<int> nodes;
    for (const int t : cut.parents.front())
        nodes.insert(mesh.tetrahedra[t].begin(), mesh.tetrahedra[t].end());
    const std::vector<int> number(nodes.begin(), nodes.end());
    // In the order of the session: facets of the whole body that are left, then those of the wound by their tetrahedra.
    std::map<std::array<int, 3>, int> facet_of;
    const auto key = [](std::array<int, 3> face) {
        std::ranges::sort(face);
        return face;
    };
    std::vector<int> in_wound;
    for (int f = 0; f < left.num_boundary_triangles(); ++f) {
        auto face = left.boundary_triangles[f];
        for (int &node : face)
            node = number[node];
        facet_of[key(face)] = f;
        if (left.patch_names[left.boundary_patch[f]] == core::wound_patch)
            in_wound.push_back(f);
    }
    std::vector<int> order;
    for (const auto &face : mesh.boundary_triangles)
        if (const auto found = facet_of.find(key(face)); found != facet_of.end())
            order.push_back(found->second);
    order.insert(order.end(), in_wound.begin(), in_wound.end());
    ASSERT_EQ(order.size(), left.boundary_triangles.size());
    std::vector<int> before(left.boundary_triangles.size(), -1);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (const auto found = facet_of.find(key(mesh.boundary_triangles[f])); found != facet_of.end())
            before[found->second] = f;

    auto load_case = tests::empty_load_case(left);
    tests::prescribe(load_case, left, "x_min", core::Vector3::Zero());
    load_case.foundation = below;
    if (below)
        load_case.foundation->move_to_parts(before);
    load_case.conditions.push_back({"probe", core::ConditionKind::traction, core::RoundLoad{place, 0.9}});
    Rows rows;
    for (const std::size_t at : {order.size() - 1, order.size() - 2}) {
        rows.push_back({1.0 * static_cast<double>(at), -40.0, 10.0, 5.0});
        load_case.condition_on[order[at]] = 1;
        load_case.value[order[at]] = {-40.0, 10.0, 5.0};
    }
    const auto solution = support::find_named(models::all_models(), "fem_p2", "model")
                              .solve({std::make_shared<core::Body>(cut.body), load_case});

    const auto converse = begin(file);
    converse(binary({{1.0 * free[0], 30.0, -20.0, 10.0}})); // on the whole body before
    EXPECT_EQ(converse({false, "gone=" + gone}).bytes, fmt::format("nodes={}", number.size()));
    const auto found = displacement(converse(binary(rows, {place, 0.9})));
    ASSERT_EQ(found.size(), mesh.points.size());
    double largest = 0.0;
    for (const auto &u : solution.displacement)
        largest = std::max(largest, u.norm());
    EXPECT_GT(largest, 1e-6);
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        const auto at = std::ranges::lower_bound(number, node) - number.begin();
        const core::Vector3 expected = nodes.contains(node) ? solution.displacement[at] : core::Vector3::Zero();
        EXPECT_LT((found[node].cast<double>() - expected).norm(), 1e-6 * largest) << "node " << node;
    }
    for (const auto *text : {"gone=", "gone=x", "gone=3,2", "gone=-1", "gone=1e1", "gone=99999999", "gone=1,,2"})
        EXPECT_NE(fault_of([&] { converse({false, text}); }), "no fault") << text;
    EXPECT_EQ(displacement(converse(binary(rows, {place, 0.9}))), found);
}

TEST_F(LiveFemTest, SolvesOnWhatCutsHaveLeft) {
    expect_solved_after_a_cut(*result.problem.body, "box.h5");
}

/// Beside the model on the parted mesh, and traction on a face that is parted.
TEST_F(LiveFemTest, SolvesOnWhatABladeHasParted) {
    const auto box = core::bounding_box(mesh.points);
    const auto at = [&](double x, double y, double z) {
        return core::Vector3(box.min() + box.sizes().cwiseProduct(core::Vector3(x, y, z)));
    };
    const auto remains =
        live::remains_of(mesh, std::vector<char>(mesh.tetrahedra.size(), 0), mesh.boundary_triangles.size());
    // Through one of the two faces between bricks, of whose middles one is in a quarter.
    live::PartedBody parted;
    for (const auto &[y, z] : {std::pair{0.0, 0.0}, {0.0, 1.0}, {1.0, 0.0}, {1.0, 1.0}}) {
        const meshes::BladeCut blade{{at(0.51, y - 0.45, z - 0.45), at(0.51, y + 0.45, z - 0.45),
                                      at(0.51, y + 0.45, z + 0.45), at(0.51, y - 0.45, z + 0.45)},
                                     0.0};
        try {
            parted = live::part_body(mesh, mesh, remains, std::vector<bool>(mesh.points.size(), false),
                                     std::vector<core::Vector3>(mesh.points.size(), core::Vector3::Zero()), blade);
        } catch (const support::InputError &) {
            continue;
        }
    }
    ASSERT_EQ(parted.mesh.boundary_triangles.size(), mesh.boundary_triangles.size() + 2);
    ASSERT_GT(parted.mesh.points.size(), mesh.points.size());
    std::string nodes, tetrahedra;
    const auto add = [](std::string &text, auto number) {
        text += fmt::format("{}{}", text.empty() ? "" : ",", number);
    };
    for (std::size_t i = 0; i < parted.mesh.points.size(); ++i)
        if (i >= mesh.points.size() || parted.mesh.points[i] != mesh.points[i]) {
            add(nodes, i);
            for (const double x : parted.mesh.points[i])
                add(nodes, x);
        }
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        if (parted.mesh.tetrahedra[t] != mesh.tetrahedra[t]) {
            add(tetrahedra, t);
            for (const int node : parted.mesh.tetrahedra[t])
                add(tetrahedra, node);
        }
    const int in_wound = parted.mesh.num_boundary_triangles() - 1;
    ASSERT_EQ(parted.mesh.patch_names[parted.mesh.boundary_patch[in_wound]], core::wound_patch);
    auto body = *result.problem.body;
    body.mesh = parted.mesh;
    auto load_case = tests::empty_load_case(body.mesh);
    tests::prescribe(load_case, body.mesh, "x_min", core::Vector3::Zero());
    load_case.conditions.push_back({"probe", core::ConditionKind::traction, std::nullopt});
    Rows rows;
    for (const int facet : {free[0], in_wound}) {
        rows.push_back({1.0 * facet, -40.0, 10.0, 5.0});
        load_case.condition_on[facet] = 1;
        load_case.value[facet] = {-40.0, 10.0, 5.0};
    }
    const auto solution = support::find_named(models::all_models(), "fem_p2", "model")
                              .solve({std::make_shared<core::Body>(body), load_case});
    const auto converse = begin();
    const auto parts = "parted_nodes=" + nodes + "&parted_tetrahedra=" + tetrahedra;
    EXPECT_EQ(converse({false, "gone=&" + parts}).bytes, fmt::format("nodes={}", parted.mesh.points.size()));
    expect_same(converse(binary(rows, {})), solution);
    for (const auto *text : {"gone=&parted_nodes=1", "gone=&parted_nodes=99999,0,0,0&parted_tetrahedra=0,0,1,2,3",
                             "gone=&parted_tetrahedra=0,1,2,3", "gone=&parted_tetrahedra=0,0,0,0,0"})
        EXPECT_NE(fault_of([&] { converse({false, text}); }), "no fault") << text;
    expect_same(converse(binary(rows, {})), solution);
}

/// Springs below every third facet, so that some go with the cut.
TEST_F(LiveFemTest, SolvesOnWhatCutsHaveLeftOfAFoundation) {
    auto standing = result;
    auto &below = standing.problem.load_case.foundation.emplace();
    for (int f = 0; f < mesh.num_boundary_triangles(); f += 3)
        if (std::ranges::find(constrained, f) == constrained.end()) {
            below.facets.push_back(f);
            below.stiffness.push_back(1e4 * (1.0 + f % 4));
            below.normal_only.push_back(f % 2);
        }
    results::write_result(folder / "cut_through.h5", standing);
    expect_solved_after_a_cut(*result.problem.body, "cut_through.h5", below);
}

TEST_F(LiveFemTest, SolvesOnWhatCutsHaveLeftOfCapsuleVesselsAndMap) {
    auto covered = result;
    auto body = *result.problem.body;
    body.capsule = core::Capsule{.thickness = 1e-3, .young_modulus = 1e6};
    body.vessels = tests::vessels::rod({0.1, 0.1, 0.1}, {0.9, 0.3, 0.2}, 0.02, 1e6);
    for (const auto &nodes : mesh.tetrahedra)
        body.modulus_factor.push_back(0.7 + 0.5 * mesh.points[nodes[0]].y());
    covered.problem.body = std::make_shared<const core::Body>(body);
    results::write_result(folder / "covered.h5", covered);
    expect_solved_after_a_cut(body, "covered.h5");
}

/// Forces at the places of a needle do what the model says that they do at its places, whatever Young's moduli.
TEST_F(LiveFemTest, IsMovedByANeedle) {
    const auto box = core::bounding_box(mesh.points);
    const core::Vector3 target = box.center(), entry(target.x(), target.y(), box.max().z());
    const core::Needle needle{.name = {}, .entry = entry, .target = target, .spread = 0.4 * (target - entry).norm()};
    const auto line = core::needle_line(needle);
    std::string forces;
    Eigen::VectorXd force(3 * line.places.size());
    for (Eigen::Index i = 0; i < force.size(); ++i) {
        force[i] = std::sin(static_cast<double>(i));
        forces += fmt::format("{}{}", i == 0 ? "" : ",", force[i]);
    }
    const auto message = [&](const core::Vector3 &to, const std::string &given) {
        return fmt::format("needle={},{},{},{},{},{},{}&forces={}", entry.x(), entry.y(), entry.z(), to.x(), to.y(),
                           to.z(), needle.spread, given);
    };
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "x_min", core::Vector3::Zero());
    const auto compliance = support::find_named(models::all_models(), "fem_p2", "model")
                                .compliance({result.problem.body, load_case}, line.places);
    const auto converse = begin();
    const auto moved_target = [&] {
        const auto reply = converse({false, message(target, forces)});
        std::array<double, 4> numbers{};
        std::memcpy(numbers.data(), reply.bytes.data(), sizeof numbers);
        EXPECT_EQ(reply.bytes.size(), sizeof numbers + mesh.points.size() * sizeof(Eigen::Vector3f));
        EXPECT_NEAR(numbers[0], force.dot(compliance.matrix * force), 1e-6 * numbers[0]);
        return core::Vector3(numbers[1], numbers[2], numbers[3]);
    };
    const auto moved = moved_target();
    const core::Vector3 expected = (compliance.matrix * force).segment<3>(3 * line.target);
    EXPECT_LT((moved - expected).norm(), 1e-6 * expected.norm());

    const auto fault = [&](const std::string &text) { return fault_of([&] { converse({false, text}); }); };
    EXPECT_NE(fault(message(target, "1,2,3")).find("send three numbers for each"), std::string::npos);
    EXPECT_NE(fault(message(target, "x")).find("forces has 'x'"), std::string::npos);
    EXPECT_NE(fault(message(entry, forces)).find("farther from the entry than the spread"), std::string::npos);
    EXPECT_NE(fault("needle=1,2,3&forces=1,2,3").find("send entry, target"), std::string::npos);
    EXPECT_NE(fault("needle=1,2,3").find("forces is missing"), std::string::npos);
}

/// Solutions of large loads, whatever Young's moduli; linear elements come back when they are asked for.
TEST_F(LiveFemTest, AnswersByHyperelasticElementsWhereTheseAreAskedFor) {
    const auto converse = begin();
    converse({false, "young_modulus=6000&poisson_ratio=0.3"});
    const Rows rows{{1.0 * free[0], 900.0, -600.0, 300.0}, {1.0 * sliding[1], 0.0, 0.0, -900.0}};
    const auto linear = converse(binary(rows));
    const auto judge = models::static_reference(core::Regime::large).on_mesh;
    EXPECT_EQ(converse({false, "elements=hyperelastic"}).bytes, "chosen=" + judge);
    const auto solved_by_judge = [&](const Rows &loads) {
        return solved(loads, 6000.0, 30000.0, {0.3, 0.3}, shape, judge);
    };
    const auto expected = solved_by_judge(rows);
    const auto found = displacement(converse(binary(rows)));
    ASSERT_EQ(found.size(), expected.displacement.size());
    const auto apart = [&](const std::vector<Eigen::Vector3f> &u) {
        double off = 0.0, size = 0.0;
        for (std::size_t i = 0; i < u.size(); ++i) {
            off = std::max(off, (u[i].cast<double>() - expected.displacement[i]).norm());
            size = std::max(size, expected.displacement[i].norm());
        }
        return off / size;
    };
    EXPECT_LT(apart(found), 1e-4);
    EXPECT_GT(apart(displacement(linear)), 0.01);

    // The work of a load that is so small that it is twice the energy.
    const Rows small{{1.0 * free[0], 0.3, -0.2, 0.1}, {1.0 * sliding[1], 0.0, 0.0, -0.3}};
    const double twice = 2.0 * solved_by_judge(small).strain_energy;
    EXPECT_NEAR(work(converse(binary(small))), twice, 1e-3 * twice);

    EXPECT_NE(fault_of([&] {
                  converse(binary({{1.0 * free[0], 1e7, 0.0, 0.0}}));
              }).find("they find no equilibrium"),
              std::string::npos);
    EXPECT_EQ(fault_of([&] {
                  converse({false, "elements=cubic"});
              }),
              "elements are 'cubic'; send linear or hyperelastic");
    EXPECT_EQ(converse({false, "elements=linear"}).bytes, "chosen=fem_p2");
    EXPECT_EQ(displacement(converse(binary(rows))), displacement(linear));
}

/// Progress of Newton's method, and the end of its work where the reply is not waited for any longer.
TEST_F(LiveFemTest, SaysHowFarHyperelasticElementsAreAndIsInterrupted) {
    std::vector<std::string> told;
    std::size_t waited_for = 1000; // sentences
    const auto converse = begin("box.h5", [&](const std::string &sentence) {
        told.push_back(sentence);
        return told.size() < waited_for;
    });
    const auto load = binary({{1.0 * free[0], 900.0, -600.0, 300.0}});
    converse({false, "elements=hyperelastic"});
    const auto whole = displacement(converse(load));
    ASSERT_GE(told.size(), 3U);
    EXPECT_NE(told[0].find("tetrahedra are being assembled"), std::string::npos);
    EXPECT_NE(told[1].find("and 0 iterations of Newton's method it goes to 100 % of the force"), std::string::npos);
    for (std::size_t i = 2; i < told.size(); ++i)
        EXPECT_NE(told[i].find(fmt::format("and {} iterations of Newton's method", i - 2)), std::string::npos);
    for (waited_for = 1; waited_for <= 3; ++waited_for) {
        told.clear();
        EXPECT_EQ(converse(load).bytes, "interrupted=by+the+next+message");
        EXPECT_EQ(told.size(), waited_for);
    }
    waited_for = 1000;
    EXPECT_EQ(displacement(converse(load)), whole);
}

/// A needle whose forces are small moves hyperelastic elements as linear ones, and a strong one farther or less.
TEST_F(LiveFemTest, HyperelasticElementsAreMovedByANeedle) {
    const auto box = core::bounding_box(mesh.points);
    const core::Vector3 target = box.center(), entry(target.x(), target.y(), box.max().z());
    const double spread = 0.4 * (target - entry).norm();
    const auto places =
        core::needle_line({.name = {}, .entry = entry, .target = target, .spread = spread}).places.size();
    const auto converse = begin();
    /// Work over the force, and displacement of the target, over the force as well.
    const auto moved = [&](const char *elements, double force) {
        std::string forces;
        for (std::size_t k = 0; k < places; ++k)
            forces += fmt::format("{}0,0,{}", k == 0 ? "" : ",", -force);
        converse({false, fmt::format("elements={}", elements)});
        const auto reply =
            converse({false, fmt::format("needle={},{},{},{},{},{},{}&forces={}", entry.x(), entry.y(), entry.z(),
                                         target.x(), target.y(), target.z(), spread, forces)});
        std::array<double, 4> numbers{};
        std::memcpy(numbers.data(), reply.bytes.data(), sizeof numbers);
        EXPECT_EQ(reply.bytes.size(), sizeof numbers + mesh.points.size() * sizeof(Eigen::Vector3f)) << reply.bytes;
        return Eigen::Vector4d(numbers[0] / (force * force), numbers[1] / force, numbers[2] / force,
                               numbers[3] / force);
    };
    const auto apart = [](const Eigen::Vector4d &a, const Eigen::Vector4d &b) {
        return std::max(std::abs(a[0] - b[0]) / std::abs(b[0]),
                        (a.tail<3>() - b.tail<3>()).norm() / b.tail<3>().norm());
    };
    // Locking is the difference that is left, as under the round loads above.
    const auto small = moved("hyperelastic", 1e-6), linear = moved("linear", 1e-6);
    EXPECT_LT(apart(moved("linear", 1e-3), linear), 1e-9);
    EXPECT_LT(apart(small, linear), 0.3);
    EXPECT_LT(apart(moved("hyperelastic", 2e-6), small), 1e-3);
    EXPECT_LT(moved("hyperelastic", 1e-6)[3], 0.0) << "the target goes along";
}

TEST_F(LiveFemTest, SharesTheElementsOfABodyThatIsHeldAsAnother) {
    const Rows rows{{1.0 * free[0], 30.0, -20.0, 10.0}};
    // Another load case with other loads, which holds the same.
    auto pulled = result;
    pulled.problem.load_case.name = "pull";
    results::write_result(folder / "pulled.h5", pulled);
    ASSERT_EQ(server::SharedFem::count(), 0);
    auto one = begin();
    const auto first = displacement(one(binary(rows)));
    EXPECT_EQ(server::SharedFem::count(), 1);
    {
        const auto other = begin("pulled.h5");
        EXPECT_EQ(displacement(other(binary(rows))), first);
        EXPECT_EQ(server::SharedFem::count(), 1);
        other({false, "young_modulus=6000&poisson_ratio=0.3"});
        other(binary(rows));
        EXPECT_EQ(server::SharedFem::count(), 2);
        auto third = begin("pulled.h5");
        third({false, "young_modulus=1000&poisson_ratio=0.3"});
        third(binary(rows));
        EXPECT_EQ(server::SharedFem::count(), 2);
        one = {};
        EXPECT_EQ(server::SharedFem::count(), 1);
    }
    EXPECT_EQ(server::SharedFem::count(), 0);
}

/// Capsule and vessels keep their moduli where another Young's modulus is chosen.
TEST_F(LiveFemTest, HasTheCapsuleAndTheVesselsOfABody) {
    const Rows rows{{1.0 * free[0], 30.0, -20.0, 10.0}};
    const auto plain = begin();
    plain(binary(rows));
    auto covered = result;
    auto body = *result.problem.body;
    body.capsule = core::Capsule{.thickness = 1e-3, .young_modulus = 1e6};
    body.vessels = tests::vessels::rod({0.1, 0.1, 0.1}, {0.9, 0.3, 0.2}, 0.02, 1e6);
    covered.problem.body = std::make_shared<const core::Body>(body);
    results::write_result(folder / "covered.h5", covered);
    const auto converse = begin("covered.h5");
    expect_same(converse(binary(rows)), solved_on(body, rows, 4000.0, 20000.0, {0.45, 0.48}));
    EXPECT_EQ(server::SharedFem::count(), 2) << "not those of the body without";
    converse({false, "young_modulus=6000&poisson_ratio=0.3"});
    expect_same(converse(binary(rows)), solved_on(body, rows, 6000.0, 30000.0, {0.3, 0.3}));
    converse({false, "young_modulus=2000&poisson_ratio=0.3"});
    expect_same(converse(binary(rows)), solved_on(body, rows, 2000.0, 10000.0, {0.3, 0.3}));
}

/// Its springs keep their stiffness where another Young's modulus is chosen.
TEST_F(LiveFemTest, StandsOnTheFoundationOfTheLoadCase) {
    const Rows rows{{1.0 * free[0], 30.0, -20.0, 10.0}, {1.0 * sliding[1], 0.0, 0.0, -50.0}};
    const auto converse = begin("standing.h5"), converse_unborne = begin();
    EXPECT_LT(work(converse(binary(rows))), 0.9 * work(converse_unborne(binary(rows))));
    EXPECT_EQ(server::SharedFem::count(), 2) << "not those of the body without";
    const auto solved_standing = [&](double young_modulus, double poisson_ratio, const std::string &model) {
        return solved_on(*result.problem.body, rows, young_modulus, 5.0 * young_modulus, {poisson_ratio, poisson_ratio},
                         shape, model, foundation());
    };
    const auto judge = models::static_reference(core::Regime::large).on_mesh;
    for (const double young_modulus : {6000.0, 2000.0}) {
        converse({false, fmt::format("young_modulus={}&poisson_ratio=0.3", young_modulus)});
        converse({false, "elements=linear"});
        const auto expected = solved_standing(young_modulus, 0.3, "fem_p2");
        const auto reply = converse(binary(rows));
        expect_same_displacement(reply, expected);
        EXPECT_GT(work(reply), 2.0 * expected.strain_energy) << "some of it is in the springs";
        converse({false, "elements=hyperelastic"});
        const auto expected_large = solved_standing(young_modulus, 0.3, judge);
        const auto found = displacement(converse(binary(rows)));
        double off = 0.0, size = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            off = std::max(off, (found[i].cast<double>() - expected_large.displacement[i]).norm());
            size = std::max(size, expected_large.displacement[i].norm());
        }
        EXPECT_GT(size, 1e-6);
        EXPECT_LT(off, 1e-4 * size);
    }
}

TEST_F(LiveFemTest, ReportsWhatTheFirstSolutionWaitsFor) {
    std::vector<std::string> told;
    const auto converse = begin("box.h5", [&](const std::string &sentence) {
        told.push_back(sentence);
        return true;
    });
    const Rows rows{{1.0 * free[0], 30.0, -20.0, 10.0}};
    converse(binary(rows));
    ASSERT_EQ(told.size(), 2U);
    EXPECT_NE(told[0].find("are being assembled"), std::string::npos);
    EXPECT_NE(told[1].find("is being factorised"), std::string::npos);
    converse(binary(rows));
    EXPECT_EQ(told.size(), 2U);
}

TEST_F(LiveFemTest, LiesStillWhereNothingPullsAtWhatIsFree) {
    const auto converse = begin();
    const std::vector<Eigen::Vector3f> rest(mesh.points.size(), Eigen::Vector3f::Zero());
    EXPECT_EQ(displacement(converse({true, ""})), rest);
    EXPECT_EQ(work(converse({true, ""})), 0.0);
    EXPECT_EQ(displacement(converse(binary({}))), rest);
    EXPECT_EQ(displacement(converse(binary({{1.0 * constrained[0], 1e3, 1e3, 1e3}}))), rest);
    EXPECT_EQ(displacement(converse(binary({{1.0 * free[0], 0.0, 0.0, 0.0}}))), rest);
}

TEST_F(LiveFemTest, RefusesMessagesAndGoesOn) {
    const auto converse = begin();
    const Rows rows{{1.0 * free[0], 30.0, -20.0, 10.0}};
    const auto before = displacement(converse(binary(rows)));
    const auto fault_of_rows = [&](const Rows &wrong) { return fault_of([&] { converse(binary(wrong)); }); };
    const double end = mesh.num_boundary_triangles();
    for (const double facet : {-1.0, end, 0.5, 1e300, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_NE(fault_of_rows({rows[0], {facet, 0.0, 0.0, 1.0}}).find("is no facet; send whole numbers from 0 to"),
                  std::string::npos)
            << facet;
    EXPECT_EQ(fault_of_rows({{0.0, 0.0, std::numeric_limits<double>::infinity(), 0.0}}),
              "row 0: the traction is not finite; send numbers in Pa");
    EXPECT_EQ(fault_of_rows({{2.0, 0.0, 0.0, 1.0}, {3.0, 0.0, 0.0, 1.0}, {2.0, 0.0, 0.0, 1.0}}),
              "row 2: facet 2 has a traction already; send the sum of the two");
    EXPECT_EQ(fault_of_rows({{1.0 * free[0], 1e300, 0.0, 0.0}}),
              "the body moves farther than a float32 can say; send smaller tractions");
    const double nowhere = std::numeric_limits<double>::quiet_NaN();
    for (const auto &load : {core::RoundLoad{{nowhere, 0.0, 0.0}, 0.1},
                             {{0.0, 0.0, 0.0}, -1.0},
                             {{0.0, 0.0, 0.0}, 1e3},
                             {{0.0, 0.0, 0.0}, nowhere}})
        EXPECT_NE(fault_of([&] { converse(binary(rows, load)); }).find("is none; send a finite middle"),
                  std::string::npos);
    for (const std::size_t size : {1U, 31U, 33U})
        EXPECT_NE(fault_of([&] {
                      converse({true, std::string(size, '\0')});
                  }).find("no whole rows"),
                  std::string::npos);
    for (const auto *text : {"", "young_modulus=4000", "poisson_ratio=0.3", "young_modulus=0.5&poisson_ratio=0.3",
                             "young_modulus=2e9&poisson_ratio=0.3", "young_modulus=4000&poisson_ratio=0.5",
                             "young_modulus=4000&poisson_ratio=-0.1", "young_modulus=nan&poisson_ratio=0.3",
                             "young_modulus=%&poisson_ratio=0.3"})
        EXPECT_NE(fault_of([&] { converse({false, text}); }), "no fault") << text;
    EXPECT_EQ(displacement(converse(binary(rows))), before);
}

TEST_F(LiveFemTest, RefusesFilesThatTheServerDoesNotShow) {
    std::ofstream(folder / "text.h5") << "text";
    fs::create_symlink("/etc/passwd", folder / "secret.h5");
    for (const auto *file : {"", "none.h5", "text.h5", "secret.h5", "../box.h5", "./box.h5", "/etc/passwd", "box"})
        EXPECT_NE(fault_of([&] { begin(file); }), "no fault") << file;
    EXPECT_EQ(fault_of([&] { server::live_fem(folder, {}, report_to_nobody); }), "file is missing; add file=...");
}

TEST_F(LiveFemTest, RefusesABodyThatNothingHoldsStill) {
    auto sliding_only = result;
    for (const int facet : constrained)
        sliding_only.problem.load_case.value[facet] = {1e-3, 0.0, 0.0};
    results::write_result(folder / "moved.h5", sliding_only);
    EXPECT_NE(fault_of([&] { begin("moved.h5"); }).find("does not fix any part of the surface"), std::string::npos);
}

} // namespace
} // namespace livermark::studies
