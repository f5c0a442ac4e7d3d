#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// A small bar of its own, so that nothing takes long.
class Resume : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = tests::folder_with_bar("resume");
        for (const auto *name : {"first", "second"})
            write_load_case(name, 10.0);
    }

    void write_load_case(const std::string &name, double pull) const {
        std::ofstream(folder_ / (name + ".toml")) << fmt::format(
            "title = \"pull\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_min\"\n"
            "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\ntraction = [{:.1f}, 0.0, 0.0]\n",
            pull);
    }

    tests::Outcome run(const std::string &more) const {
        const auto at = [&](const char *name) { return (folder_ / name).string(); };
        return tests::livermark(
            fmt::format("run --body {} --load-case {} {} --model lloyd --reference-on-mesh --output {}{}",
                        at("bar.toml"), at("first.toml"), at("second.toml"), at("runs"), more));
    }

    fs::path file(const std::string &name) const { return folder_ / "runs" / "bar" / (name + ".h5"); }
    std::string created(const std::string &name) const { return results::read_result(file(name)).provenance.created; }

    fs::path folder_;
};

bool is_resumed(const tests::Outcome &outcome, const std::string &load_case) {
    return outcome.output.find("bar / " + load_case + " / lloyd, kept") != std::string::npos;
}

TEST_F(Resume, KeepsWhatIsThereAndComesToTheSameTable) {
    const auto whole = run("");
    ASSERT_EQ(whole.status, 0) << whole.output;
    fs::remove(file("second"));
    const auto first_time = created("first");
    const auto resumed = run(" --resume");
    EXPECT_EQ(resumed.status, 0) << resumed.output;
    EXPECT_TRUE(is_resumed(resumed, "first")) << resumed.output;
    EXPECT_FALSE(is_resumed(resumed, "second"));
    EXPECT_EQ(created("first"), first_time);
    EXPECT_EQ(results::read_result(file("second")).provenance.command.find("--resume"), std::string::npos);
    EXPECT_TRUE(is_resumed(run(" --resume"), "second"));
}

TEST_F(Resume, HoldsAgainWhatIsDamagedOrOtherwise) {
    ASSERT_EQ(run("").status, 0);
    fs::resize_file(file("first"), fs::file_size(file("first")) / 2);
    write_load_case("second", 11.0);
    const auto resumed = run(" --resume");
    EXPECT_EQ(resumed.status, 0) << resumed.output;
    EXPECT_FALSE(is_resumed(resumed, "first"));
    EXPECT_FALSE(is_resumed(resumed, "second"));
    EXPECT_NO_THROW(results::read_result(file("first")));
    // Without it nothing is kept, and neither is what another command has made.
    EXPECT_FALSE(is_resumed(run(""), "first"));
    EXPECT_FALSE(is_resumed(run(" --young 6000 --resume"), "first"));
}

} // namespace
} // namespace livermark
