#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

const std::string good = R"(title = "Press and hold"
target_peak_displacement = 0.002
acceleration = [0.0, 0, -0.1]

[[condition]]
patch = "x_min"
displacement = [0.0, "free", 0.001]

[[condition]]
patch = "y_min"
displacement = ["free", 0.0, "free"]

[[condition]]
disc = { patch = "z_max", radius = 0.02 }
pressure = 300
)";

const std::string held_x_min = "[[condition]]\npatch = \"x_min\"\ndisplacement = [0.0, 0.0, 0.0]\n";

core::TetraMesh block() {
    return tests::box_mesh({0.1, 0.1, 0.1}, {10, 10, 10});
}

core::LoadCase parse(const std::string &text) {
    return load_cases::parse_load_case(text, "press.toml", block());
}

TEST(LoadCaseReader, KeepsNameTextAndNumbers) {
    const auto load_case = parse(good);
    EXPECT_EQ(load_case.name, "press");
    EXPECT_EQ(load_case.title, "Press and hold");
    EXPECT_EQ(load_case.definition, good);
    EXPECT_EQ(load_case.target_peak_displacement, 0.002);
    EXPECT_EQ(load_case.acceleration, core::Vector3(0.0, 0.0, -0.1));
    EXPECT_FALSE(load_case.scale_to_target);
    EXPECT_TRUE(parse("scale_to_target = true\n" + good).scale_to_target);
    EXPECT_EQ(load_case.load_scale, 1.0);
}

TEST(LoadCaseReader, PutsDisplacementsOnThePatchWithFreeComponents) {
    const auto mesh = block();
    const auto load_case = parse(good);
    EXPECT_EQ(load_case.constraint_names(), (std::vector<std::string>{"x_min", "y_min"}));
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.boundary_patch[f] == 0) {
            EXPECT_TRUE(load_case.is_constrained(f));
            EXPECT_EQ(load_case.value[f].x(), 0.0);
            EXPECT_TRUE(std::isnan(load_case.value[f].y()));
            EXPECT_EQ(load_case.value[f].z(), 0.001);
            EXPECT_EQ(load_case.constraint_on(f), 0);
        } else
            EXPECT_EQ(load_case.constraint_on(f), mesh.boundary_patch[f] == 2 ? 1 : -1);
}

TEST(LoadCaseReader, NamesThePlacesOfGivenTractions) {
    const auto unnamed = parse(good);
    ASSERT_EQ(unnamed.load_names().size(), 1U);
    for (int f = 0; f < unnamed.num_facets(); ++f)
        EXPECT_EQ(unnamed.load_on(f), unnamed.is_loaded(f) ? 0 : -1);
    const auto named = parse(good + "[[condition]]\npatch = \"x_max\"\nname = \"glove\"\ntraction = [1.0, 0.0, 0.0]\n");
    ASSERT_EQ(named.load_names().size(), 2U);
    EXPECT_EQ(named.load_names()[1], "glove");
    const auto is_glove = [](int condition) { return condition == 3; };
    EXPECT_EQ(std::ranges::count_if(named.condition_on, is_glove), std::ranges::count(block().boundary_patch, 1));
}

TEST(LoadCaseReader, PressureOnADiscPushesInwardInItsMiddle) {
    const auto mesh = block();
    const auto load_case = parse(good);
    core::Vector3 force = core::Vector3::Zero();
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f)) {
            EXPECT_LT(load_case.value[f].head<2>().norm(), 1e-10);
            for (const int node : mesh.boundary_triangles[f])
                EXPECT_LT((mesh.points[node] - core::Vector3(0.05, 0.05, 0.1)).norm(), 0.035);
            force += core::area_vector(mesh, f).norm() * load_case.value[f];
        }
    EXPECT_NEAR(force.z(), -300.0 * std::numbers::pi * 0.02 * 0.02, 1e-12); // that of the disc, not of its facets
}

const std::string letting_go = good + R"(
[release]
duration = 1
output_interval = 0.1
damping_ratio = 0.05
damping_frequencies = [2, 7.5]

[[probe]]
name = "middle"
patch = "z_max"

[[probe]]
name = "side"
patch = "x_max"
)";

TEST(LoadCaseReader, ReadsWhatHappensAfterARelease) {
    EXPECT_FALSE(parse(good).release);
    const auto mesh = block();
    const auto load_case = parse(letting_go);
    ASSERT_TRUE(load_case.release);
    const auto &release = *load_case.release;
    EXPECT_EQ(release.num_steps, 10);
    EXPECT_EQ(release.output_interval, 0.1);
    for (const double frequency : {2.0, 7.5})
        EXPECT_NEAR(release.damping.ratio(2.0 * std::numbers::pi * frequency), 0.05, 1e-15);
    EXPECT_LT(release.damping.ratio(2.0 * std::numbers::pi * 4.0), 0.05);
    ASSERT_EQ(release.probes.size(), 2u);
    EXPECT_EQ(release.probes[0].name, "middle");
    EXPECT_LT((mesh.points[release.probes[0].node] - core::Vector3(0.05, 0.05, 0.1)).norm(), 1e-12);
    EXPECT_LT((mesh.points[release.probes[1].node] - core::Vector3(0.1, 0.05, 0.05)).norm(), 1e-12);
    const auto other = parse(
        tests::replaced(letting_go, "damping_ratio = 0.05\ndamping_frequencies = [2, 7.5]", "alpha = 3\nbeta = 0.5"));
    EXPECT_EQ(other.release->damping.alpha, 3.0);
    EXPECT_EQ(other.release->damping.beta, 0.5);
}

/// Lengths are in the unit, all else is not.
TEST(LoadCaseReader, TakesLengthsInTheUnitThatItSays) {
    const std::string in_metres = R"(target_peak_displacement = 0.004
acceleration = [0.0, 0.0, -0.1]
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, "free"]
[[condition]]
patch = "y_min"
push = 0.001
[[condition]]
disc = { point = [0.05, 0.05, 0.1], radius = 0.02 }
traction = [1.0, 2.0, 3.0]
[[condition]]
edge = { between = ["x_max", "z_min"], width = 0.01, length = 0.04 }
force = [0.0, 0.0, 2.0]
)";
    const std::string in_millimetres = R"(unit = "mm"
target_peak_displacement = 4
acceleration = [0.0, 0.0, -0.1]
[[condition]]
patch = "x_min"
displacement = [0, 0.0, "free"]
[[condition]]
patch = "y_min"
push = 1
[[condition]]
disc = { point = [50, 50.0, 100], radius = 20 }
traction = [1.0, 2.0, 3.0]
[[condition]]
edge = { between = ["x_max", "z_min"], width = 10.0, length = 40.0 }
force = [0.0, 0.0, 2.0]
)";
    const auto wanted = parse(in_metres), found = parse(in_millimetres);
    EXPECT_EQ(found.condition_on, wanted.condition_on);
    EXPECT_DOUBLE_EQ(found.target_peak_displacement, wanted.target_peak_displacement);
    EXPECT_EQ(found.acceleration, wanted.acceleration);
    for (int f = 0; f < wanted.num_facets(); ++f)
        for (int c = 0; c < 3; ++c) {
            const double value = wanted.value[f][c];
            EXPECT_TRUE(std::isnan(value) || std::abs(found.value[f][c] - value) <= 1e-12 * std::abs(value)) << f;
        }
    const auto as_number = parse(tests::replaced(in_millimetres, "\"mm\"", "0.001"));
    EXPECT_TRUE(core::are_statically_equal(as_number, found));
    const auto refusals =
        tests::refusals_after({"radius = 20 -> radius = -20", "\"mm\" -> \"inch\""}, in_millimetres, parse);
    tests::expect_golden("refusals_of_units", refusals);
}

TEST(LoadCaseReader, RefusesBadFilesWithPlaceAndRemedy) {
    using Change = std::pair<const char *, std::string>;
    auto refusals = tests::refusals_after(
        {"\"Press and hold\" -> 3", "acceleration -> accelleration", "pressure -> presure",
         "patch = \"x_min\" -> patch = \"xmin\"", "[0.0, \"free\", 0.001] -> [\"free\", \"free\", \"free\"]",
         "[0.0, \"free\", 0.001] -> [0.0, 0.001]", "pressure = 300 -> traction = [nan, 0.0, 0.0]",
         "pressure = 300 -> pressure = inf", "pressure = 300 -> pressure = \"300 Pa\"", "pressure = 300\n -> ",
         "radius = 0.02 -> radius = -0.02", "[\"free\", 0.0, \"free\"] -> [\"free\", \"free\", 0.001]",
         "[[condition]] -> scale_to_target = \"yes\"\n[[condition]]", "pressure = 300 -> pressure = 1e300",
         "pressure = 300 -> traction = [0.0, 1e-300, 0.0]", "= 0.002 -> = -0.002"},
        good, parse);
    refusals += tests::refusals_after(
        {"pressure = 300 -> displacement = [0.0, 0.0, 0.0]", "duration = 1 -> duration = 1.05",
         "duration = 1 -> duration = 1e9", "duration = 1 -> duration = -1", "output_interval = 0.1\n -> ",
         "= 0.05 -> = -0.05", "[2, 7.5] -> [0, 7.5]", "[2, 7.5] -> [2]", "damping_frequencies = [2, 7.5]\n -> ",
         "[[probe]] -> alpha = 1.0\n[[probe]]", "damping_ratio = 0.05\ndamping_frequencies = [2, 7.5]\n -> ",
         "duration -> duraton", "patch = \"x_max\" -> patch = \"xmax\"", "\"side\" -> \"middle\""},
        letting_go, parse);
    for (const auto &[wrong, text] : std::vector<Change>{
             {"NotToml", "title = "},
             {"NoCondition", "title = \"t\"\ntarget_peak_displacement = 1.0\n"},
             {"ConditionIsNoTable", "title = \"t\"\ntarget_peak_displacement = 1.0\ncondition = 3\n"},
             {"NothingHolds",
              tests::replaced(
                  tests::replaced(good, "displacement = [0.0, \"free\", 0.001]", "traction = [1.0, 0.0, 0.0]"),
                  "displacement = [\"free\", 0.0, \"free\"]", "traction = [1.0, 0.0, 0.0]")},
             {"TwoEffects", good + "traction = [1.0, 0.0, 0.0]\n"},
             {"TwoPlaces", good + "patch = \"x_max\"\n"},
             {"Overlap", good + "\n[[condition]]\npatch = \"x_min\"\npressure = 1.0\n"},
             {"Contradiction", good + "\n[[condition]]\ndisc = { point = [0.004, 0.05, -0.01], radius = 0.008 }\n"
                                      "displacement = [0.0, 0.0, 0.002]\n"},
             {"BodyThatTurns", tests::replaced(good, "[0.0, \"free\"", "[\"free\", \"free\"") +
                                   "\n[[condition]]\npatch = \"z_min\"\ndisplacement = [0.0, \"free\", \"free\"]\n"},
             {"ProbeWithoutRelease", good + "[[probe]]\nname = \"a\"\npatch = \"z_max\"\n"},
             {"ReleaseWithoutProbe", letting_go.substr(0, letting_go.find("[[probe]]"))},
             {"ProbeThatIsConstrained", tests::replaced(tests::replaced(letting_go, "\"free\"", "0.0"),
                                                        "patch = \"x_max\"", "patch = \"x_min\"")},
             {"NothingToScale", "title = \"t\"\ntarget_peak_displacement = 0.001\nscale_to_target = "
                                "true\n[[condition]]\npatch = \"x_min\"\n"
                                "displacement = [0.0, \"free\", 0.0]\n"}})
        refusals += tests::refusal(wrong, [&] { parse(text); });
    refusals += tests::refusal("a missing file", [] { load_cases::read_load_case("no_such.toml", block()); });
    tests::expect_golden("refusals_of_load_cases", refusals);
}

/// A block that lies as its axes say.
core::Body block_with(core::BodyAxes axes) {
    core::Body body{.name = "block", .mesh = block(), .materials = {}};
    body.axes = std::move(axes);
    return body;
}

TEST(Directions, OfALoadCaseTurnWithTheBody) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.7, core::Vector3(0.2, -0.5, 0.8).normalized()).toRotationMatrix();
    const auto turned_body = block_with({turn, {"x_min"}, {}});
    for (const auto key : {"displacement", "press_along", "traction", "force", "torque"}) {
        const auto text = held_x_min + "[[condition]]\npatch = \"x_max\"\n" + key + " = [0.003, 2, -1.0]\n";
        const auto plain = parse(text);
        const auto turned = load_cases::parse_load_case(text, "press.toml", turned_body);
        EXPECT_EQ(turned.definition, text);
        const core::Vector3 way = turn * core::Vector3(0.003, 2.0, -1.0);
        const auto by_hand =
            parse(held_x_min + "[[condition]]\npatch = \"x_max\"\n" + key + " = [" + std::to_string(way.x()) + ", " +
                  std::to_string(way.y()) + ", " + std::to_string(way.z()) + "]\n");
        for (int f = 0; f < plain.num_facets(); ++f) {
            EXPECT_EQ(turned.is_free(f), plain.is_free(f));
            if (plain.is_free(f))
                continue;
            EXPECT_NEAR((turned.value[f] - by_hand.value[f]).norm(), 0.0, 1e-5 * (1.0 + by_hand.value[f].norm()))
                << key;
        }
        EXPECT_NEAR(turned.press_depth, plain.press_depth, 1e-12) << key;
    }
    for (const auto key : {"tangential_traction", "tangential_force"}) {
        const auto text = held_x_min + "[[condition]]\npatch = \"x_max\"\n" + key + " = [0.0, 2.0, -1.0]\n";
        const auto turned = load_cases::parse_load_case(text, "press.toml", turned_body);
        core::Vector3 along = turn * core::Vector3(0.0, 2.0, -1.0);
        along.x() = 0.0; // the normal of x_max
        for (int f = 0; f < turned.num_facets(); ++f)
            if (turned.is_loaded(f)) {
                EXPECT_NEAR(turned.value[f].normalized().dot(along.normalized()), 1.0, 1e-12) << key;
            }
    }
    const auto falling =
        load_cases::parse_load_case("acceleration = [0.0, 0, -9.81]\n" + held_x_min, "fall.toml", turned_body);
    EXPECT_NEAR((falling.acceleration - turn * core::Vector3(0.0, 0.0, -9.81)).norm(), 0.0, 1e-12);
}

TEST(Directions, OfToolsAndDiscsTurnToo) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.5 * std::numbers::pi, core::Vector3::UnitX()).toRotationMatrix();
    const auto turned_body = block_with({turn, {"x_min"}, {}});
    const auto slide = load_cases::parse_load_case(
        "regime = \"large\"\n" + held_x_min + "[[condition]]\nname = \"finger\"\npatch = \"x_max\"\npush = 0.01\n" +
            "[tool]\nplace = \"finger\"\npress_until = 0.5\nslide = [0.0, 0.01, 0.0]\nrelease_at = 1.0\n"
            "duration = 1.5\nmass_damping = 7.0\n",
        "poke.toml", turned_body);
    EXPECT_NEAR((slide.tool->slide - core::Vector3(0.0, 0.0, 0.01)).norm(), 0.0, 1e-15);
    const auto ball = load_cases::parse_load_case(
        "regime = \"large\"\n" + held_x_min +
            "[touch]\ndisc = { region = \"solid\", direction = [0.0, 1.0, 0.0], radius = 0.02 }\nradius = 0.02\n"
            "depth = 0.01\nslide = [0.0, 0.0, 0.01]\n",
        "touch.toml", turned_body);
    EXPECT_NEAR((ball.touching->start - core::Vector3(0.05, 0.05, 0.12)).norm(), 0.0, 0.01) << "above z_max";
    EXPECT_NEAR(ball.touching->start.z(), 0.12, 1e-6);
    EXPECT_NEAR((ball.touching->slide - core::Vector3(0.0, -0.01, 0.0)).norm(), 0.0, 1e-15);
}

TEST(Directions, AreThoseOfTheMeshWhereTheLoadCaseNamesNoPatchOfTheLiver) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.7, core::Vector3::UnitX()).toRotationMatrix();
    const auto pulled = [&](const core::BodyAxes &axes) {
        return load_cases::parse_load_case(held_x_min +
                                               "[[condition]]\npatch = \"x_max\"\ntraction = [0.0, 2.0, 0.0]\n",
                                           "pull.toml", block_with(axes));
    };
    EXPECT_TRUE(core::are_statically_equal(pulled({turn, {"posterior"}, {}}), pulled({})));
    EXPECT_TRUE(core::are_statically_equal(pulled({turn, {"posterior"}, "nobody knows"}), pulled({})));
    EXPECT_FALSE(core::are_statically_equal(pulled({turn, {}, {}}), pulled({}))) << "axes of the .toml are for all";
}

TEST(Directions, OfFreeComponentsTurnByRightAnglesOnly) {
    const auto slid = [&](const Eigen::Matrix3d &turn) {
        return load_cases::parse_load_case("[[condition]]\npatch = \"x_max\"\ndisplacement = [0.001, \"free\", 0.0]\n" +
                                               held_x_min,
                                           "slide.toml", block_with({turn, {}, {}}));
    };
    Eigen::Matrix3d quarter;
    quarter << 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
    const auto turned = slid(quarter);
    for (int f = 0; f < turned.num_facets(); ++f)
        if (turned.constraint_on(f) == 0) {
            EXPECT_TRUE(std::isnan(turned.value[f].x()));
            EXPECT_EQ(turned.value[f].y(), -0.001);
            EXPECT_EQ(turned.value[f].z(), 0.0);
        }
    tests::expect_input_error(
        [&] { slid(Eigen::AngleAxisd(0.3, core::Vector3::UnitZ()).toRotationMatrix()); },
        {"slide.toml:3", "free along an axis of the patient", "turn the mesh to LPS, or give all three components"});
}

TEST(Directions, AreRefusedWhereNobodyKnowsHowTheBodyLies) {
    const auto doubtful = block_with({Eigen::Matrix3d::Identity(), {"x_min"}, "it may lie either way"});
    for (const auto *line : {"press_along = [0.0, 0.0, -0.002]", "traction = [0.0, 1.0, 0.0]"})
        tests::expect_input_error(
            [&] {
                load_cases::parse_load_case(held_x_min + "[[condition]]\npatch = \"x_max\"\n" + line + "\n",
                                            "case.toml", doubtful);
            },
            {"case.toml:6", "its directions are those of the patient, and it may lie either way",
             "`livermark mesh check BODY --picture patches.png`", "axes = \"LPS\""});
    EXPECT_NO_THROW(load_cases::parse_load_case(held_x_min + "[[condition]]\npatch = \"x_max\"\npress = 0.002\n",
                                                "case.toml", doubtful));
    const auto turned = block_with({Eigen::AngleAxisd(1.7, core::Vector3::UnitX()).toRotationMatrix(), {"x_min"}, {}});
    tests::expect_input_error(
        [&] {
            load_cases::parse_load_case(held_x_min + "[[condition]]\ndisc = { point = [0.05, 0.05, 0.05], direction = "
                                                     "[0.0, 0.0, 1.0], radius = 0.02 }\npressure = 100.0\n",
                                        "case.toml", turned);
        },
        {"case.toml:5", "by a point of the mesh and a direction of the patient", "leave the 'direction' out"});
}

core::LoadCase parse_own(const std::string &text) {
    return load_cases::parse_load_case(text, "own.toml", block());
}

TEST(OwnLoadCase, NeedsConditionsAlone) {
    const auto pulled = parse_own(held_x_min + "[[condition]]\npatch = \"x_max\"\nforce = [0.1, 0.0, 0.0]\n");
    EXPECT_EQ(pulled.title, "own");
    EXPECT_DOUBLE_EQ(pulled.target_peak_displacement, 0.01 * core::extent(block().points)) << "nothing says how far";
    EXPECT_FALSE(pulled.scale_to_target);
    const auto moved =
        parse_own(held_x_min + "[[condition]]\npatch = \"x_max\"\ndisplacement = [0.003, \"free\", 0.004]\n");
    EXPECT_DOUBLE_EQ(moved.target_peak_displacement, 0.005);
    const auto pressed = parse_own(held_x_min + "[[condition]]\npatch = \"x_max\"\npress = 0.002\n");
    EXPECT_DOUBLE_EQ(pressed.target_peak_displacement, 0.002);
}

TEST(OwnLoadCase, SaysAllThatIsMissingAtOnceAndFirstWhatIsMisspelt) {
    std::string refusals;
    for (const auto &text :
         {std::string("scale_to_target = true\n[[condition]]\npatch = \"x_min\"\n[[condition]]\npressure = 10.0\n"),
          held_x_min + "[release]\n", "regime = \"large\"\n" + held_x_min + "[tool]\nduration = 1.0\n",
          std::string("[[condition]]\nptach = \"x_min\"\n")})
        refusals += tests::refusal(text, [&] { parse_own(text); });
    tests::expect_golden("refusals_of_missing_parts", refusals);
}

TEST(OwnLoadCase, HasAToolThatOnlyPressesWhereNoSlideIsGiven) {
    const auto load_case =
        parse_own("regime = \"large\"\n" + held_x_min +
                  "[[condition]]\nname = \"finger\"\npatch = \"x_max\"\npush = 0.01\n[tool]\nplace = \"finger\"\n"
                  "press_until = 0.5\nrelease_at = 1.0\nduration = 1.5\nmass_damping = 7.0\n");
    ASSERT_TRUE(load_case.tool);
    EXPECT_EQ(load_case.tool->slide, core::Vector3(0.0, 0.0, 0.0));
    EXPECT_EQ(load_case.tool->num_frames, 90);
    EXPECT_DOUBLE_EQ(load_case.target_peak_displacement, 0.01);
}

} // namespace
} // namespace livermark
