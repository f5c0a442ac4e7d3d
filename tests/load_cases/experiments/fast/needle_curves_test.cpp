#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/support/input_error.hpp"
#include "load_cases/experiments/needle_curves.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

namespace livermark::experiments {
namespace {

const NeedleRecord &needle_record(const std::string &name) {
    return support::find_named(all_needle_records(), name, "record of a needle");
}

/// A needle that goes in by 0.5 of a unit in 2 s, stands for 4 s and goes out in 2 s. It touches at 0.1, the surface
/// gives way at 0.2 with 0.6 N, behind it is 0.1 N and 2 N for each unit more; while it stands the force falls to half,
/// and on the way out it is pulled with 0.3 N until it is where it touched.
struct NeedleTables : tests::ResultFolder {
    static constexpr double rate_in_units = 0.25, in_ends = 2.0, out_begins = 6.03, ends = 8.0;
    std::string displacement_ = "0, 0\n2, 0.5\n6, 0.5\n8, 0\n", force_;

    static double force_at(double time) {
        const double at = rate_in_units * time;
        if (time > out_begins)
            return rate_in_units * (ends - time) > 0.1 ? -0.3 : 0.0;
        if (time > in_ends)
            return 0.7 * (1.0 - 0.5 * (time - in_ends) / (out_begins - in_ends));
        if (at <= 0.2)
            return std::max(0.0, 6.0 * (at - 0.1));
        return 0.1 + 2.0 * (at - 0.2);
    }
    void SetUp() override {
        ResultFolder::SetUp();
        std::filesystem::create_directories(directory_ / "needle");
        for (int step = 0; step <= 800; ++step)
            force_ += fmt::format("{:g}, {:.6g}\n", 0.01 * step, force_at(0.01 * step));
    }
    NeedleCurve read(const std::string &displacement, const std::string &force,
                     double rate = nominal_needle_rate) const {
        written("needle/time_displacement.csv", displacement);
        written("needle/time_force.csv", force);
        return read_needle_curve(needle_record("time_force"), directory_, rate);
    }
    NeedleCurve read_depths(const std::string &text) const {
        written("needle/depth_force.csv", text);
        return read_needle_curve(needle_record("depth_force"), directory_);
    }
};

TEST_F(NeedleTables, OverTimeHaveDepthsAtTheGivenRate) {
    const auto curve = read(displacement_, force_);
    // A unit is 0.003 / 0.25 = 0.012 m, and the way in ends at 99 % of 6 mm.
    EXPECT_EQ(curve.depth.size(), 199U);
    EXPECT_NEAR(*std::ranges::max_element(curve.depth), 0.99 * 0.006, 1e-9);
    EXPECT_NEAR(curve.depth[40], 0.0012, 1e-9);
    EXPECT_NEAR(curve.stretch, 0.99 * 0.006 / 24.0, 1e-9);
    EXPECT_NEAR(curve.out_depth.front(), 0.99 * 0.006, 1e-5);
    EXPECT_NEAR(curve.out_depth.back(), 0.0, 1e-9);
    EXPECT_NEAR(curve.held.seconds, 4.04, 1e-9);
    EXPECT_NEAR(curve.held.first_force, 0.7, 0.02);
    EXPECT_NEAR(curve.held.last_force, 0.35, 0.02);
    const auto faster = read(displacement_, force_, 0.006);
    ASSERT_EQ(faster.depth.size(), curve.depth.size());
    for (std::size_t p = 0; p < curve.depth.size(); ++p)
        EXPECT_NEAR(faster.depth[p], 2.0 * curve.depth[p], 1e-12);
    EXPECT_EQ(faster.force, curve.force);
    ASSERT_EQ(curve.unknown.size(), 4U);
    tests::expect_part(curve.unknown[2], "at 3 mm/s, as taken here, it is 12.0 mm");
    tests::expect_part(curve.unknown[2], "went in at 6.3 mm/s, and depths are to be multiplied by 2.12");
    tests::expect_part(curve.unknown[3], "the needle went 4.6 mm from where it touched");
}

TEST_F(NeedleTables, HaveThePhasesThatWereWritten) {
    const auto phases = phases_of(read(displacement_, force_));
    EXPECT_NEAR(phases.puncture.depth, 0.0024, 1e-5);
    EXPECT_NEAR(phases.puncture.force, 0.6, 1e-6);
    EXPECT_NEAR(phases.touched_at, 0.0012 + 0.1 * 0.0012, 3.1e-5); // a tenth of the force, to a point
    EXPECT_NEAR(phases.lowest, 0.1, 0.01);
    EXPECT_NEAR(phases.slope, 2.0 / 0.012, 0.02 * 2.0 / 0.012);
    EXPECT_NEAR(phases.pull, 0.3, 1e-6);
}

/// Points that are read off a figure may be several at one time, and forces may begin before displacements.
TEST_F(NeedleTables, TakeWhatFiguresHave) {
    const auto curve = read(displacement_, force_);
    EXPECT_EQ(read(displacement_, "0, 0\n0, 0.001\n" + force_).depth.size(), curve.depth.size() + 2U);
    const auto later = read("0.2, 0.049\n2, 0.5\n6, 0.5\n8, 0\n", force_);
    EXPECT_EQ(later.depth.size(), curve.depth.size() - 20U);
    const auto only_in = read("0, 0\n2, 0.5\n8, 0.5\n", force_);
    EXPECT_TRUE(only_in.out_depth.empty());
    EXPECT_TRUE(std::isnan(phases_of(only_in).pull));
    EXPECT_TRUE(std::isnan(only_in.held.seconds));
}

TEST_F(NeedleTables, OverTimeRefuseWhatTheyCannotBe) {
    const auto refuse = [&](const std::string &displacement, const std::string &force,
                            const std::vector<std::string> &parts, double rate = nominal_needle_rate) {
        tests::expect_input_error([&] { read(displacement, force, rate); }, parts);
    };
    refuse("0, 0\n2, 0.5, 1\n", force_, {"time_displacement.csv:2", "3 cells and not 2"});
    refuse("0, 0\n2, half\n", force_, {"time_displacement.csv:2", "'half'", "not a finite number"});
    refuse("0, 0\nnan, 0.5\n", force_, {"time_displacement.csv:2", "not a finite number"});
    refuse("0, 0\n2, 0.5\n1, 0.6\n", force_, {"time_displacement.csv:3", "1 s is not after the one before"});
    refuse("0, 0\n2, 0.5\n2, 0.6\n", force_, {"time_displacement.csv:3", "2 s is not after the one before"});
    refuse("-1, 0\n2, 0.5\n", force_, {"time_displacement.csv:1", "no time of a needle"});
    refuse("", force_, {"time_displacement.csv", "empty"});
    refuse("0, 0\n2, 0\n", force_, {"time_displacement.csv", "goes in from zero"});
    refuse("0, 0\n2, 0.5\n4, -0.2\n", force_, {"time_displacement.csv", "from -0.2 to 0.5"});
    refuse("0, 0.5\n2, 0\n", force_, {"time_displacement.csv", "begin with 0.5"});
    refuse(displacement_, "0, 0\n1, 0.3\n0.5, 0.2\n", {"time_force.csv:3", "0.5 s is before"});
    refuse(displacement_, "0, 0\n1, inf\n", {"time_force.csv:2", "not a finite number"});
    refuse(displacement_, "0, 0\n1, 2000\n", {"time_force.csv:2", "SI units"});
    refuse(displacement_, "", {"time_force.csv", "empty"});
    refuse("10, 0\n12, 0.5\n", force_, {"time_force.csv", "0 forces are at times from 10 to 11.98 s"});
    refuse(displacement_, force_, {"time_force.csv", "--rate"}, 1.0);
    refuse(displacement_,
           "0, 0\n0.1, 0.1\n0.2, 0.2\n0.3, 0.3\n0.4, 0.4\n0.5, 0.5\n0.6, 0.6\n0.7, 0.7\n0.8, 0.8\n"
           "0.9, 0.9\n1, 1\n",
           {"'time_force' never falls to half"});
}

TEST_F(NeedleTables, OverDepthRefuseWhatTheyCannotBe) {
    EXPECT_EQ(read_depths("0, 0\n0.01, 1\n").depth.size(), 2U);
    for (const auto *bad : {"0, 0\n10, 1\n", "0, 0\n0.01, 1000\n", "0, 0\n-0.01, 1\n"})
        tests::expect_input_error([&] { read_depths(bad); }, {"depth_force.csv:2", "SI units"});
    tests::expect_input_error([&] { read_depths("0, 0\n0.01\n"); }, {"depth_force.csv:2", "1 cells and not 2"});
    tests::expect_input_error([&] { read_depths(" \n"); }, {"no points"});
    const auto rising = read_depths("0, 0\n0.01, 1\n0.02, 2\n");
    tests::expect_input_error([&] { puncture_of(rising); }, {"'depth_force' never falls to half", "public file"});
    const auto short_one = read_depths("0, 0\n0.01, 1\n0.0101, 0.1\n");
    tests::expect_input_error([&] { phases_of(short_one); }, {"ends within 0.004 m of its puncture"});
}

/// Noise before the needle touches also falls to half of what it was.
TEST_F(NeedleTables, ArePuncturedWhereTheForceIsWorthIt) {
    const auto curve = read_depths("0, 0.1\n0.001, 0.01\n0.002, 0.1\n0.01, 1\n0.011, 0.4\n0.02, 2.9\n0.03, 1.4\n");
    EXPECT_EQ(puncture_of(curve).depth, 0.01);
    const auto stronger = read_depths("0, 0.1\n0.001, 0.01\n0.002, 0.1\n0.01, 1\n0.011, 0.4\n0.02, 3.1\n0.03, 1.4\n");
    EXPECT_EQ(puncture_of(stronger).depth, 0.02);
}

TEST_F(NeedleTables, ThatAreNotThereSayWhereToGetThem) {
    written("needle/time_displacement.csv", displacement_);
    const NeedleRecord record{"my_needle", "", {"needle/time_displacement.csv", "needle/no_such_force.csv"}};
    EXPECT_FALSE(is_there(record, directory_));
    tests::expect_input_error([&] { read_needle_curve(record, directory_); },
                              {"needle/no_such_force.csv", "'my_needle'", "dataset_lib", "time [s] and force [N]",
                               "LIVERMARK_EXPERIMENTS", "--data"});
    written("needle/no_such_force.csv", force_);
    EXPECT_TRUE(is_there(record, directory_));
}

} // namespace
} // namespace livermark::experiments
