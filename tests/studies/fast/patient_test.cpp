#include "studies/sensitivity/patient.hpp"

#include <gtest/gtest.h>

#include "load_cases/places/facets.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "models/model_table.hpp"
#include "studies/sensitivity/outputs.hpp"
#include "studies/sensitivity/ranges.hpp"
#include "support/known_names.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/test_meshes.hpp"

#include <fstream>

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

TEST(Patient, IsSofterWithLessThatHoldsAndWithASofterSupport) {
    const auto nominal = pressed_block();
    const double firm = stiffness_of(nominal, {});
    const double less = stiffness_of(nominal, {.held_share = 0.5});
    const double soft = stiffness_of(nominal, {.support_stiffness = 1e5});
    EXPECT_LT(less, 0.999 * firm);
    EXPECT_LT(soft, 0.99 * firm);
    EXPECT_LT(stiffness_of(nominal, {.held_share = 0.5, .support_stiffness = 1e5}), std::min(less, soft));
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
    auto other = values;
    other.values[0] *= 1.1;
    other.tumour *= 0.8;
    const auto differences = relative_differences(outputs, other, values);
    EXPECT_NEAR(differences[0], 0.1, 1e-12);
    EXPECT_NEAR(differences[2], 0.2, 1e-12);
}

class RangesFile : public tests::ResultFolder {
  protected:
    Ranges read(const std::string &text) const {
        std::ofstream(directory_ / "ranges.toml") << text;
        return read_ranges(directory_ / "ranges.toml");
    }
};

TEST_F(RangesFile, SaysWhatIsNotKnown) {
    const auto ranges = read("[young_modulus]\nfrom = 4000\nto = 6000\nsource = \"a\"\n[tool_offset]\nfrom = -0.01\n"
                             "to = 0.01\nsource = \"b\"\n[measurement]\ndisplacement = 0.001\nsource = \"c\"\n");
    ASSERT_EQ(ranges.parameters.size(), 3u);
    EXPECT_EQ(ranges.parameters[2].name, "tool_offset_2");
    EXPECT_EQ(ranges.displacement_noise, 0.001);
    const auto patient = patient_of(ranges.parameters, {4500.0, 0.001, 0.002});
    EXPECT_EQ(patient.young_modulus, 4500.0);
    EXPECT_EQ(*patient.tool_offset, Eigen::Vector2d(0.001, 0.002));
    EXPECT_FALSE(patient.held_share);
}

TEST_F(RangesFile, RefusesWhatCannotBe) {
    const auto expect_refused = [&](const std::string &text, const std::vector<std::string> &parts) {
        tests::expect_input_error([&] { read(text); }, parts);
    };
    expect_refused("[measurement]\ndisplacement = 0.001\nsource = \"a\"\n", {"no range", "young_modulus"});
    expect_refused("[poisson_ratio]\nfrom = 0.4\nto = 0.5\nsource = \"a\"\n", {"poisson_ratio", "0.5"});
    expect_refused("[held_share]\nfrom = 0.4\nto = 1.1\nsource = \"a\"\n", {"held_share", "1.1"});
    expect_refused("[density]\nfrom = 1000\nto = 900\nsource = \"a\"\n", {"density", "larger"});
    expect_refused("[density]\nfrom = 1000\nto = 1100\n", {"source"});
    expect_refused("[youngs_modulus]\nfrom = 1000\nto = 1100\nsource = \"a\"\n", {"young_modulus"});
    expect_refused("[tool_offset]\nfrom = -1\nto = 1\nscale = \"logarithmic\"\nsource = \"a\"\n", {"logarithm"});
}

TEST(ActingParameters, LeaveOutWhatHasNoEffectAndSayWhy) {
    auto nominal = pressed_block();
    Ranges ranges;
    for (const auto *name : {"young_modulus", "density", "tumour_contrast", "tool_offset_1", "tool_offset_2"})
        ranges.parameters.push_back({name, "", "parameters", 1.0, 2.0, false, "made up"});
    auto acting = acting_on(nominal, ranges);
    ASSERT_EQ(acting.notes.size(), 1u);
    EXPECT_NE(acting.notes[0].find("density"), std::string::npos);
    EXPECT_EQ(acting.parameters.size(), 4u);
    nominal.load_case.acceleration = {0.0, 0.0, -1.0};
    for (auto &condition : nominal.load_case.conditions)
        condition.round.reset();
    acting = acting_on(nominal, ranges);
    ASSERT_EQ(acting.notes.size(), 1u);
    EXPECT_NE(acting.notes[0].find("tool_offset"), std::string::npos);
    EXPECT_EQ(acting.parameters.size(), 3u);
}

} // namespace
} // namespace livermark::studies
