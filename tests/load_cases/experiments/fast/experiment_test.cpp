#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <span>
#include <vector>

#include "load_cases/experiments/experiment.hpp"
#include "studies/experiments/experiments.hpp"
#include "tests/bad_input.hpp"
#include "tests/golden.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::experiments {
namespace {

using core::Vector3;

/// 7 x 7 points in a tilted plane.
std::vector<Vector3> layer() {
    std::vector<Vector3> points;
    for (int i = 0; i < 7; ++i)
        for (int j = 0; j < 7; ++j)
            points.emplace_back(0.01 * i, 0.012 * j, 0.05 + 0.002 * i);
    return points;
}

Vector3 bent(const Vector3 &x) {
    return {0.001 + 0.02 * x.x(), 0.3 * x.x() * x.y(), -0.004 - 2.0 * x.x() * x.x() + x.y() * x.y()};
}

std::vector<Vector3> moved(const std::vector<Vector3> &points, Vector3 (*motion)(const Vector3 &)) {
    std::vector<Vector3> result;
    for (const auto &point : points)
        result.push_back(motion(point));
    return result;
}

TEST(FittedMotion, IsExactForPolynomialsOfItsDegree) {
    const auto points = layer();
    const auto displacements = moved(points, bent);
    const FittedMotion quadratic(points, displacements, 2, "top"), linear(points, displacements, 1, "top");
    EXPECT_LT(quadratic.residual(), 1e-15);
    EXPECT_GT(linear.residual(), 1e-4);
    const Vector3 between(0.033, 0.041, 0.05 + 0.2 * 0.033);
    EXPECT_LT((quadratic.at(between) - bent(between)).norm(), 1e-15);
}

TEST(FittedMotion, SmoothsNoise) {
    const auto points = layer();
    auto displacements = moved(points, bent);
    for (std::size_t k = 0; k < displacements.size(); ++k)
        displacements[k].z() += k % 2 == 0 ? 1e-4 : -1e-4;
    const FittedMotion motion(points, displacements, 2, "top");
    EXPECT_NEAR(motion.residual(), 1e-4, 1e-5);
    for (const auto &point : points)
        EXPECT_LT((motion.at(point) - bent(point)).norm(), 3e-5);
}

TEST(FittedMotion, OfMarkersThatDoNotDetermineItIsRefused) {
    const auto points = layer();
    const std::vector<Vector3> five(points.begin(), points.begin() + 5), none(5, Vector3::Zero());
    tests::expect_input_error([&] { FittedMotion(five, none, 2, "jelly: place top"); },
                              {"jelly: place top", "5 markers", "6 coefficients"});
    std::vector<Vector3> line;
    for (int k = 0; k < 10; ++k)
        line.emplace_back(0.01 * k, 0.0, 0.0);
    tests::expect_input_error([&] { FittedMotion(line, std::vector<Vector3>(10, Vector3::Zero()), 1, "top"); },
                              {"top", "do not determine"});
}

TEST(FittedMotion, MovesTheNodesOfItsPatchAlone) {
    const auto mesh = tests::box_mesh({0.06, 0.08, 0.05}, {2, 2, 2});
    auto load_case = tests::empty_load_case(mesh);
    tests::prescribe(load_case, mesh, "z_max", Vector3::Zero());
    const auto points = layer();
    const FittedMotion motion(points, moved(points, bent), 2, "top");
    drive(load_case, mesh, {"z_max", motion});
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        const auto &x = mesh.points[node];
        EXPECT_EQ(load_case.node_shift[node], x.z() > 0.05 - 1e-9 ? motion.at(x) : Vector3(Vector3::Zero()));
    }
    EXPECT_TRUE(core::is_driven(load_case));
    tests::expect_input_error([&] { drive(load_case, mesh, {"lid", motion}); }, {"'lid'", "z_max"});
    tests::expect_input_error([&] { drive(load_case, mesh, {"x_max", motion}); }, {"'x_max'", "nothing constrains it"});
}

TEST(StraightLine, IsExactForAffineMotion) {
    const auto stretched = [](const Vector3 &x) { return Vector3(0.1 * x.z(), -0.02 * x.y(), 0.3 * x.z()); };
    std::vector<Vector3> low, high, low_moved, high_moved;
    for (auto point : layer()) {
        point.z() = 0.0;
        low.push_back(point);
        low_moved.push_back(stretched(point));
        point.z() = 0.1;
        high.push_back(point);
        high_moved.push_back(stretched(point));
    }
    const PlaceMotion from{"z_min", FittedMotion(low, low_moved, 1, "low")},
        to{"z_max", FittedMotion(high, high_moved, 1, "high")};
    const Vector3 point(0.02, 0.03, 0.07);
    EXPECT_LT((straight_line(from, to, point) - stretched(point)).norm(), 1e-15);
}

TEST(BestRigidMotion, FindsALargeRotation) {
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(2.5, Vector3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    const auto points = layer();
    std::vector<Vector3> targets;
    for (const auto &point : points)
        targets.emplace_back(rotation * point + Vector3(0.1, 0.0, -0.2));
    const auto found = best_rigid_motion(points, targets);
    EXPECT_LT((found.gradient - rotation).norm(), 1e-14);
    for (std::size_t k = 0; k < points.size(); ++k)
        EXPECT_LT((found.at(points[k]) - targets[k]).norm(), 1e-14);
}

TEST(BestAffineMotion, IsExactForAffineMotionAndNoneInAPlane) {
    Eigen::Matrix3d gradient;
    gradient << 1.2, 0.1, 0.0, -0.2, 0.9, 0.3, 0.0, 0.1, 0.8;
    std::vector<Vector3> points{
        {0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.2, 0.0}, {0.1, 0.1, 0.05}, {0.02, 0.07, 0.03}};
    std::vector<Vector3> targets;
    for (const auto &point : points)
        targets.emplace_back(gradient * point + Vector3(0.5, -0.1, 0.2));
    const auto motion = best_affine_motion(points, targets);
    ASSERT_TRUE(motion);
    const Vector3 elsewhere(-0.3, 0.2, 0.1);
    EXPECT_LT((motion->at(elsewhere) - (gradient * elsewhere + Vector3(0.5, -0.1, 0.2))).norm(), 1e-12);
    for (auto &point : points)
        point.z() = 0.0;
    EXPECT_FALSE(best_affine_motion(points, targets));
    EXPECT_FALSE(best_affine_motion(std::span(points).first(3), std::span(targets).first(3)));
}

/// A reflection would fit better, and no body does that.
TEST(BestRigidMotion, IsNoReflection) {
    const std::vector<Vector3> points{{1, 0, 0}, {0, 1, 0}, {0, 0, 0.1}, {-1, -1, -0.1}};
    std::vector<Vector3> targets;
    for (const auto &point : points)
        targets.emplace_back(point.x(), point.y(), -point.z());
    EXPECT_NEAR(best_rigid_motion(points, targets).gradient.determinant(), 1.0, 1e-12);
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
    /// Rows for what is refused after changes of one of the three texts.
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

TEST_F(OwnRingDown, ThatIsNoneIsRefused) {
    auto refusals = refusals_after(
        {"[\"swings.csv\"] -> [\"none.csv\"]",
         "held = -> hold =", "force = [0.02, 0.0, 0.0] -> displacement = [0.0, 0.0, 0.0]",
         "[state.ring_down] -> [[state.condition]]\npatch = \"x_max\"\nforce = [0.0, 0.0, -1.0]\n[state.ring_down]",
         "mass = 0.002 -> mass = -0.002", "low = [0.0, 0.0, 0.03] -> low = [0.0, 0.0, 0.06]"},
        text_);
    refusals += refusals_after({"time, -> t,", "b_x -> d_x", "\n0.04, -> \n0.045,", "\n0.04, -> \nnan,"}, swings_);
    swings_.resize(swings_.find("\n0.1,") + 1);
    refusals += tests::refusal(
        "a short motion", [&] { read(); }, directory_.string());
    refusals += refusals_after({"c,, -> d,,0.01,0.02,0.02,0.01,0.02,0.0195\nc,z_min,"}, markers_);
    tests::expect_golden("refusals_of_ring_downs", refusals);
}

constexpr double interval = 0.01, tau = 2.0 * std::numbers::pi;

/// Two markers that ring about a place that creeps, the second half as far and the other way round in x.
MarkerMotion ringing(double frequency, double ratio, int num_records, double creep = 0.0) {
    MarkerMotion motion{interval, 2, {}};
    for (int j = 0; j < num_records; ++j) {
        const double time = j * interval;
        const double swing = std::exp(-tau * frequency * ratio * time) * std::cos(tau * frequency * time);
        for (const double part : {1.0, -0.5})
            motion.displacement.emplace_back(0.001 * part * swing, 0.0,
                                             -0.01 - creep * time + 0.008 * std::abs(part) * swing);
    }
    return motion;
}

constexpr std::array<int, 2> both{0, 1};

TEST(FitRinging, FindsFrequencyAndDamping) {
    for (const double frequency : {2.3, 7.7, 14.0})
        for (const double ratio : {0.0, 0.06, 0.2}) {
            const auto found = fit_ringing(ringing(frequency, ratio, 151), both);
            EXPECT_NEAR(found.frequency, frequency, 1e-4 * frequency) << ratio;
            EXPECT_NEAR(found.ratio, ratio, 1e-4) << frequency;
        }
}

TEST(FitRinging, IsNotMisledByCreep) {
    const auto found = fit_ringing(ringing(4.3, 0.05, 151, 0.002), both);
    EXPECT_NEAR(found.frequency, 4.3, 1e-3);
    EXPECT_NEAR(found.ratio, 0.05, 1e-3);
}

TEST(FitRinging, OfALostMotionIsNone) {
    auto motion = ringing(4.3, 0.05, 151);
    motion.displacement.back().x() = std::nan("");
    EXPECT_TRUE(std::isnan(fit_ringing(motion, both).frequency));
    EXPECT_TRUE(std::isnan(fit_ringing(ringing(4.3, 0.05, 5), both).ratio));
}

TEST(MeasuredRinging, IsAsUncertainAsItsRepeatsDiffer) {
    const std::vector repeats{ringing(4.2, 0.05, 151), ringing(4.4, 0.07, 151)};
    const auto found = measured_ringing(repeats, both);
    EXPECT_NEAR(found.value.frequency, 4.3, 1e-3);
    EXPECT_NEAR(found.value.ratio, 0.06, 1e-3);
    EXPECT_NEAR(found.frequency_uncertainty, 0.1, 0.01);
    EXPECT_NEAR(found.ratio_uncertainty, 0.01, 0.001);
    EXPECT_LT(measured_ringing(std::span(repeats).first(1), both).frequency_uncertainty, 1e-3);
}

TEST(MeasuredRingDown, OfFewerThanThreeMarkersHasNoRigidMotion) {
    const RingDown ring_down{.state = "s", .repeats = {ringing(4.3, 0.05, 151)}, .body = {}, .load_case = {}};
    const std::vector<Vector3> positions{{0.0, 0.0, 0.1}, {0.02, 0.0, 0.1}};
    const auto measured = studies::measured_ring_down(ring_down, positions, both);
    EXPECT_TRUE(std::isnan(measured.rigid_motion));
    EXPECT_GT(measured.no_motion, 0.0);
    EXPECT_NEAR(measured.frequency, 4.3, 1e-3);
}

TEST(Swings, FadeAsTheDampingSays) {
    const double ratio = 0.05, frequency = 4.3;
    const auto found = swings(ringing(frequency, ratio, 151), both, frequency, 4);
    const double fade = std::exp(-0.5 * tau * ratio); // from one turning point to the next
    double reach = 0.0075 * 0.8;                      // mean of both markers
    for (const double swing : found) {
        EXPECT_NEAR(swing, 0.5 * reach * (1.0 + fade), 0.005 * reach);
        reach *= fade;
    }
    EXPECT_TRUE(std::isnan(swings(ringing(frequency, ratio, 40), both, frequency, 4).back())); // over before
}

} // namespace
} // namespace livermark::experiments
