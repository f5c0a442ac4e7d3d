#include "results/tables/studies/band_proposals.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <limits>

#include "results/hdf5/result_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/livermark_command.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

using tests::sample_result;

/// "springs" and "stiffer" have an error of their own, the other models of the sample none that counts.
Result sample(const std::string &load_case, double springs, double stiffer) {
    auto result = sample_result();
    result.problem.load_case.name = load_case;
    result.models.push_back(tests::stiffer(result.models.at(1)));
    result.models.at(1).comparison->relative_l2 = springs;
    result.models.back().comparison->relative_l2 = stiffer;
    return result;
}

constexpr auto origin = "livermark run, 2026-11-21, commit 0123abc-dirty, against fem_p2";

TEST(BandProposals, AreTheErrorsOfTheModelsThatWereCompared) {
    const std::vector results{sample("pull", 0.123449, 1.0), sample("hang", 0.0, 0.99996)};
    const auto found = propose_bands(results, {}, {});
    EXPECT_EQ(proposed_bands(found.proposals, false),
              (std::map<BandKey, ErrorBand>{{{"box", "pull", "springs"}, {0.1234, 0.002, origin}},
                                            {{"box", "pull", "stiffer"}, {1.0, 0.002, origin}},
                                            {{"box", "hang", "springs"}, {0.0, 0.002, origin}},
                                            {{"box", "hang", "stiffer"}, {1.0, 0.002, origin}}}));
    EXPECT_TRUE(std::ranges::is_sorted(found.proposals, {}, &BandProposal::key));
    ASSERT_EQ(found.passed_over.size(), 4u); // two models of each result found no solution
    EXPECT_EQ(found.passed_over[0], "box under pull: blown_up found no solution: a node left the room");
}

TEST(BandProposals, AreOnlyOfTheModelsThatAreAskedFor) {
    const std::vector results{sample("pull", 0.1, 0.2)};
    const auto found = propose_bands(results, std::vector<std::string>{"stiffer", "fem_p2"}, {});
    ASSERT_EQ(found.proposals.size(), 1u);
    EXPECT_EQ(found.proposals[0].key, (BandKey{"box", "pull", "stiffer"}));
    EXPECT_TRUE(found.passed_over.empty());
}

TEST(BandProposals, AreDueWhereAnErrorIsNewOrLeftItsBand) {
    ErrorBands present;
    present.bands[{"box", "pull", "springs"}] = {0.1, 0.002, "before"};
    const auto is_due = [&](double error) {
        const std::vector results{sample("pull", error, 0.2)};
        const auto found = propose_bands(results, {}, present);
        EXPECT_EQ(found.proposals.at(0).present, (ErrorBand{0.1, 0.002, "before"}));
        EXPECT_EQ(found.proposals.at(1).present, std::nullopt);
        EXPECT_TRUE(found.proposals.at(1).is_due());
        EXPECT_EQ(proposed_bands(found.proposals, true).size(), 2u);
        return found.proposals.at(0).is_due();
    };
    EXPECT_FALSE(is_due(0.1015));
    EXPECT_TRUE(is_due(0.103));
    EXPECT_TRUE(is_due(0.097)); // better is a miss as well
}

TEST(BandProposals, AreNoneWhereAnotherReferenceMightBeChosenOrAnErrorIsNotFinite) {
    std::vector results{sample("pull", 0.1, 0.2)};
    results[0].models[1].comparison->relative_l2 = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(propose_bands(results, {}, {}).proposals.size(), 1u);
    results[0].reference_uncertainty.reset();
    const auto found = propose_bands(results, {}, {});
    EXPECT_TRUE(found.proposals.empty());
    ASSERT_EQ(found.passed_over.size(), 1u);
    EXPECT_NE(found.passed_over[0].find("run it without --reference-on-mesh"), std::string::npos);
}

TEST(BandProposals, RefuseTwoResultsOfOneProblem) {
    const std::vector results{sample("pull", 0.1, 0.2), sample("pull", 0.1, 0.2)};
    tests::expect_input_error([&] { propose_bands(results, {}, {}); },
                              {"box under pull", "two result files", "give the folder of one run"});
}

/// The command, beside a file of bands that is not the one that ships.
class BandsCommand : public tests::ResultFolder {
  protected:
    void SetUp() override {
        ResultFolder::SetUp();
        std::filesystem::create_directories(directory_ / "results" / "runs");
        write_bands("# none yet\n");
    }
    std::filesystem::path bands_file() const { return directory_ / "results" / "error_bands.toml"; }
    void write_bands(const std::string &text) const { std::ofstream(bands_file()) << text; }
    void write(const Result &result) const {
        write_result(directory_ / "results" / "runs" / (result.problem.load_case.name + ".h5"), result);
    }
    tests::Outcome bands(const std::string &arguments) const {
        return tests::run_command(
            fmt::format("(LIVERMARK_ROOT={} {} bands {})", directory_.string(), LIVERMARK_BINARY, arguments));
    }
};

TEST_F(BandsCommand, ProposesLinesThatHoldEveryResult) {
    const std::vector results{sample("pull", 0.123449, 1.0), sample("hang", 0.0, 0.99996)};
    for (const auto &result : results)
        write(result);
    const auto said = bands("");
    EXPECT_EQ(said.status, 0) << said.output;
    EXPECT_NE(said.output.find("4 of these errors are new, 0 have left their bands, 0 are in their bands"),
              std::string::npos)
        << said.output;
    EXPECT_NE(said.output.find("commit and run again"), std::string::npos) << said.output;
    ASSERT_EQ(bands(fmt::format("2>/dev/null >>{}", bands_file().string())).status, 0);
    const auto pasted = read_error_bands(bands_file());
    for (const auto &result : results)
        for (const auto *model : {&result.models.at(1), &result.models.back()})
            EXPECT_TRUE(pasted.find("box", result.problem.load_case.name, model->name)
                            .value()
                            .contains(model->comparison->relative_l2))
                << model->name;
    const auto again = bands("");
    EXPECT_NE(again.output.find("0 of these errors are new, 0 have left their bands, 4 are in their bands"),
              std::string::npos)
        << again.output;
    EXPECT_EQ(again.output.find("[[group]]"), std::string::npos) << again.output;
    EXPECT_NE(bands("--all").output.find("springs = { hang = 0, pull = 0.1234 }"), std::string::npos);
}

TEST_F(BandsCommand, SaysWhichLineAChangedEntryHas) {
    write(sample("pull", 0.3, 0.2));
    write_bands("[[group]]\norigin = 'x'\nmargin = 0.002\n[group.relative_l2.box]\nsprings = {pull = 0.25}\n");
    const auto said = bands("--model springs");
    EXPECT_EQ(said.status, 0) << said.output;
    EXPECT_NE(
        said.output.find(bands_file().string() +
                         ":5: box under pull: springs had 25.00 +- 0.20 % and now has 30.00 %; remove the old line"),
        std::string::npos)
        << said.output;
    EXPECT_NE(said.output.find("springs = { pull = 0.3 }"), std::string::npos) << said.output;
    EXPECT_EQ(said.output.find("stiffer"), std::string::npos) << said.output;
}

TEST_F(BandsCommand, PassesOverABodyOfOtherMaterialsThanItShipsWith) {
    auto result = sample("pull", 0.3, 0.2);
    auto body = *result.problem.body;
    body.name = "beam";
    result.problem.body = std::make_shared<const core::Body>(std::move(body));
    write(result);
    std::filesystem::create_directory_symlink(LIVERMARK_SOURCE_DIR "/meshes", directory_ / "meshes");
    const auto said = bands("");
    EXPECT_EQ(said.status, 0) << said.output;
    EXPECT_NE(said.output.find("skipped: beam under pull: the body ships with other materials"), std::string::npos)
        << said.output;
    EXPECT_NE(said.output.find("0 of these errors are new"), std::string::npos) << said.output;
}

TEST_F(BandsCommand, LeavesAFolderBehindItsModelsToTheFiles) {
    write(sample("pull", 0.3, 0.2));
    const auto folder = (directory_ / "results" / "runs").string();
    const auto before = bands(folder + " --model springs --all"),
               behind = bands("--model springs " + folder + " --all");
    EXPECT_EQ(behind.status, 0) << behind.output;
    EXPECT_EQ(behind.output, before.output);
    EXPECT_EQ(bands("--model springs " + folder + "/nowhere").status, 2);
}

TEST_F(BandsCommand, RefusesWhatItCannotRead) {
    EXPECT_EQ(bands("").status, 2); // no result files
    write(sample("pull", 0.3, 0.2));
    const auto misspelt = bands("--model sprigns");
    EXPECT_EQ(misspelt.status, 2);
    EXPECT_NE(misspelt.output.find("did you mean 'springs'?"), std::string::npos) << misspelt.output;
    write_bands("[[group]]\norigin = 'x'\n");
    const auto broken = bands("");
    EXPECT_EQ(broken.status, 2);
    EXPECT_NE(broken.output.find(":1: 'margin' is missing"), std::string::npos) << broken.output;
}

} // namespace
} // namespace livermark::results
