#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "load_cases/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/test_meshes.hpp"

namespace livermark {
namespace {

const std::string good = R"(title = "Press and hold"
target_peak_displacement = 0.002
acceleration = [0.0, 0, -0.1]

[[condition]]
patch = "x_min"
displacement = [0.0, "free", 0.001]

[[condition]]
disc = { patch = "z_max", radius = 0.02 }
pressure = 300
)";

core::TetraMesh block() {
    return tests::box_mesh({0.1, 0.1, 0.1}, {10, 10, 10});
}

core::LoadCase parse(const std::string &text) {
    return load_cases::parse_load_case(text, "press.toml", block());
}

std::string replaced(std::string text, const std::string &from, const std::string &to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(LoadCaseReader, KeepsNameTextAndNumbers) {
    const auto load_case = parse(good);
    EXPECT_EQ(load_case.name, "press");
    EXPECT_EQ(load_case.title, "Press and hold");
    EXPECT_EQ(load_case.definition, good);
    EXPECT_EQ(load_case.target_peak_displacement, 0.002);
    EXPECT_EQ(load_case.acceleration, core::Vector3(0.0, 0.0, -0.1));
}

TEST(LoadCaseReader, PutsDisplacementsOnThePatchWithFreeComponents) {
    const auto mesh = block();
    const auto load_case = parse(good);
    EXPECT_EQ(load_case.constraint_names, std::vector<std::string>{"x_min"});
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.boundary_patch[f] == 0) {
            EXPECT_EQ(load_case.condition[f], core::FacetCondition::prescribed_displacement);
            EXPECT_EQ(load_case.value[f].x(), 0.0);
            EXPECT_TRUE(std::isnan(load_case.value[f].y()));
            EXPECT_EQ(load_case.value[f].z(), 0.001);
            EXPECT_EQ(load_case.constraint[f], 0);
        } else
            EXPECT_EQ(load_case.constraint[f], -1);
}

TEST(LoadCaseReader, PressureOnADiscPushesInwardInItsMiddle) {
    const auto mesh = block();
    const auto load_case = parse(good);
    core::Vector3 force = core::Vector3::Zero();
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.condition[f] == core::FacetCondition::traction) {
            EXPECT_LT(load_case.value[f].head<2>().norm(), 1e-10);
            for (const int node : mesh.boundary_triangles[f])
                EXPECT_LT((mesh.points[node] - core::Vector3(0.05, 0.05, 0.1)).norm(), 0.035);
            force += core::area_vector(mesh, f).norm() * load_case.value[f];
        }
    EXPECT_NEAR(force.z(), -300.0 * std::numbers::pi * 0.02 * 0.02, 1e-12); // that of the disc, not of its facets
}

struct BadLoadCase {
    const char *name;
    std::string text;
    std::vector<std::string> message;
};

class BadLoadCaseToml : public testing::TestWithParam<BadLoadCase> {};

TEST_P(BadLoadCaseToml, IsRefusedWithPlaceAndRemedy) {
    tests::expect_input_error([] { parse(GetParam().text); }, GetParam().message);
}

const std::vector<BadLoadCase> bad_load_cases{
    {"NotToml", "title = ", {"press.toml:1:", "not TOML"}},
    {"NoTitle", replaced(good, "title = \"Press and hold\"\n", ""), {"press.toml:1:", "'title' is missing"}},
    {"TitleIsANumber", replaced(good, "\"Press and hold\"", "3"), {"press.toml:1:", "string in quotes"}},
    {"MisspeltKey",
     replaced(good, "acceleration", "accelleration"),
     {"press.toml:3:", "unknown key 'accelleration'", "did you mean 'acceleration'"}},
    {"MisspeltConditionKey", replaced(good, "pressure", "presure"), {"press.toml:11:", "did you mean 'pressure'"}},
    {"UnknownPatch",
     replaced(good, "patch = \"x_min\"", "patch = \"xmin\""),
     {"press.toml:6:", "no patch 'xmin'", "x_min"}},
    {"NoCondition", "title = \"t\"\ntarget_peak_displacement = 1.0\n", {"no [[condition]]"}},
    {"ConditionIsNoTable", "title = \"t\"\ntarget_peak_displacement = 1.0\ncondition = 3\n", {"no [[condition]]"}},
    {"NothingHolds",
     replaced(good, "displacement = [0.0, \"free\", 0.001]", "traction = [1.0, 0.0, 0.0]"),
     {"nothing holds the body", "displacement"}},
    {"FreeInEveryDirection",
     replaced(good, "[0.0, \"free\", 0.001]", "[\"free\", \"free\", \"free\"]"),
     {"holds nothing"}},
    {"TwoNumbers", replaced(good, "[0.0, \"free\", 0.001]", "[0.0, 0.001]"), {"press.toml:7:", "three finite numbers"}},
    {"NaNTraction", replaced(good, "pressure = 300", "traction = [nan, 0.0, 0.0]"), {"three finite numbers"}},
    {"InfinitePressure", replaced(good, "pressure = 300", "pressure = inf"), {"finite number"}},
    {"PressureInWords", replaced(good, "pressure = 300", "pressure = \"300 Pa\""), {"finite number"}},
    {"TwoEffects", good + "traction = [1.0, 0.0, 0.0]\n", {"give one of them"}},
    {"NoEffect", replaced(good, "pressure = 300\n", ""), {"give one of them"}},
    {"TwoPlaces", good + "patch = \"x_max\"\n", {"give one of them"}},
    {"NegativeRadius", replaced(good, "radius = 0.02", "radius = -0.02"), {"positive"}},
    {"Overlap", good + "\n[[condition]]\npatch = \"z_max\"\npressure = 1.0\n", {"have a condition already"}},
    {"Contradiction",
     good + "\n[[condition]]\npatch = \"y_min\"\ndisplacement = [0.0, 0.0, 0.002]\n",
     {"prescribes a displacement of", "keep them apart"}},
    {"NegativeTarget", replaced(good, "= 0.002", "= -0.002"), {"press.toml:2:", "positive"}},
};

INSTANTIATE_TEST_SUITE_P(Files, BadLoadCaseToml, testing::ValuesIn(bad_load_cases),
                         [](const auto &info) { return std::string(info.param.name); });

TEST(LoadCaseReader, RefusesAMissingFile) {
    tests::expect_input_error([] { load_cases::read_load_case("no_such.toml", block()); }, {"no_such.toml"});
}

} // namespace
} // namespace livermark
