#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "load_cases/experiments/experiment.hpp"
#include "load_cases/experiments/markers.hpp"
#include "meshes/generators/box_generator.hpp"
#include "results/records/experiment.hpp"
#include "studies/experiments/experiments.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::experiments {
namespace {

using core::Vector3;

using tests::replaced;

/// A box of which every side moves as u = G x, which keeps the volume; so does then what is inside, for every law.
struct OwnExperiment : tests::ResultFolder {
    std::filesystem::path toml_, csv_;
    std::string text_ = R"(title = "A jelly under a spoon"
source = "our kitchen"
assumptions = ["it is a jelly"]
markers = "jelly.csv"
unit = "mm"
noise = 0.0002
fit_degree = 1
[body]
box = { size = [0.06, 0.05, 0.04], edge_length = 0.02, corner = [-0.03, 0.0, 0.01] }
[material]
density = 1000.0
young_modulus = 5000.0
poisson_ratio = 0.49
source = "a guess"
[[state]]
name = "pressed"
path = [0.5, 1.0]
)";
    std::string markers_ = "marker,drives,x,y,z,pressed_x,pressed_y,pressed_z\n";

    static Vector3 moved(const Vector3 &x) {
        return {1.25 * x.x() + 0.1 * x.z(), x.y(), 0.8 * x.z()}; // in millimetres, of determinant 1
    }
    void add_marker(const std::string &name, const std::string &drives, const Vector3 &x) {
        const auto y = moved(x);
        markers_ += fmt::format("{},{},{},{},{},{},{},{}\n", name, drives, x.x(), x.y(), x.z(), y.x(), y.y(), y.z());
    }
    void SetUp() override {
        ResultFolder::SetUp();
        toml_ = directory_ / "jelly.toml";
        csv_ = directory_ / "jelly.csv";
        const Vector3 corner(-30.0, 0.0, 10.0), size(60.0, 50.0, 40.0);
        for (int axis = 0; axis < 3; ++axis)
            for (const bool is_far : {false, true}) {
                const auto patch = fmt::format("{}_{}", "xyz"[axis], is_far ? "max" : "min");
                text_ += fmt::format("[[state.condition]]\npatch = \"{}\"\ndisplacement = [0.0, 0.0, 0.0]\n", patch);
                for (int i = 0; i < 4; ++i) {
                    Vector3 part(0.2 + 0.5 * (i % 2), 0.2 + 0.5 * (i % 2), 0.2 + 0.5 * (i % 2));
                    part[axis] = is_far ? 1.0 : 0.0;
                    part[(axis + 1) % 3] = 0.3 + 0.4 * (i / 2);
                    add_marker(fmt::format("{}{}", patch, i), patch, corner + size.cwiseProduct(part));
                }
            }
        for (int i = 0; i < 5; ++i)
            add_marker(fmt::format("inside{}", i), "", corner + size * (0.2 + 0.1 * i));
    }
    Experiment read() {
        std::ofstream(toml_) << text_;
        std::ofstream(csv_) << markers_;
        return read_experiment(toml_);
    }
    /// Rows for what is refused after changes of one of both texts.
    std::string refusals_after(const std::vector<std::string> &changes, std::string &text) {
        const auto good = text;
        const auto rows = tests::refusals_after(
            changes, good,
            [&](const std::string &changed) {
                text = changed;
                read();
            },
            directory_.string());
        text = good;
        return rows;
    }
};

std::vector<double> outside_of(const Experiment &experiment, const core::TetraMesh &mesh) {
    std::vector<Vector3> positions;
    for (const auto &marker : experiment.markers)
        positions.push_back(marker.position);
    return MarkerField(mesh, positions).outside();
}

TEST_F(OwnExperiment, IsReadInMetres) {
    const auto experiment = read();
    EXPECT_EQ(experiment.name, "jelly");
    EXPECT_EQ(experiment.assumptions, std::vector<std::string>{"it is a jelly"});
    ASSERT_EQ(experiment.markers.size(), 29u);
    EXPECT_LT((experiment.markers[24].position - Vector3(-0.018, 0.01, 0.018)).norm(), 1e-15);
    ASSERT_EQ(experiment.states.size(), 1u);
    const Vector3 expected(0.25 * -0.018 + 0.1 * 0.018, 0.0, -0.2 * 0.018);
    EXPECT_LT((experiment.states[0].displacement[24] - expected).norm(), 1e-8); // as many digits as the file has
    EXPECT_EQ(experiment.states[0].noise, 0.0002);
    const auto body = experiment.body(experiment.edge_length);
    EXPECT_EQ(body.materials.front().poisson_ratio, 0.49);
    const auto load_case = experiment.states[0].load_case(body.mesh);
    EXPECT_EQ(load_case.regime, core::Regime::large);
    EXPECT_EQ(load_case.num_constraints(), 6);
}

/// A measurement that is the solution itself.
TEST_F(OwnExperiment, ThatIsAKnownSolutionHasNoError) {
    studies::ExperimentOptions options;
    options.models = {"fem_p1_neo_hookean", "nodal_neo_hookean_f", "tled"};
    const auto result = studies::evaluate_experiment(read(), options, "test", {});
    ASSERT_EQ(result.runs.size(), 5u); // three, the reference, and that on the refined mesh
    for (const auto &run : result.runs) {
        EXPECT_EQ(run.status, core::SolutionStatus::ok) << run.model << ": " << run.message;
        EXPECT_LT(run.error, 1e-8) << run.model;
        EXPECT_LE(run.error, run.worst_error);
    }
    EXPECT_EQ(result.runs.back().model, "fem_p2p1_neo_hookean");
    EXPECT_EQ(result.runs.back().tetrahedra, 8 * result.runs.front().tetrahedra);
    const auto &state = result.states.front();
    EXPECT_LT(state.reference_uncertainty, 1e-8);
    EXPECT_LT(state.fit_residual, 1e-8);
    EXPECT_GT(state.no_motion, 0.003);
    EXPECT_GT(state.rigid_motion, 0.0005);
    EXPECT_LT(state.rigid_motion, state.no_motion);
    EXPECT_TRUE(std::isnan(state.straight_line)); // six places, and not two
}

TEST_F(OwnExperiment, OfACylinderHasItsPatches) {
    text_ = replaced(text_, "box = { size = [0.06, 0.05, 0.04], edge_length = 0.02, corner = [-0.03, 0.0, 0.01] }",
                     "cylinder = { radius = 0.03, height = 0.04, edge_length = 0.02, base = [0.0, 0.025, 0.01] }");
    const auto first = text_.find("[[state.condition]]");
    text_ = text_.substr(0, first) + "acceleration = [0.0, 0.0, -9.81]\n[[state.condition]]\npatch = \"z_min\"\n"
                                     "displacement = [0.0, 0.0, 0.0]\n";
    for (const char *drives : {",x_min,", ",x_max,", ",y_min,", ",y_max,", ",z_max,", ",z_min,"})
        for (auto at = markers_.find(drives); at != std::string::npos; at = markers_.find(drives))
            markers_.replace(at, std::string(drives).size(), ",,");
    const auto experiment = read();
    const auto body = experiment.body(experiment.edge_length);
    EXPECT_EQ(body.mesh.patch_names, (std::vector<std::string>{"side", "z_min", "z_max"}));
    const auto load_case = experiment.states[0].load_case(body.mesh);
    EXPECT_EQ(load_case.acceleration, Vector3(0.0, 0.0, -9.81));
}

TEST_F(OwnExperiment, WithAMarkerBesideTheBodyIsRefused) {
    // Pegs are followed: a fifth of the diagonal is 17.5 mm, half of the thickness 16.2 mm.
    const auto at = markers_.rfind("inside4");
    markers_ = markers_.substr(0, at) + "inside4,,0,65,30,0,65,30\n";
    const auto experiment = read();
    ASSERT_EQ(experiment.markers.size(), 29u);
    const auto body = experiment.body(experiment.edge_length);
    const auto outside = outside_of(experiment, body.mesh);
    EXPECT_NEAR(outside.back(), 0.015, 1e-12);
    const auto doubts = doubts_about_markers(experiment.markers, body.mesh, outside);
    tests::expect_one(doubts, "markers inside4 (15 mm) are outside the body by more than a tenth of its thickness of "
                              "32.4 mm");
    studies::ExperimentOptions options;
    options.models = {"fem_p1_neo_hookean"};
    options.refines_reference = false;
    const auto assumptions = studies::evaluate_experiment(experiment, options, "test", {}).assumptions;
    EXPECT_NE(std::ranges::find(assumptions, doubts.front()), assumptions.end());
}

/// A rod of 20 mm whose box is 135 mm wide at its thinnest, because it lies askew.
Experiment rod_askew(const std::vector<Vector3> &markers) {
    const Eigen::Matrix3d turned = Eigen::Quaterniond::FromTwoVectors(Vector3::UnitX(), Vector3::Ones()).matrix();
    Experiment rod;
    rod.name = "rod";
    rod.body = [turned](double) {
        core::Body body{.name = "rod", .mesh = tests::box_mesh({0.2, 0.02, 0.02}, {10, 1, 1}), .materials = {}};
        for (auto &point : body.mesh.points)
            point = turned * point;
        return body;
    };
    for (std::size_t k = 0; k < markers.size(); ++k)
        rod.markers.push_back({fmt::format("m{}", k), turned * markers[k], ""});
    rod.states.push_back(
        {.name = "bent", .load_case = {}, .displacement = std::vector(markers.size(), Vector3(0, 0, 1e-3))});
    return rod;
}

TEST(MarkersOffTheBody, AreMeasuredByItsThicknessAndNotByItsBox) {
    EXPECT_NO_THROW(check(rod_askew({{0.1, 0.01, 0.025}}), "rod.csv"));
    tests::expect_input_error(
        [] {
            check(rod_askew({{0.1, 0.01, 0.055}}), "rod.csv");
        },
        {"rod.csv: marker m0 is 35 mm outside the body", "half of the thickness"});
}

/// A marker almost three radii off the axis.
TEST(MarkersOffTheBody, AreRefusedBesideACylinder) {
    auto cylinder = rod_askew({{0.1, 0.01, 0.01}});
    cylinder.body = [](double) {
        return core::Body{.name = "cylinder", .mesh = meshes::generate_cylinder(0.019, 0.178, 0.0095), .materials = {}};
    };
    cylinder.markers.front().position = {0.0, 0.019, 0.178};
    EXPECT_NO_THROW(check(cylinder, "cylinder.csv"));
    cylinder.markers.front().position = {0.0, 0.054, 0.178};
    tests::expect_input_error([&] { check(cylinder, "cylinder.csv"); },
                              {"cylinder.csv: marker m0 is 34.9", "mm outside"});
}

TEST(MarkersOffTheBody, AreNamedAndCounted) {
    std::vector<Vector3> markers;
    for (int k = 0; k < 8; ++k)
        markers.emplace_back(0.02 + 0.02 * k, 0.01, k == 0 ? 0.021 : 0.025);
    const auto rod = rod_askew(markers);
    const auto mesh = rod.body(0.0).mesh;
    const auto doubts = doubts_about_markers(rod.markers, mesh, outside_of(rod, mesh));
    tests::expect_one(doubts, "markers m1 (5 mm), m2 (5 mm), m3 (5 mm), m4 (5 mm), m5 (5 mm) and 2 others are outside");
    EXPECT_TRUE(doubts_about_markers(rod.markers, mesh, std::vector<double>(markers.size(), 0.001)).empty());
}

TEST_F(OwnExperiment, OfOneMarkerHasNoRigidMotionAndAllElse) {
    markers_.erase(markers_.find("inside1"));
    studies::ExperimentOptions options;
    options.models = {"fem_p1_neo_hookean"};
    options.refines_reference = false;
    const auto result = studies::evaluate_experiment(read(), options, "test", {});
    const auto &state = result.states.front();
    EXPECT_TRUE(std::isnan(state.rigid_motion));
    EXPECT_GT(state.no_motion, 0.003);
    for (const auto &run : result.runs) {
        EXPECT_EQ(run.status, core::SolutionStatus::ok) << run.message;
        EXPECT_LT(run.error, 1e-8);
        EXPECT_EQ(run.error, run.worst_error);
    }
    for (const auto &row : results::experiment_table(result).rows)
        EXPECT_EQ(row.front().find("rigid"), std::string::npos);
    results::write_experiment(directory_ / "one.h5", result);
    const auto again = results::read_experiment(directory_ / "one.h5");
    EXPECT_TRUE(std::isnan(again.states.front().rigid_motion));
    ASSERT_EQ(again.runs.size(), result.runs.size());
    for (std::size_t r = 0; r < again.runs.size(); ++r) {
        EXPECT_EQ(again.runs[r].displacement, result.runs[r].displacement);
        EXPECT_EQ(again.runs[r].component_error, result.runs[r].component_error);
        EXPECT_TRUE(std::isnan(again.runs[r].beyond_reference[0])) << "of one marker";
    }
}

TEST_F(OwnExperiment, WithANoiseAsOfAnotherUnitIsDoubted) {
    studies::ExperimentOptions options;
    options.models = {"fem_p1_neo_hookean"};
    options.refines_reference = false;
    const auto is_doubted = [&] {
        const auto assumptions = studies::evaluate_experiment(read(), options, "test", {}).assumptions;
        return std::ranges::any_of(assumptions, [](const auto &text) { return text.starts_with("the noise is "); });
    };
    EXPECT_FALSE(is_doubted());
    for (const char *noise : {"noise = 0.3", "noise = 0.003"}) { // 300 mm, and 3 mm of displacements up to 13.6 mm
        const auto good = text_;
        text_ = replaced(text_, "noise = 0.0002", noise);
        EXPECT_TRUE(is_doubted()) << noise;
        text_ = good;
    }
}

TEST_F(OwnExperiment, SaysHowManyTetrahedraAreExpectedAndRefusesTooMany) {
    std::vector<std::string> said;
    const auto read_and_hear = [&] {
        read();
        said.clear();
        return read_experiment(toml_, [&](const std::string &sentence) { said.push_back(sentence); });
    };
    const auto experiment = read_and_hear();
    EXPECT_EQ(said, std::vector<std::string>{"jelly: a mesh of about 130 tetrahedra"});
    EXPECT_NEAR(experiment.expected_tetrahedra(0.02), 127.3, 0.1);
    text_ = replaced(text_, "size = [0.06, 0.05, 0.04]", "size = [0.06, 3000, 0.04]");
    tests::expect_input_error([&] { read(); }, {"a box of 0.06 x 3000 x 0.04 m", "tetrahedra", "make them longer"});
    said.clear();
    tests::expect_input_error(
        [&] { read_experiment(toml_, [&](const std::string &sentence) { said.push_back(sentence); }); },
        {"tetrahedra"});
    EXPECT_EQ(said, std::vector<std::string>{"jelly: a mesh of about 7600000 tetrahedra"});
}

TEST_F(OwnExperiment, ThatIsNoneIsRefused) {
    const std::string box = "box = { size = [0.06, 0.05, 0.04], edge_length = 0.02, corner = [-0.03, 0.0, 0.01] }";
    auto refusals = refusals_after(
        {"unit = \"mm\" -> unit = \"m\"", "unit = \"mm\" -> unit = \"furlong\"", "unit = \"mm\"\n -> ",
         "unit = \"mm\" -> unit = -0.001", "\"jelly.csv\" -> \"other.csv\"", box + " -> file = \"no_body.toml\"",
         "title -> tittle", "name = \"pressed\" -> name = \"pulled\"", "fit_degree = 1 -> fit_degree = 1.5",
         "noise = 0.0002 -> noise = -1.0", "path = [0.5, 1.0] -> release = 2.0",
         "poisson_ratio = 0.49 -> poisson_ratio = 0.5", "[body] -> [body]\nfile = \"body.toml\"",
         "edge_length = 0.02 -> edge_length = -0.02", "size = [0.06, 0.05, 0.04] -> size = [0.06, 3000, 0.04]"},
        text_);
    const auto last = markers_.substr(markers_.rfind("inside4"));
    refusals += refusals_after({markers_ + " -> ", markers_.substr(markers_.find('\n') + 1) + " -> ",
                                "marker,drives -> name,drives", "pressed_y -> pressed_z",
                                "x_min0,x_min, -> x_min0,x_min,nan,", "x_min0,x_min,-30 -> x_min0,x_min,nan",
                                "x_min0,x_min,-30 -> x_min0,x_min,inf", "x_min0,x_min,-30 -> x_min0,x_min,3e999",
                                "x_min1, -> x_min0,", markers_.substr(markers_.find("inside0")) + " -> ",
                                last + " -> inside4,,0,75,30,0,75,30\n", last + " -> inside4,,0,25,32,0,400,30\n",
                                last + " -> inside4,,0,25,30.00005,0,25,24\n", last + " -> blind,z_max,0,25,50,,,\n"},
                               markers_);
    refusals += tests::refusal(
        "no file", [&] { read_experiment(directory_ / "none.toml"); }, directory_.string());
    tests::expect_golden("refusals_of_experiments", refusals);
    const auto expect_no_evaluation = [&](const std::string &part) {
        tests::expect_input_error([&] { studies::evaluate_experiment(read(), {}, "", {}); }, {part});
    };
    const auto good = text_;
    text_ = replaced(good, "fit_degree = 1", "fit_degree = 3");
    expect_no_evaluation("4 markers");
    text_ = replaced(good, "path = [0.5, 1.0]", "duration = 2.0");
    expect_no_evaluation("duration");
    text_ = good;
    markers_ = replaced(markers_, "inside0,,", "inside0,lid,");
    expect_no_evaluation("lid");
}

TEST_F(OwnExperiment, LeavesMarkersOutThatWereNotSeen) {
    const auto at = markers_.rfind("inside4");
    markers_ = markers_.substr(0, at) + "inside4,,0,25,32,,,\n";
    const auto experiment = read();
    EXPECT_TRUE(experiment.states[0].displacement.back().array().isNaN().all());
}

TEST_F(OwnExperiment, HasNoModelOfAnotherRegime) {
    studies::ExperimentOptions options;
    text_ = replaced(text_, "path = [0.5, 1.0]", "regime = \"small\"");
    options.models = {"fem_p1_neo_hookean"};
    tests::expect_input_error([&] { studies::evaluate_experiment(read(), options, "", {}); },
                              {"fem_p1_neo_hookean", "small"});
    options.models = {"fem_p0"};
    tests::expect_input_error([&] { studies::evaluate_experiment(read(), options, "", {}); }, {"fem_p0"});
}

std::vector<Vector3> at_nodes(const core::TetraMesh &mesh, Vector3 (*field)(const Vector3 &)) {
    std::vector<Vector3> values;
    for (const auto &point : mesh.points)
        values.push_back(field(point));
    return values;
}

Vector3 affine(const Vector3 &x) {
    return {0.01 + 0.2 * x.y(), -0.1 * x.z(), 0.3 * x.x() + 0.1 * x.z()};
}

Vector3 bulge(const Vector3 &x) {
    return {4.0 * x.x() * x.z() * (0.1 - x.z()), 0.0, x.x() * x.x()};
}

TEST(MarkerField, IsExactForAffineDisplacementsInsideAndOnPegs) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {3, 3, 3});
    const std::vector<Vector3> points{
        {0.031, 0.047, 0.022}, {0.1, 0.1, 0.1}, {0.05, 0.04, 0.112}, {-0.01, -0.02, 0.05}};
    const MarkerField field(mesh, points);
    const auto found = field.at_points(at_nodes(mesh, affine));
    for (std::size_t k = 0; k < points.size(); ++k)
        EXPECT_LT((found[k] - affine(points[k])).norm(), 1e-15) << k;
    EXPECT_EQ(field.outside()[0], 0.0);
    EXPECT_NEAR(field.outside()[1], 0.0, 1e-12);
    EXPECT_NEAR(field.outside()[2], 0.012, 1e-12);
    EXPECT_NEAR(field.outside()[3], std::hypot(0.01, 0.02), 1e-12);
}

TEST(MarkerField, DependsOnItsNodesAlone) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {5, 5, 5});
    const std::vector<Vector3> points{{0.031, 0.047, 0.022}, {0.05, 0.04, 0.112}};
    const MarkerField field(mesh, points);
    const auto nodes = field.nodes();
    EXPECT_TRUE(std::ranges::is_sorted(nodes));
    EXPECT_LT(nodes.size(), mesh.points.size());
    const auto everywhere = at_nodes(mesh, bulge);
    std::vector<Vector3> there(mesh.points.size(), Vector3::Constant(1.0));
    for (const int node : nodes)
        there[node] = everywhere[node];
    EXPECT_EQ(field.at_points(there), field.at_points(everywhere));
}

/// Linear interpolation of the bulge is up to h^2 / 8 of its curvature off.
TEST(MarkerField, FollowsCurvatureBetweenNodes) {
    const auto mesh = tests::box_mesh({0.1, 0.1, 0.1}, {5, 5, 5});
    std::vector<Vector3> points;
    for (int k = 0; k < 10; ++k)
        points.emplace_back(0.03 + 0.004 * k, 0.05, 0.07 - 0.0035 * k);
    const auto found = MarkerField(mesh, points).at_points(at_nodes(mesh, bulge));
    constexpr double linear_error = 0.02 * 0.02 / 8.0 * 2.0;
    for (std::size_t k = 0; k < points.size(); ++k)
        EXPECT_LT((found[k] - bulge(points[k])).norm(), 0.1 * linear_error) << k;
}

} // namespace
} // namespace livermark::experiments
