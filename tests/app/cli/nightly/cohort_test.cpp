#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "results/hdf5/result_file.hpp"
#include "results/records/cohort.hpp"
#include "tests/livermark_command.hpp"
#include "tests/result_folder.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// Two livers that are too coarse for anything but a test.
class CohortCommand : public tests::ResultFolder {
  protected:
    tests::Outcome run(int jobs = 1, const std::string &more = "") const {
        return tests::livermark(fmt::format("cohort --bodies 1-2 --tetrahedra 2000 --load-case palpation "
                                            "--model lloyd --reference-on-mesh --jobs {} --output {} {}",
                                            jobs, output(), more));
    }
    std::string output() const { return (directory_ / "cohort").string(); }
    fs::path in(const std::string &name) const { return fs::path(output()) / name; }
    std::string created(int number) const {
        return results::read_result(in(fmt::format("liver_variant_{}/palpation.h5", number))).provenance.created;
    }
    void break_body(int number) const {
        std::ofstream(in(fmt::format("bodies/liver_variant_{}.msh", number))) << "no mesh";
        fs::remove_all(in(fmt::format("liver_variant_{}", number)));
    }
};

bool says(const tests::Outcome &outcome, const std::string &words) {
    return outcome.output.find(words) != std::string::npos;
}

TEST_F(CohortCommand, PrintsTheTableOfItsResultFilesAndKeepsTheirNumbers) {
    const auto outcome = run();
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto table = tests::livermark("table --kind cohort " + output());
    EXPECT_EQ(table.status, 0) << table.output;
    EXPECT_TRUE(says(outcome, table.output)) << outcome.output << table.output;
    EXPECT_TRUE(says(table, "tuning  0.45  lloyd")) << table.output;

    const auto cohort = results::read_cohort(in("cohort.h5"));
    ASSERT_EQ(cohort.bodies.size(), 2U);
    EXPECT_EQ(cohort.bodies[1].number, 2);
    EXPECT_EQ(cohort.tetrahedra, 2000);
    EXPECT_TRUE(cohort.failures.empty());
    std::size_t num_errors = 0;
    for (const auto *body : {"liver_variant_1", "liver_variant_2"}) {
        const auto result = results::read_result(in(fmt::format("{}/palpation.h5", body)));
        for (const auto &model : result.models) {
            if (!model.comparison)
                continue;
            ++num_errors;
            const auto found = std::ranges::find_if(cohort.errors, [&](const results::CohortError &error) {
                return error.body == body && error.model == model.name;
            });
            ASSERT_NE(found, cohort.errors.end()) << model.name;
            EXPECT_EQ(found->relative_l2, model.comparison->relative_l2);
            EXPECT_EQ(found->reaction_error, model.comparison->reaction_error);
            EXPECT_EQ(found->stiffness, model.comparison->tool.value().stiffness());
            EXPECT_EQ(found->load_case, "palpation");
        }
    }
    EXPECT_EQ(cohort.errors.size(), num_errors);
}

TEST_F(CohortCommand, KeepsWhatIsThereWhateverTheNumberOfWorkers) {
    ASSERT_EQ(run().status, 0);
    fs::remove(in("liver_variant_2/palpation.h5"));
    const auto first = created(1);
    const auto again = run(2);
    tests::expect_outcome(again, 0, {"kept: liver_variant_1\n"});
    EXPECT_EQ(created(1), first);
    EXPECT_TRUE(fs::exists(in("liver_variant_2/palpation.h5")));
    EXPECT_FALSE(says(run(1, "--poisson 0.4"), "kept:"));
}

TEST_F(CohortCommand, NamesABrokenBodyAndGoesOnWithTheOthers) {
    ASSERT_EQ(run().status, 0);
    break_body(1);
    const auto outcome = run();
    tests::expect_outcome(
        outcome, 1,
        {"failed: liver_variant_1: ", "remove " + in("bodies/liver_variant_1.toml").string(), "test 0.45 lloyd"});
    const auto cohort = results::read_cohort(in("cohort.h5"));
    EXPECT_EQ(cohort.bodies.size(), 2U);
    EXPECT_EQ(cohort.failures.size(), 1U);
    EXPECT_TRUE(std::ranges::all_of(cohort.errors, [](const auto &error) { return error.body == "liver_variant_2"; }));
    // The remedy that it names.
    fs::remove(in("bodies/liver_variant_1.toml"));
    EXPECT_EQ(run().status, 0);
    EXPECT_TRUE(results::read_cohort(in("cohort.h5")).failures.empty());
}

TEST_F(CohortCommand, RefusesBodiesThatWereMadeOtherwiseAndWritesNothing) {
    fs::create_directories(in("bodies"));
    std::ofstream(in("bodies/liver_variant_2.toml"))
        << "generator = 'livermark mesh liver --variant 2 --tetrahedra 2500 -o liver_variant_2.msh'\n";
    const auto outcome = run();
    tests::expect_outcome(outcome, 2, {"give the --tetrahedra that it was made with"});
    EXPECT_FALSE(fs::exists(in("cohort.h5")));
    EXPECT_FALSE(fs::exists(in("bodies/liver_variant_1.toml")));
}

TEST_F(CohortCommand, LetsASweptConstantBeAModelOfItsOwn) {
    const auto outcome =
        tests::livermark(fmt::format("cohort --bodies 1 --tetrahedra 2000 --load-case palpation --model nodal_springs "
                                     "--sweep nodal_springs.a=0.2,0.4 --reference-on-mesh --jobs 1 --output {}",
                                     output()));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto cohort = results::read_cohort(in("cohort.h5"));
    const auto error_of = [&](const std::string &model) {
        const auto found = std::ranges::find(cohort.errors, model, &results::CohortError::model);
        return found == cohort.errors.end() ? std::nan("") : found->relative_l2;
    };
    EXPECT_DOUBLE_EQ(error_of("nodal_springs_a_0_2"), error_of("nodal_springs"));
    EXPECT_GT(std::abs(error_of("nodal_springs_a_0_4") - error_of("nodal_springs")), 1e-4);
}

TEST_F(CohortCommand, IsASectionOfTheReportThatStandsForItsBodies) {
    ASSERT_EQ(run().status, 0);
    const auto outcome = tests::livermark("report " + output());
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto page = tests::run_command("cat " + in("report.html").string()).output;
    EXPECT_NE(page.find("<section id=\"cohort\">"), std::string::npos);
    EXPECT_NE(page.find("<dd>1 of cohorts"), std::string::npos);
    EXPECT_NE(page.find("Error of each body at Poisson&#39;s ratio 0.45"), std::string::npos);
    // One body alone is shown in full.
    ASSERT_EQ(tests::livermark("report " + in("liver_variant_1").string()).status, 0);
    const auto one = tests::run_command("cat " + in("liver_variant_1/report.html").string()).output;
    EXPECT_NE(one.find("1 of runs"), std::string::npos);
}

} // namespace
} // namespace livermark
