#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <string>

#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/cutting/cut_parts.hpp"
#include "msm/elastic_body.hpp"
#include "tests/cut_checks.hpp"

namespace livermark {
namespace {

using live::Scene;

live::Settings settings_of(const core::Body &body) {
    const auto &material = body.materials[live::largest_region(body.mesh)];
    return {.springs = "nodal_neo_hookean",
            .young_modulus = material.young_modulus,
            .poisson_ratio = 0.45,
            .damping = {10.0, 0.0}};
}

/// Boundary triangles in a corner of the body, at its lowest x: a tenth of them.
std::vector<bool> held_at_an_end(const core::TetraMesh &mesh) {
    std::vector<double> x;
    for (const auto &[a, b, c] : mesh.boundary_triangles)
        x.push_back(mesh.points[a].x() + mesh.points[b].x() + mesh.points[c].x());
    auto sorted = x;
    std::ranges::sort(sorted);
    std::vector<bool> held;
    for (const double each : x)
        held.push_back(each <= sorted[sorted.size() / 10]);
    return held;
}

/// The numbers of springs that a cut is found around alone, beside those of what is left set up from nothing.
std::string fault_of_numbers(const core::Body &own, const std::vector<int> &gone) {
    const auto settings = settings_of(own);
    const auto body = live::with_material(own, settings.young_modulus, settings.poisson_ratio);
    live::SpringsOfLaws kept, rest_springs;
    const auto springs = live::mass_springs(own, settings, kept);
    auto parts = msm::CutParts::prepare(body, springs.body, live::spring_source(own, settings)).value();
    parts.remove(gone);
    std::vector<char> is_there(body.mesh.tetrahedra.size(), 1);
    for (const int t : gone)
        is_there[t] = 0;
    msm::NodalConditions none;
    none.displacement.assign(body.mesh.points.size(), core::Vector3::Zero());
    const auto rest = msm::part_of_body(body, is_there, none);
    auto settings_of_rest = settings;
    settings_of_rest.young_modulus = rest.body.materials[live::largest_region(rest.body.mesh)].young_modulus;
    const auto elastic = live::mass_springs(rest.body, settings_of_rest, rest_springs).body;
    const auto anew = msm::step_parts(msm::part_terms(elastic).in_kernels).value();
    for (std::size_t i = 0; i < rest.node.size(); ++i)
        if (parts.node_mass()[rest.node[i]] != elastic.node_mass[i])
            return fmt::format("node {} has another mass", rest.node[i]);
    const auto &now = parts.parts();
    std::size_t t_anew = 0;
    for (std::size_t t = 0; t < is_there.size(); ++t) {
        if (now.is_there(t) != (is_there[t] != 0))
            return fmt::format("tetrahedron {} is there or not", t);
        if (is_there[t] == 0)
            continue;
        for (std::size_t k = 0; k < 4; ++k) {
            const int c = now.corner_volume[t][k], d = anew.corner_volume[t_anew][k];
            if (now.coupled_modulus[c] != anew.coupled_modulus[d] ||
                now.volume_stiffness[c] != anew.volume_stiffness[d])
                return fmt::format("tetrahedron {} has other springs", t);
        }
        ++t_anew;
    }
    return t_anew == anew.tetrahedra.size() ? "" : "there are more or fewer tetrahedra";
}

std::string fault_of_remains(const Scene &scene) {
    const auto gone = scene.gone();
    const auto &left = scene.remains();
    std::vector<int> count(scene.body().mesh.tetrahedra.size(), 0);
    for (const auto *list : {&gone, &left.tetrahedron})
        for (const int t : *list)
            ++count[t];
    if (!std::ranges::all_of(count, [](int times) { return times == 1; }))
        return "a tetrahedron is lost, or there twice";
    for (std::size_t t = 0; t < left.tetrahedron.size(); ++t)
        if (left.mesh.tetrahedra[t] != scene.body().mesh.tetrahedra[left.tetrahedron[t]])
            return fmt::format("tetrahedron {} has other nodes", left.tetrahedron[t]);
    return tests::fault_of_surface(left.mesh);
}

/// The healthy liver as it ships, or with a capsule, a vessel through its middle and a map of stiffness.
core::Body body_of(const std::string &name) {
    const bool is_covered = name == "liver_covered";
    auto body = meshes::read_body(LIVERMARK_SOURCE_DIR "/meshes/" + (is_covered ? "liver_healthy" : name) + ".toml");
    if (!is_covered)
        return body;
    const auto box = core::bounding_box(body.mesh.points);
    body.capsule = core::Capsule{.thickness = 20e-6, .young_modulus = 8.22e6};
    body.vessels = core::VesselTree{.points = {box.min() + 0.2 * box.diagonal(), box.min() + 0.8 * box.diagonal()},
                                    .radius = {4e-3, 2e-3},
                                    .segments = {{0, 1}},
                                    .wall_ratio = 0.2,
                                    .wall_modulus = 1e6};
    for (const auto &nodes : body.mesh.tetrahedra)
        body.modulus_factor.push_back(0.7 + 0.6 * (body.mesh.points[nodes[0]].x() - box.min().x()) / box.sizes().x());
    return body;
}

class LiveRandomCuts : public testing::TestWithParam<const char *> {};

/// More than a thousand of all bodies together: each is whole again afterwards, and moves to the bit as before.
TEST_P(LiveRandomCuts, LeaveASoundBodyThatMovesOrAreRefused) {
    const auto body = body_of(GetParam());
    int num_parted = 0;
    const auto held = held_at_an_end(body.mesh);
    Scene scene(body, held);
    scene.choose(settings_of(body));
    std::mt19937 random(7);
    constexpr int num_cuts = 334, between_full_set_ups = 10, num_steps = 3;
    int num_made = 0, num_refused = 0;
    double largest_seconds = 0.0;
    for (int c = 0; c < num_cuts; ++c) {
        const auto tool = tests::random_cut(body, random).tool;
        const auto *blade = std::get_if<meshes::BladeCut>(&tool);
        const bool parts = blade && blade->thickness == 0.0;
        const live::CutRequest request{.tool = tool, .keeps_margin = c % 2 == 0, .takes_loose = random() % 3 != 0};
        const auto before = scene.move({}, 0);
        try {
            const auto reading = scene.cut(request);
            if (!parts) // these are set up anew
                largest_seconds = std::max(largest_seconds, reading.seconds_of_springs);
        } catch (const support::InputError &) {
            ++num_refused;
            ASSERT_TRUE(scene.gone().empty());
            ASSERT_EQ(scene.move({}, 0).displacement, before.displacement) << c;
            continue;
        }
        ++num_made;
        num_parted += parts;
        EXPECT_EQ(fault_of_remains(scene), "") << c << ' ' << meshes::to_text(tool);
        if (num_made % between_full_set_ups == 1 && !parts) {
            EXPECT_EQ(fault_of_numbers(body, scene.gone()), "") << c << ' ' << meshes::to_text(tool);
        }
        const auto frame = scene.move({}, num_steps);
        EXPECT_EQ(frame.restarts, 0) << c;
        EXPECT_TRUE(std::isfinite(frame.largest_speed)) << c;
        scene.restore();
        ASSERT_TRUE(scene.gone().empty());
        const auto after = scene.move({}, 0);
        ASSERT_EQ(after.displacement, before.displacement) << c;
    }
    fmt::print("{}: {} cut, {} refused, springs in {:.1f} ms at most\n", GetParam(), num_made, num_refused,
               1e3 * largest_seconds);
    EXPECT_GT(num_made, 60);
    EXPECT_GT(num_parted, 5);
    EXPECT_GT(num_refused, 20);
}

INSTANTIATE_TEST_SUITE_P(Bodies, LiveRandomCuts,
                         testing::Values("liver_healthy", "liver_tumours", "liver_covered", "beam"));

} // namespace
} // namespace livermark
