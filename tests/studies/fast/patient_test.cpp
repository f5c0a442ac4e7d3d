#include "studies/sensitivity/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <set>

#include "core/support/input_error.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

using core::Vector3;

constexpr const char *press_text = R"(
title = "Press"
[[condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
disc = { patch = "z_max", radius = 0.02, profile = "round" }
pressure = 100.0
)";

/// A block with a stiff lump in its middle, pressed by a round tool.
core::Problem pressed_block() {
    auto mesh = tests::box_mesh({0.1, 0.1, 0.06}, {5, 5, 3});
    mesh.region_names = {"soft", "lump"};
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        Vector3 middle = Vector3::Zero();
        for (const int node : mesh.tetrahedra[t])
            middle += mesh.points[node] / 4.0;
        mesh.region[t] = (middle - Vector3(0.05, 0.05, 0.03)).norm() < 0.02 ? 1 : 0;
    }
    const core::Material soft{1000.0, 5000.0, 0.45}, stiff{1000.0, 30000.0, 0.45};
    auto body = std::make_shared<core::Body>(core::Body{"block", std::move(mesh), {soft, stiff}});
    return {body, load_cases::parse_load_case(press_text, "press.toml", body->mesh)};
}

double stiffness_of(const core::Problem &nominal, const Patient &patient) {
    const auto known = models::all_models();
    const auto problem = problem_of(patient, nominal);
    const auto outputs = outputs_of(nominal);
    return values_of(outputs, nominal, problem, support::find_named(known, "fem_p1", "model").solve(problem))
        .values.front();
}

TEST(Patient, IsTheNominalOneWhereNothingIsSet) {
    const auto nominal = pressed_block();
    const auto problem = problem_of({}, nominal);
    EXPECT_TRUE(core::are_statically_equal(problem.load_case, nominal.load_case));
    EXPECT_EQ(problem.body->materials[1].young_modulus, 30000.0);
    EXPECT_EQ(stiffness_of(nominal, {.young_modulus = 5000.0, .tumour_contrast = 6.0}), stiffness_of(nominal, {}));
}

TEST(Patient, HasTheParametersThatAreNamed) {
    const auto patient =
        patient_of({"young_modulus", "shear_left", "tool_offset_1", "tool_offset_2"}, {4500.0, 0.7, 0.001, 0.002});
    EXPECT_EQ(patient.young_modulus, 4500.0);
    EXPECT_EQ(patient.shear_left, 0.7);
    EXPECT_EQ(patient.tool_offset, Eigen::Vector2d(0.001, 0.002));
    EXPECT_FALSE(patient.held_share);
}

/// The small regime is linear: twice the modulus of all that gives way is twice the stiffness; density does nothing.
TEST(Patient, IsAsStiffAsItsModulusSays) {
    const auto nominal = pressed_block();
    const Patient patient{.young_modulus = 4000.0, .tumour_contrast = 5.0, .held_share = 0.6, .support_stiffness = 2e5};
    auto stiffer = patient;
    stiffer.young_modulus = 8000.0;
    stiffer.support_stiffness = 4e5;
    stiffer.density = 2000.0;
    EXPECT_NEAR(stiffness_of(nominal, stiffer) / stiffness_of(nominal, patient), 2.0, 1e-9);
}

/// Block with a map whose factors are 1 and 2 in turn.
core::Problem mapped_block() {
    auto nominal = pressed_block();
    auto body = *nominal.body;
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t)
        body.modulus_factor.push_back(t % 2 == 0 ? 1.0 : 2.0);
    nominal.body = std::make_shared<core::Body>(body);
    return nominal;
}

TEST(Patient, HasAMapWithItsOwnContrastAndSlope) {
    const auto nominal = mapped_block();
    EXPECT_EQ(problem_of({.map_contrast = 1.0, .map_slope = 0.0}, nominal).body->modulus_factor,
              nominal.body->modulus_factor);
    const auto flat = problem_of({.map_contrast = 1e-12}, nominal).body->modulus_factor;
    EXPECT_NEAR(*std::ranges::max_element(flat), 1.0, 1e-9);
    const auto squared = problem_of({.map_contrast = 2.0}, nominal).body->modulus_factor;
    EXPECT_EQ(std::set(squared.begin(), squared.end()), (std::set{1.0, 4.0}));
    const auto sloped = problem_of({.map_contrast = 1e-12, .map_slope = 0.4}, nominal).body->modulus_factor;
    const auto [anterior, posterior] = std::ranges::minmax_element(sloped);
    EXPECT_NEAR(*posterior / *anterior, std::exp(0.4), 1e-9);
    const auto &mesh = nominal.body->mesh;
    const auto y_of = [&](auto place) { return mesh.points[mesh.tetrahedra[place - sloped.begin()][0]].y(); };
    EXPECT_LT(y_of(anterior), y_of(posterior));
    EXPECT_LT(stiffness_of(nominal, {.map_contrast = 0.5}), stiffness_of(nominal, {}));
    EXPECT_TRUE(problem_of({.map_contrast = 2.0}, pressed_block()).body->modulus_factor.empty());
}

/// Tissue that has relaxed has less of its shear modulus and all of its bulk modulus, in every region.
TEST(Patient, KeepsItsBulkModulusWhereItHasRelaxed) {
    const auto nominal = pressed_block();
    const auto relaxed = problem_of({.shear_left = 0.4}, nominal);
    for (std::size_t r = 0; r < nominal.body->materials.size(); ++r) {
        const auto &before = nominal.body->materials[r], &after = relaxed.body->materials[r];
        const auto bulk = [](const core::Material &material) {
            return material.lame_lambda() + 2.0 / 3.0 * material.shear_modulus();
        };
        EXPECT_NEAR(after.shear_modulus() / before.shear_modulus(), 0.4, 1e-12);
        EXPECT_NEAR(bulk(after) / bulk(before), 1.0, 1e-12);
    }
    EXPECT_NEAR(stiffness_of(nominal, {.shear_left = 1.0}) / stiffness_of(nominal, {}), 1.0, 1e-9);
    const double left = stiffness_of(nominal, {.shear_left = 0.4}) / stiffness_of(nominal, {});
    EXPECT_GT(left, 0.4) << "what does not relax bears a part";
    EXPECT_LT(left, 0.7);
}

TEST(Patient, IsSofterWithLessThatHoldsAndWithASofterSupport) {
    const auto nominal = pressed_block();
    const double firm = stiffness_of(nominal, {});
    const double less = stiffness_of(nominal, {.held_share = 0.5});
    const double soft = stiffness_of(nominal, {.support_stiffness = 1e5});
    EXPECT_LT(less, 0.999 * firm);
    EXPECT_LT(soft, 0.99 * firm);
    EXPECT_LT(stiffness_of(nominal, {.held_share = 0.5, .support_stiffness = 1e5}), std::min(less, soft));
}

/// A capsule of next to nothing does next to nothing, whatever holds the body, and a real one holds it together; none
/// is on the layer that stands for ligaments.
TEST(Patient, HasTheCapsuleThatItIsGiven) {
    const auto nominal = pressed_block();
    for (const auto support : {std::optional<double>(), std::optional(1e5)}) {
        const double bare = stiffness_of(nominal, {.support_stiffness = support});
        const double thin = stiffness_of(nominal, {.capsule_stiffness = 1e-9, .support_stiffness = support});
        EXPECT_NEAR(thin / bare, 1.0, 1e-9);
        EXPECT_GT(stiffness_of(nominal, {.capsule_stiffness = 160.0, .support_stiffness = support}), 1.01 * bare);
    }
    const auto supported = problem_of({.capsule_stiffness = 160.0, .support_stiffness = 1e5}, nominal);
    const auto &mesh = supported.body->mesh;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        for (const int node : mesh.boundary_triangles[f])
            if (node >= nominal.body->mesh.num_nodes()) {
                EXPECT_FALSE(core::Capsule::covers(mesh, f));
            }
    EXPECT_NEAR(supported.body->capsule->stiffness(), 160.0, 1e-9);
}

TEST(HeldShare, IsThatPartOfTheArea) {
    const auto nominal = pressed_block();
    const auto &mesh = nominal.body->mesh;
    const double all = load_cases::area_of(held_facets(nominal.load_case), mesh);
    for (const double share : {0.25, 0.5, 1.0}) {
        const auto held = held_facets(with_held_share(nominal.load_case, mesh, share));
        EXPECT_NEAR(load_cases::area_of(held, mesh) / all, share, 1.0 / 50.0) << "one facet of 50";
    }
}

TEST(TumourRegions, AreTheStiffOnesButForVessels) {
    auto body = *pressed_block().body;
    EXPECT_EQ(tumour_regions(body), std::vector{1});
    body.mesh.region_names[1] = "vessel_portal";
    EXPECT_TRUE(tumour_regions(body).empty());
}

TEST(MovedTool, IsWhereItWasWithoutAnOffsetAndKeepsItsForce) {
    const auto nominal = pressed_block();
    const auto &mesh = nominal.body->mesh;
    ASSERT_TRUE(has_movable_tool(nominal.load_case));
    const auto there = core::scaled(nominal.load_case, 1.5);
    EXPECT_TRUE(core::are_statically_equal(with_tool_moved(there, *nominal.body, {0.0, 0.0}), there));
    const auto moved = with_tool_moved(there, *nominal.body, {0.02, -0.01});
    EXPECT_NEAR((moved.round_loads()[0].middle - Vector3(0.07, 0.04, 0.06)).norm(), 0.0, 1e-12);
    const auto force = [&](const core::LoadCase &load_case) {
        Vector3 sum = Vector3::Zero();
        for (std::size_t f = 0; f < load_case.value.size(); ++f)
            if (load_case.is_loaded(f))
                sum += core::area_vector(mesh, static_cast<int>(f)).norm() * load_case.value[f];
        return sum;
    };
    EXPECT_NEAR((force(moved) - force(there)).norm(), 0.0, 1e-9);
}

TEST(SensitivityOutputs, MoveTheTumourLessThanTheTool) {
    const auto nominal = pressed_block();
    const auto outputs = outputs_of(nominal);
    EXPECT_EQ(outputs,
              (std::vector{Output::stiffness_at_tool, Output::peak_displacement, Output::tumour_displacement}));
    const auto known = models::all_models();
    const auto values =
        values_of(outputs, nominal, nominal, support::find_named(known, "fem_p1", "model").solve(nominal));
    EXPECT_GT(values.values[0], 0.0);
    EXPECT_LT(values.tumour.z(), 0.0);
    EXPECT_LT(values.values[2], values.values[1]);
}

constexpr double area = 0.06 * 0.05, length = 0.08; // m^2, m

/// A bar along x, held at one end.
core::Problem bar(double young_modulus, double poisson_ratio) {
    const auto body =
        tests::make_body(tests::box_mesh({length, 0.06, 0.05}, {4, 3, 3}), {1000.0, young_modulus, poisson_ratio});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", Vector3::Zero());
    return {body, load_case};
}

core::Solution solve(const std::string &model, const core::Problem &problem) {
    const auto known = models::all_models();
    return support::find_named(known, model, "model").solve(problem);
}

/// Area mean over a side of the bar.
Vector3 mean_at(const core::Problem &nominal, const core::Solution &solution, double x) {
    Vector3 sum = Vector3::Zero();
    int count = 0;
    for (int i = 0; i < nominal.body->mesh.num_nodes(); ++i)
        if (std::abs(nominal.body->mesh.points[i].x() - x) < 1e-9) {
            sum += solution.displacement[i];
            ++count;
        }
    return sum / count;
}

/// Two springs in series: sigma L / E of the bar and sigma / k of the support.
TEST(SoftSupport, AddsItsOwnComplianceInSeries) {
    constexpr double traction = 40.0;
    auto nominal = bar(5000.0, 0.0);
    tests::pull(nominal.load_case, nominal.body->mesh, "x_max", {traction, 0.0, 0.0});
    for (const auto *model : {"fem_p1", "fem_p2p1"})
        for (const double stiffness : {1e4, 1e5, 1e6}) {
            const auto solution = solve(model, with_soft_support(nominal, stiffness));
            ASSERT_EQ(solution.status, core::SolutionStatus::ok) << solution.message;
            EXPECT_NEAR(mean_at(nominal, solution, 0.0).x(), traction / stiffness, 0.03 * traction / stiffness)
                << model;
            const double expected = traction * length / 5000.0 + traction / stiffness;
            EXPECT_NEAR(mean_at(nominal, solution, length).x(), expected, 0.01 * expected) << model;
        }
}

/// A body as good as rigid under its weight across the support moves by F / (k_t A).
TEST(SoftSupport, GivesWayAlongTheSurfaceByItsShearRatio) {
    auto nominal = bar(1e9, 0.0);
    nominal.load_case.acceleration = {0.0, 0.5, 0.0};
    constexpr double stiffness = 1e6;
    const auto solution = solve("fem_p1", with_soft_support(nominal, stiffness));
    const double force = 0.5 * 1000.0 * length * area;
    const double expected = force / (support_shear_ratio * stiffness * area);
    EXPECT_NEAR(mean_at(nominal, solution, 0.0).y(), expected, 0.03 * expected);
}

TEST(SoftSupport, TendsToWhatIsHeldFirmly) {
    auto nominal = bar(5000.0, 0.45);
    tests::pull(nominal.load_case, nominal.body->mesh, "x_max", {0.0, 20.0, 0.0});
    const auto firm = solve("fem_p1", nominal), nearly = solve("fem_p1", with_soft_support(nominal, 1e10));
    EXPECT_NEAR(mean_at(nominal, nearly, length).y(), mean_at(nominal, firm, length).y(),
                1e-3 * mean_at(nominal, firm, length).y());
}

TEST(SoftSupport, KeepsNodesAndFacetsOfTheBodyAndClosesTheSurface) {
    auto nominal = bar(5000.0, 0.3);
    tests::pull(nominal.load_case, nominal.body->mesh, "x_max", {40.0, 0.0, 0.0});
    const auto problem = with_soft_support(nominal, 1e6);
    const auto &before = nominal.body->mesh, &after = problem.body->mesh;
    ASSERT_TRUE(std::equal(before.points.begin(), before.points.end(), after.points.begin()));
    ASSERT_TRUE(std::equal(before.tetrahedra.begin(), before.tetrahedra.end(), after.tetrahedra.begin()));
    for (int f = 0; f < before.num_boundary_triangles(); ++f)
        if (!nominal.load_case.is_constrained(f)) {
            EXPECT_EQ(before.boundary_triangles[f], after.boundary_triangles[f]);
        }
    EXPECT_EQ(core::outer_faces(after.tetrahedra).size(), after.boundary_triangles.size());
    Vector3 closed = Vector3::Zero();
    for (int f = 0; f < after.num_boundary_triangles(); ++f)
        closed += core::area_vector(after, f);
    EXPECT_LT(closed.norm(), 1e-15);
    EXPECT_EQ(held_facets(problem.load_case), held_facets(nominal.load_case));
    EXPECT_EQ(problem.load_case.num_facets(), after.boundary_triangles.size());
    EXPECT_EQ(after.boundary_patch.size(), after.boundary_triangles.size());
    for (const double volume : core::tetrahedron_volumes(after))
        EXPECT_GT(volume, 0.0);
}

} // namespace
} // namespace livermark::studies
