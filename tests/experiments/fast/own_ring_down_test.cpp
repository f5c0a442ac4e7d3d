#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "experiments/own_experiment.hpp"
#include "studies/experiments/experiments.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

namespace livermark::experiments {
namespace {

using core::Vector3;

std::string with(std::string text, const std::string &from, const std::string &to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

/// A short column that is clamped below and was pulled aside at its top.
struct OwnRingDown : tests::ResultFolder {
    std::string text_ = R"(title = "A column of jelly"
source = "our kitchen"
markers = "jelly.csv"
unit = "m"
[body]
box = { size = [0.02, 0.02, 0.04], edge_length = 0.02 }
[material]
density = 1000.0
young_modulus = 5000.0
poisson_ratio = 0.45
source = "a guess"
[[state]]
name = "upright"
acceleration = [0.0, 0.0, -9.81]
[[state.condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
[state.ring_down]
motions = ["swings.csv"]
held = { patch = "z_max", force = [0.02, 0.0, 0.0] }
added_mass = { mass = 0.002, low = [0.0, 0.0, 0.03], high = [0.02, 0.02, 0.04] }
)";
    std::string markers_ = "marker,drives,x,y,z,upright_x,upright_y,upright_z\n"
                           "a,,0.0,0.01,0.04,0.0,0.01,0.039\nb,,0.02,0.01,0.04,0.02,0.01,0.039\n"
                           "c,,0.01,0.0,0.03,0.01,0.0,0.0293\n";
    std::string swings_;

    /// With displacements of the three markers over time.
    void record(const std::vector<Vector3> &displacement, double interval) {
        const std::array<Vector3, 3> rest{{{0.0, 0.01, 0.04}, {0.02, 0.01, 0.04}, {0.01, 0.0, 0.03}}};
        swings_ = "time,a_x,a_y,a_z,b_x,b_y,b_z,c_x,c_y,c_z\n";
        for (std::size_t j = 0; j < displacement.size() / 3; ++j) {
            swings_ += fmt::format("{}", static_cast<double>(j) * interval);
            for (std::size_t k = 0; k < 3; ++k)
                for (const double x : Vector3(rest[k] + displacement[3 * j + k]))
                    swings_ += fmt::format(",{:.12g}", x);
            swings_ += "\n";
        }
    }
    void SetUp() override {
        ResultFolder::SetUp();
        std::vector<Vector3> displacement;
        for (int j = 0; j < 40; ++j)
            for (const double part : {1.0, 1.0, 0.7})
                displacement.emplace_back(0.004 * part * std::exp(-0.1 * j) * std::cos(0.6 * j), 0.0, -0.0005 * part);
        record(displacement, 0.02);
    }
    Experiment read() {
        std::ofstream(directory_ / "column.toml") << text_;
        std::ofstream(directory_ / "jelly.csv") << markers_;
        std::ofstream(directory_ / "swings.csv") << swings_;
        return read_experiment(directory_ / "column.toml");
    }
    results::RingDownResult evaluate() {
        studies::ExperimentOptions options;
        options.models = {"fem_p1_neo_hookean"};
        options.refines_reference = false;
        const auto result = studies::evaluate_experiment(read(), options, "test", {});
        EXPECT_EQ(result.damping_from, "upright");
        return result.ring_downs.front();
    }
    void expect_refused(const std::vector<std::string> &parts) {
        tests::expect_input_error([&] { read(); }, parts);
    }
};

TEST_F(OwnRingDown, HasWhatHangsAtItInItsBody) {
    const auto experiment = read();
    ASSERT_EQ(experiment.ring_downs.size(), 1u);
    const auto &ring_down = experiment.ring_downs.front();
    const auto mass = [](const core::Body &body) {
        const auto volumes = core::tetrahedron_volumes(body.mesh);
        double sum = 0.0;
        for (std::size_t t = 0; t < volumes.size(); ++t)
            sum += volumes[t] * body.materials[body.mesh.region[t]].density;
        return sum;
    };
    for (const double edge_length : {0.02, 0.01})
        EXPECT_NEAR(mass(ring_down.body(edge_length)) - mass(experiment.body(edge_length)), 0.002, 1e-12);
    const auto body = ring_down.body(0.02);
    const auto load_case = ring_down.load_case(body.mesh);
    Vector3 force = Vector3::Zero();
    for (int f = 0; f < body.mesh.num_boundary_triangles(); ++f)
        if (load_case.is_loaded(f))
            force += load_case.value[f] * core::area_vector(body.mesh, f).norm();
    EXPECT_LT((force - Vector3(0.02, 0.0, 0.0)).norm(), 1e-12);
    EXPECT_EQ(ring_down.repeats.front().num_records(), 40);
    EXPECT_NEAR(ring_down.repeats.front().interval, 0.02, 1e-12);
    EXPECT_LT((ring_down.repeats.front().at(0, 2) - Vector3(0.0028, 0.0, -0.00035)).norm(), 1e-10);
}

/// A measurement that is what the model does.
TEST_F(OwnRingDown, ThatIsAKnownMotionHasNoError) {
    const auto first = evaluate();
    ASSERT_EQ(first.runs.size(), 2u); // and the reference of motion
    EXPECT_EQ(first.runs.back().model, "fem_p2_neo_hookean");
    const auto &moved = first.runs.front();
    ASSERT_EQ(moved.status, core::SolutionStatus::ok) << moved.message;
    EXPECT_GT(moved.error, 1e-4);
    EXPECT_LT(moved.start_error, 0.4 * first.displacement.front().norm());
    record(moved.displacement, first.interval);
    const auto again = evaluate();
    const auto &run = again.runs.front();
    // What is left is that the decay is measured of a motion that has higher modes as well.
    EXPECT_LT(run.start_error, 1e-6);
    EXPECT_NEAR(run.frequency, again.frequency, 0.02 * again.frequency);
    EXPECT_LT(run.error, 0.2 * again.no_motion);
    EXPECT_LT(run.error, 0.3 * moved.error);
    EXPECT_LT(run.swing_error, 0.1 * again.swings.front());
    EXPECT_GT(again.runs.back().error, run.error);
    EXPECT_EQ(again.noise, 0.0); // of one motion
}

TEST_F(OwnRingDown, ThatSaysTooLittleOrTooMuchIsRefused) {
    const auto good = text_;
    text_ = with(good, "motions = [\"swings.csv\"]", "motions = [\"none.csv\"]");
    expect_refused({"none.csv"});
    text_ = with(good, "held =", "hold =");
    expect_refused({"hold", "held"});
    text_ = with(good, "force = [0.02, 0.0, 0.0]", "displacement = [0.0, 0.0, 0.0]");
    expect_refused({"column.toml", "is not a force"});
    text_ = with(good, "[state.ring_down]",
                 "[[state.condition]]\npatch = \"x_max\"\nforce = [0.0, 0.0, -1.0]\n"
                 "[state.ring_down]");
    expect_refused({"upright", "added_mass"});
    text_ = with(good, "mass = 0.002", "mass = -0.002");
    expect_refused({"positive"});
    text_ = with(good, "low = [0.0, 0.0, 0.03]", "low = [0.0, 0.0, 0.06]");
    expect_refused({"no tetrahedra", "larger box"});
}

TEST_F(OwnRingDown, WithAMotionThatIsNoneIsRefused) {
    const auto good = swings_;
    swings_ = with(good, "time,", "t,");
    expect_refused({"swings.csv:1", "first line"});
    swings_ = with(good, "b_x", "d_x");
    expect_refused({"swings.csv:1", "marker 'b'"});
    swings_ = with(good, "\n0.04,", "\n0.045,");
    expect_refused({"swings.csv:4", "evenly"});
    swings_ = with(good, "\n0.04,", "\nnan,");
    expect_refused({"swings.csv:4", "finite"});
    swings_ = good.substr(0, good.find("\n0.1,") + 1);
    expect_refused({"swings.csv", "16"});
    swings_ = good;
    markers_ = with(markers_, "c,,", "c,z_min,");
    markers_ += "d,,0.01,0.02,0.02,0.01,0.02,0.0195\n";
    expect_refused({"marker c drives"});
}

} // namespace
} // namespace livermark::experiments
