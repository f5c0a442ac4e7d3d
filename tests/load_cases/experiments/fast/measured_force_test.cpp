#include <algorithm>
#include <cmath>
#include <fmt/ranges.h>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include "core/support/input_error.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "results/records/experiment.hpp"
#include "studies/experiments/experiments.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

namespace livermark::experiments {
namespace {

/// A quarter of the upper half of a cylinder between plates without friction, and the force on it: uniform, and as a
/// neo-Hookean law has it at a Poisson's ratio of 0.3.
struct PressedCylinder : tests::ResultFolder {
    static constexpr double radius = 0.02, height = 0.03, modulus = 6000.0;
    std::string text_ = R"(title = "A cylinder under a plate"
source = "a closed form"
unit = "mm"
[body]
cylinder = { radius = 0.02, height = 0.015, edge_length = 0.008, quarter = true }
[material]
density = 1000.0
young_modulus = 5000.0
poisson_ratio = 0.3
source = "a guess"
laws = { yeoh = [0.05, 0.05] }
[[state]]
name = "pressed"
[state.force]
table = "force.csv"
place = "z_max"
fit_at = 0.001
compare_at = [0.004, 0.009]
parts = 4
length = 0.03
[[state.condition]]
patch = "z_min"
displacement = ["free", "free", 0.0]
[[state.condition]]
patch = "x_min"
displacement = [0.0, "free", "free"]
[[state.condition]]
patch = "y_min"
displacement = ["free", 0.0, "free"]
[[state.condition]]
patch = "z_max"
displacement = ["free", "free", -0.0045]
)";

    /// Force at stretches l along and s across where the sides are free, mu (s^2 - 1) + lambda ln J = 0, and
    /// P = mu (l - 1 / l) + lambda / l ln J.
    static double force(double way) {
        const core::Material material{1000.0, modulus, 0.3};
        const double l = 1.0 - way / height, mu = material.shear_modulus(), lambda = material.lame_lambda();
        double low = 0.5, high = 2.0;
        for (int bisection = 0; bisection < 60; ++bisection) {
            const double s = 0.5 * (low + high);
            (mu * (s * s - 1.0) + lambda * std::log(l * s * s) < 0.0 ? low : high) = s;
        }
        const double area = std::numbers::pi * radius * radius;
        return -area * (mu * (l - 1.0 / l) + lambda / l * std::log(l * low * low));
    }
    static std::string table() {
        std::string text = "way,force,deviation\n";
        for (const double way : {0.0, 0.001, 0.004, 0.009, 0.012})
            text += fmt::format("{:g},{:.12g},{:.12g}\n", 1e3 * way, force(way), 0.02 * force(way));
        return text;
    }
    Experiment read(const std::string &text, const std::string &csv) {
        std::ofstream(directory_ / "force.csv") << csv;
        std::ofstream(directory_ / "cylinder.toml") << text;
        return read_experiment(directory_ / "cylinder.toml");
    }
};

TEST_F(PressedCylinder, IsReadWithoutMarkers) {
    const auto experiment = read(text_, table());
    EXPECT_TRUE(experiment.markers.empty());
    ASSERT_TRUE(experiment.states.at(0).force);
    const auto &measured = *experiment.states[0].force;
    EXPECT_EQ(measured.way, (std::vector<double>{0.001, 0.004, 0.009}));
    for (std::size_t j = 0; j < 3; ++j) {
        EXPECT_NEAR(measured.force[j], force(measured.way[j]), 1e-9);
        EXPECT_NEAR(measured.deviation[j], 0.02 * force(measured.way[j]), 1e-9);
    }
    const auto body = std::make_shared<const core::Body>(experiment.body(experiment.edge_length));
    const auto problem = problem_of(experiment, experiment.states[0], body);
    ASSERT_EQ(problem.load_case.path.size(), 3u);
    EXPECT_NEAR(problem.load_case.path[1], 4.0 / 9.0, 1e-12);
    EXPECT_EQ(body->materials[0].law_constants.at("yeoh"), (std::vector<double>{0.05, 0.05}));
}

/// All that follow the law have the shape of the curve and the modulus of the measurement; others do not.
TEST_F(PressedCylinder, GivesEachModelItsModulus) {
    studies::ExperimentOptions options;
    options.models = {"fem_p1_neo_hookean", "fem_p2p1_yeoh", "nodal_neo_hookean_f", "fem_p1"};
    const auto result = studies::evaluate_experiment(read(text_, table()), options, "test", {});
    ASSERT_EQ(result.forces.size(), 1u);
    const auto &measured = result.forces[0];
    ASSERT_EQ(measured.runs.size(), 6u);
    EXPECT_GT(measured.runs.back().tetrahedra, 2 * measured.runs.front().tetrahedra) << "a finer mesh of the cylinder";
    for (const auto &run : measured.runs) {
        ASSERT_EQ(run.status, core::SolutionStatus::ok) << run.model << ": " << run.message;
        const auto errors = results::errors_of_shape(measured, run.force);
        if (run.model == "fem_p2p1_yeoh" || run.model == "fem_p1") {
            EXPECT_GT(std::abs(errors[1]), 0.02) << run.model;
            continue;
        }
        EXPECT_NEAR(errors[0], 0.0, 2e-4) << run.model;
        EXPECT_NEAR(errors[1], 0.0, 2e-4) << run.model;
        EXPECT_NEAR(measured.young_modulus * measured.force[0] / run.force[0], modulus, 2e-4 * modulus) << run.model;
    }
    const auto linear = std::ranges::find(measured.runs, "fem_p1", &results::ForceRun::model);
    const auto straight = results::errors_of_shape(measured, measured.way);
    EXPECT_NEAR(results::errors_of_shape(measured, linear->force)[1], straight[1], 1e-8) << "it is a straight line";
    const auto notes = fmt::format("{}", fmt::join(results::notes_on_nulls(result), "\n"));
    EXPECT_NE(notes.find("the uniform body, neo-Hookean knows no mechanics and is nearer"), std::string::npos) << notes;
}

TEST_F(PressedCylinder, ThatIsNoneIsRefused) {
    const auto refused = [&](const std::string &from, const std::string &to, const std::vector<std::string> &words) {
        auto text = text_;
        text.replace(text.find(from), from.size(), to);
        tests::expect_input_error([&] { read(text, table()); }, words);
    };
    refused("place = \"z_max\"", "place = \"side\"", {"'side'", "no such place", "z_max"});
    refused("fit_at = 0.001", "fit_at = 0.005", {"fit_at", "ascend"});
    refused("0.009]", "0.02]", {"force.csv", "0 to 12 mm", "20 mm"});
    refused("length = 0.03", "length = 0.0003", {"ten of its lengths"});
    refused("parts = 4", "parts = 0.5", {"0.5 parts"});
    refused("[state.force]", "path = [1.0]\n[state.force]", {"path"});
    refused("[state.force]", "regime = \"small\"\n[state.force]", {"large"});
    for (const auto &[csv, word] : {std::pair{"force,way\n1,2\n", "way,force,deviation"},
                                    {"way,force,deviation\n1,2\n", "cells"},
                                    {"way,force,deviation\n1,2,x\n", "finite number"},
                                    {"way,force,deviation\n1,2,0\n1,2,0\n", "does not grow"},
                                    {"way,force,deviation\n1,0,0\n12,0,0\n", "positive"}})
        tests::expect_input_error([&] { read(text_, csv); }, {word});
}

/// u = F z / (E A), with Poisson's ratio 0: a polygon that fills the volume of the cylinder has its area.
TEST_F(PressedCylinder, ThatIsPulledIsAsLongAsTheClosedForm) {
    std::ofstream(directory_ / "pull.csv")
        << "marker,drives,x,y,z,pulled_x,pulled_y,pulled_z\n"
           "a,,0,0,20,0,0,20.7073553\nb,,0,0,40,0,0,41.4147106\nc,,0,0,60,0,0,62.1220659\n"
           "d,,0,0,75,0,0,77.6525824\n";
    std::ofstream(directory_ / "pull.toml") << R"(title = "A cylinder pulled along its axis"
source = "closed form"
markers = "pull.csv"
unit = "mm"
[body]
cylinder = { radius = 0.03, height = 0.08, edge_length = 0.03 }
[material]
density = 1000.0
young_modulus = 5000.0
poisson_ratio = 0.0
source = "given"
[[state]]
name = "pulled"
regime = "small"
[[state.condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
[[state.condition]]
patch = "z_max"
force = [0.0, 0.0, 0.5]
)";
    studies::ExperimentOptions options;
    options.models = {"fem_p2"};
    for (const double edge : {0.03, 0.015}) {
        options.edge_length = edge;
        const auto result =
            studies::evaluate_experiment(read_experiment(directory_ / "pull.toml"), options, "test", {});
        for (const auto &run : result.runs) // the closed form is 0.5 N z / (5 kPa pi (3 cm)^2)
            EXPECT_LT(run.error, 0.01e-3 + 3.0 * result.states[0].reference_uncertainty) << edge << ' ' << run.model;
        EXPECT_LT(result.states[0].reference_uncertainty, 0.05e-3);
    }
}

} // namespace
} // namespace livermark::experiments
