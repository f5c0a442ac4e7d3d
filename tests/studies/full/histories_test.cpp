#include "studies/histories/histories.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <string>
#include <unistd.h>

#include "tests/bad_input.hpp"

namespace livermark::studies {
namespace {

/// u of m u'' + b u' + k u = 0 from u = 1 m at rest.
double exact(double mass, double stiffness, double damping, double time) {
    const std::complex<double> root = std::sqrt(std::complex<double>(damping * damping - 4.0 * mass * stiffness, 0.0));
    const auto fast = (-damping - root) / (2.0 * mass), slow = (-damping + root) / (2.0 * mass);
    return ((fast * std::exp(slow * time) - slow * std::exp(fast * time)) / (fast - slow)).real();
}

/// Of one degree of freedom and of the healthy liver.
class HistoriesStudy : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        // ctest runs each test in a process of its own, several at a time.
        folder = std::filesystem::path(testing::TempDir()) / fmt::format("livermark_histories_{}", getpid());
        HistoriesOptions options;
        options.bodies = {"liver_healthy"};
        options.duration = 0.1;
        options.output = folder.string();
        found = find_histories(options, "test", {}).of_subject;
    }
    static void TearDownTestSuite() {
        found.clear();
        std::filesystem::remove_all(folder);
    }
    void SetUp() override { ASSERT_EQ(found.size(), 2u); }

    static std::filesystem::path folder;
    static std::vector<results::Histories> found;
};

std::filesystem::path HistoriesStudy::folder;
std::vector<results::Histories> HistoriesStudy::found;

TEST_F(HistoriesStudy, FollowTheExactMotionOfOneDegreeOfFreedomInShortSteps) {
    int num_short = 0;
    for (const auto &entry : found[0].cases) {
        const std::map<std::string, double> of(entry.parameters.begin(), entry.parameters.end());
        const bool is_pushed = entry.name.ends_with("_step_force");
        for (const auto &history : {entry.steps.at(2), entry.steps.at(3)}) { // 0.05 and 0.005 s
            const double part = history.time_step / entry.critical_time_step;
            if (part > 0.1)
                continue;
            // The first term that a step of order 4 leaves out of e^z; |z| is about 2.8 where it is critical.
            // Where the two roots nearly meet, its derivative counts as well: 1 + 5 times.
            const double error_of_step = 6.0 * std::pow(2.8 * part, 5) / 120.0;
            ++num_short;
            EXPECT_TRUE(std::isnan(history.diverged_at)) << entry.name;
            ASSERT_EQ(history.displacement.size(), history.time.size());
            EXPECT_NEAR(history.time.back(), 0.1, 1e-12);
            for (std::size_t k = 0; k < history.time.size(); ++k) {
                const double let_go = exact(of.at("mass"), of.at("stiffness"), of.at("damping"), history.time[k]);
                EXPECT_NEAR(history.displacement[k], is_pushed ? 1.0 - let_go : let_go,
                            1e-12 + static_cast<double>(k) * error_of_step)
                    << entry.name;
            }
        }
    }
    EXPECT_GE(num_short, 20);
}

TEST_F(HistoriesStudy, SayWhenAMotionLeftAllBounds) {
    const auto &cases = found[0].cases;
    const auto entry = std::ranges::find(cases, "both_in_kilo_with_tumour_release", &results::HistoryCase::name);
    ASSERT_NE(entry, cases.end());
    const auto &history = entry->steps.at(3); // 0.005 s, and 0.0014 s would do
    EXPECT_GT(history.diverged_at, 0.0);
    EXPECT_EQ(history.time.back(), history.diverged_at);
    EXPECT_GT(std::abs(history.displacement.back()), 1000.0);
    EXPECT_LE(std::abs(history.displacement[history.displacement.size() - 2]), 1000.0);
}

TEST_F(HistoriesStudy, OfALiverStartWhereTheProbeWasPulledTo) {
    ASSERT_EQ(found[1].subject, "liver_healthy");
    const auto &release = found[1].cases.at(0);
    ASSERT_EQ(release.steps.size(), 5u); // the four steps and a safe one
    for (const auto &history : release.steps) {
        // The load case is made for a millimetre, which springs overshoot.
        EXPECT_GT(history.displacement.front(), 0.0005);
        EXPECT_LT(history.displacement.front(), 0.003);
        const bool is_stable = history.time_step < release.critical_time_step;
        EXPECT_EQ(std::isnan(history.diverged_at), is_stable) << history.time_step;
        EXPECT_EQ(is_stable, &history == &release.steps.back());
        if (is_stable) {
            EXPECT_LT(std::abs(history.displacement.back()), history.displacement.front());
        }
    }
}

TEST_F(HistoriesStudy, AreInTheFiles) {
    const auto one = results::read_histories(folder / "one_degree_of_freedom" / "histories.h5");
    EXPECT_EQ(one.cases.size(), found[0].cases.size());
    EXPECT_EQ(one.cases.back().steps.back().displacement, found[0].cases.back().steps.back().displacement);
    const auto liver = results::read_histories(folder / "liver_healthy" / "histories.lloyd.h5");
    EXPECT_EQ(liver.cases.at(0).critical_time_step, found[1].cases.at(0).critical_time_step);
}

TEST(HistoriesOptions, AreRefusedWhereTheyComeToMoreThanAMillionSteps) {
    HistoriesOptions options;
    options.time_steps = {1e-6};
    tests::expect_input_error([&] { find_histories(options, "test", {}); }, {"more than a million steps"});
    options.time_steps = {0.1};
    options.bodies = {"liver_healthy"};
    options.load_case = "traction";
    tests::expect_input_error([&] { find_histories(options, "test", {}); },
                              {"load case traction releases nothing", "choose one with a [release]"});
}

} // namespace
} // namespace livermark::studies
