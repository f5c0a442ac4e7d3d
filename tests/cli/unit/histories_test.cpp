#include <array>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "results/hdf5/hdf5_io.hpp"

namespace livermark {
namespace {

/// u of m u'' + b u' + k u = 0 from u = 1 m at rest.
double exact(double mass, double stiffness, double damping, double time) {
    const std::complex<double> root = std::sqrt(std::complex<double>(damping * damping - 4.0 * mass * stiffness, 0.0));
    const auto fast = (-damping - root) / (2.0 * mass), slow = (-damping + root) / (2.0 * mass);
    return ((fast * std::exp(slow * time) - slow * std::exp(fast * time)) / (fast - slow)).real();
}

class Histories : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        // ctest runs each test in a process of its own, several at a time.
        folder = std::filesystem::path(testing::TempDir()) / fmt::format("livermark_histories_{}", getpid());
        std::filesystem::remove_all(folder);
        status = std::system((LIVERMARK_BINARY " histories liver_healthy --duration 0.1 --output " + folder.string() +
                              " > /dev/null 2>&1")
                                 .c_str());
    }
    static void TearDownTestSuite() { std::filesystem::remove_all(folder); }
    void SetUp() override { ASSERT_EQ(status, 0); }

    static std::filesystem::path folder;
    static int status;
};

std::filesystem::path Histories::folder;
int Histories::status = -1;

TEST_F(Histories, FollowTheExactMotionOfOneDegreeOfFreedomInShortSteps) {
    const results::hdf5::InputFile file(folder / "one_degree_of_freedom" / "histories.h5");
    int num_short = 0;
    for (const auto &name : file.children("/histories")) {
        const auto group = "/histories/" + name;
        const bool is_pushed = name.ends_with("_step_force");
        for (const char *step : {"/2", "/3"}) { // 0.05 and 0.005 s
            const auto history = group + step;
            const double part = file.number(history, "time_step") / file.number(group, "critical_time_step");
            if (part > 0.1)
                continue;
            // The first term that a step of order 4 leaves out of e^z; |z| is about 2.8 where it is critical.
            // Where the two roots nearly meet, its derivative counts as well: 1 + 5 times.
            const double error_of_step = 6.0 * std::pow(2.8 * part, 5) / 120.0;
            ++num_short;
            EXPECT_TRUE(std::isnan(file.number(history, "diverged_at"))) << history;
            const auto time = file.dataset<double>(history + "/time");
            const auto displacement = file.dataset<double>(history + "/displacement");
            ASSERT_EQ(displacement.size(), time.size());
            EXPECT_NEAR(time.back(), 0.1, 1e-12);
            for (std::size_t k = 0; k < time.size(); ++k) {
                const double let_go = exact(file.number(group, "mass"), file.number(group, "stiffness"),
                                            file.number(group, "damping"), time[k]);
                EXPECT_NEAR(displacement[k], is_pushed ? 1.0 - let_go : let_go,
                            1e-12 + static_cast<double>(k) * error_of_step)
                    << history;
            }
        }
    }
    EXPECT_GE(num_short, 20);
}

TEST_F(Histories, SayWhenAMotionLeftAllBounds) {
    const results::hdf5::InputFile file(folder / "one_degree_of_freedom" / "histories.h5");
    const std::string history = "/histories/both_in_kilo_with_tumour_release/3"; // 0.005 s, and 0.0014 s would do
    const double time = file.number(history, "diverged_at");
    EXPECT_GT(time, 0.0);
    EXPECT_EQ(file.dataset<double>(history + "/time").back(), time);
    const auto displacement = file.dataset<double>(history + "/displacement");
    EXPECT_GT(std::abs(displacement.back()), 1000.0);
    EXPECT_LE(std::abs(displacement[displacement.size() - 2]), 1000.0);
}

TEST_F(Histories, OfALiverStartWhereTheProbeWasPulledTo) {
    const results::hdf5::InputFile file(folder / "liver_healthy" / "histories.lloyd.h5");
    const double critical = file.number("/histories/release", "critical_time_step");
    ASSERT_EQ(file.children("/histories/release").size(), 5u); // the four steps and a safe one
    for (const auto &step : file.children("/histories/release")) {
        const auto history = "/histories/release/" + step;
        const auto displacement = file.dataset<double>(history + "/displacement");
        // The load case is made for a millimetre, which springs overshoot.
        EXPECT_GT(displacement.front(), 0.0005);
        EXPECT_LT(displacement.front(), 0.003);
        const bool is_stable = file.number(history, "time_step") < critical;
        EXPECT_EQ(std::isnan(file.number(history, "diverged_at")), is_stable) << history;
        EXPECT_EQ(is_stable, step == "4");
        if (is_stable) {
            EXPECT_LT(std::abs(displacement.back()), displacement.front());
        }
    }
}

} // namespace
} // namespace livermark
