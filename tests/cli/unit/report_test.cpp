#include "report/report.hpp"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>

#include "results/hdf5/file_kind.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/livermark_command.hpp"
#include "tests/result_folder.hpp"
#include "tests/sample_result.hpp"
#include "tests/sample_timings.hpp"

namespace livermark::report {
namespace {

/// With the number of pieces of a text in it.
std::size_t count(const std::string &text, const std::string &part) {
    std::size_t number = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++number;
    return number;
}

void expect_parts(const std::string &page, const std::vector<std::string> &parts) {
    for (const auto &part : parts)
        EXPECT_NE(page.find(part), std::string::npos) << part;
}

ReportData sample_data() {
    ReportData data;
    data.results = {tests::sample_result()};
    data.files = {"box/pull_and_hang.h5"};
    return data;
}

results::Stability sample_stability() {
    return {.provenance = {},
            .body = "box",
            .spring_law = "lloyd",
            .load_case = "traction",
            .damping = {0.9, 0.001},
            .lowest_frequency = 11.0,
            .largest_frequency = 710.0,
            .largest_frequency_bound = 880.0,
            .element_time_step = 0.0046,
            .limits = {{"heun", {.predicted = 0.0}, {.predicted = 0.002785, .observed = 0.002783}},
                       {"velocity_verlet", {.predicted = 0.0028166, .observed = 0.0028112}, {.predicted = 0.0027}}}};
}

results::Histories sample_histories() {
    return {.provenance = {},
            .subject = "one_degree_of_freedom",
            .integrator = "runge_kutta_4",
            .cases = {{.name = "as_printed_without_tumour_release",
                       .title = "without tumour: k in N/m",
                       .parameters = {{"mass", 2.0}, {"stiffness", 5.0}, {"damping", 7.0}},
                       .critical_time_step = 0.7,
                       .steps = {{.time_step = 1.0, .time = {0, 1}, .displacement = {1, 9000}, .diverged_at = 1.0},
                                 {.time_step = 0.5, .time = {0, 0.5, 1}, .displacement = {1, 0.5, 0.25}}}}}};
}

/// Every section, from a file that has everything and one that has nothing for it.
TEST(Report, HasTheNumbersOfTheFiles) {
    auto data = sample_data();
    data.results[0].models[1].comparison->relative_l2 = 0.123456;
    data.results[0].models[1].comparison->max_error = 0.0012344;
    data.results[0].reference_uncertainty->relative_l2 = 0.0301;
    data.stability = {sample_stability()};
    data.timings = {tests::sample_timings()};
    data.histories = {sample_histories()};
    data.large = {tests::along_a_path(tests::sample_result())};
    const auto page = make_report(data, {}, "livermark report runs");
    expect_parts(page, {"<strong>12.35</strong>",
                        "every model under every large load case",
                        "pull_and_hang: z_max",
                        "± 3.01",
                        "up to 1.234 mm",
                        "pull_and_hang",
                        "2.7850",
                        "2.7830",
                        "-0.07",
                        "none",
                        "2.8166",
                        "2.8112",
                        "-0.19",
                        "not observed",
                        "step/newmark/fem_p1/box",
                        "200000",
                        "h = 1 s: diverges",
                        "h = 0.5 s: stable",
                        "diverged at 1 s",
                        "stable, ends at 0.25 m",
                        "livermark run --body box",
                        "livermark report runs",
                        "0123abc-dirty"});
    EXPECT_NE(page.find("<td class=\"number\">50</td>"), std::string::npos) << "part of the machine's limit [%]";
    EXPECT_EQ(page.find("There are no"), std::string::npos);
}

TEST(Report, SaysWhatIsMissingInItsPlace) {
    auto data = sample_data();
    data.results = {tests::without_motion(data.results[0])};
    data.results[0].reference_uncertainty.reset();
    for (auto &model : data.results[0].models) {
        model.solution.springs.reset();
        model.solution.explicit_steps.reset();
    }
    const auto page = make_report(data, {}, "livermark report runs");
    expect_parts(
        page, {"The uncertainty of the reference is unknown under pull_and_hang",
               "blown_up: diverged: a node left the "
               "room",
               "unfinished: not_converged: 100 iterations were not enough", "No file here contains the time of a step.",
               "No model was moved", "There is no body with several Poisson&#39;s ratios here.",
               "There is no body with meshes of several sizes here", "The reference was solved on one mesh only",
               "There are no stability files here", "There are no timing files here", "There are no history files here",
               "No result file here has the springs of lloyd"});
}

TEST(Report, IsThereWithoutAnyRun) {
    ReportData data;
    data.timings = {tests::sample_timings()};
    const auto page = make_report(data, {}, "livermark report runs");
    EXPECT_EQ(count(page, "There are no result files of small deformations here"), 2u);
    EXPECT_EQ(page.find("<img"), std::string::npos);
}

TEST(Report, ShowsErrorsOverPoissonRatiosAndMeshSizes) {
    auto data = sample_data();
    for (const double ratio : {0.25, 0.49}) {
        auto other = tests::sample_result();
        auto body = *other.problem.body;
        body.materials[0].poisson_ratio = ratio;
        other.problem.body = std::make_shared<core::Body>(body);
        data.results.push_back(other);
        data.files.emplace_back("other.h5");
    }
    auto fine = tests::sample_result(4);
    auto body = *fine.problem.body;
    body.name = "box_2";
    fine.problem.body = std::make_shared<core::Body>(body);
    auto coarse = tests::sample_result(2);
    body = *coarse.problem.body;
    body.name = "box_1";
    coarse.problem.body = std::make_shared<core::Body>(body);
    data.results.insert(data.results.end(), {fine, coarse});
    data.files.insert(data.files.end(), {"fine.h5", "coarse.h5"});
    const auto page = make_report(data, {}, "");
    EXPECT_EQ(page.find("There is no body with"), std::string::npos);
    expect_parts(page,
                 {"box_, pull_and_hang, nu 0.45", ">Poisson&#39;s ratio", "size of an element [mm]", "box, nu 0.25"});
}

TEST(Report, EscapesWhatFilesSay) {
    auto data = sample_data();
    auto body = *data.results[0].problem.body;
    body.name = "<script>alert(1)</script>";
    body.assumptions = {"a & b < c"};
    data.results[0].problem.body = std::make_shared<core::Body>(body);
    data.results[0].problem.load_case.title = "\"><img src=x onerror='alert(2)'>";
    data.results[0].problem.load_case.name = "bad \xff\x01 bytes";
    data.results[0].provenance.command = "livermark run </code><script>";
    data.results[0].models[1].name = "<b>springs</b>";
    const auto page = make_report(data, {}, "livermark report '<runs>'");
    EXPECT_EQ(page.find("<script"), std::string::npos);
    EXPECT_EQ(page.find("<img src=x"), std::string::npos);
    EXPECT_EQ(page.find("<b>"), std::string::npos);
    expect_parts(page,
                 {"&lt;script&gt;alert(1)&lt;/script&gt;", "a &amp; b &lt; c", "bad \xef\xbf\xbd\xef\xbf\xbd bytes"});
}

/// A file may say that a solution is ok whatever is in it.
TEST(Report, DoesNotDrawWhatHasLeftTheRoom) {
    for (const double length : {std::nan(""), 1e200, 1e3}) {
        auto data = sample_data();
        data.results[0].models[1].solution.displacement[0].x() = length;
        const auto page = make_report(data, {}, "");
        EXPECT_EQ(page.find("<img"), std::string::npos) << length;
        EXPECT_EQ(count(page, "No model was compared with a reference here"), 1u);
        auto far = sample_data();
        for (auto &displacement : far.results[0].models[0].solution.displacement)
            displacement.z() = length;
        EXPECT_EQ(count(make_report(far, {}, ""), "The reference does not move, or has diverged"), 1u);
    }
    auto still = sample_data();
    for (auto &displacement : still.results[0].models[0].solution.displacement)
        displacement.setZero();
    EXPECT_EQ(count(make_report(still, {}, ""), "The reference does not move"), 1u);
}

class ReportFolder : public tests::ResultFolder {};

TEST_F(ReportFolder, IsReadByKindOfFile) {
    results::write_result(path_, tests::sample_result());
    results::write_stability(directory_ / "stability.lloyd.h5", sample_stability());
    results::write_histories(directory_ / "histories.h5", sample_histories());
    results::write_timings(directory_ / "timings.h5", tests::sample_timings());
    auto modes = tests::sample_result();
    modes.models.clear();
    modes.reference_uncertainty.reset();
    modes.motion_uncertainty.reset();
    results::write_result(directory_ / "modes.traction.h5", modes);
    EXPECT_EQ(results::kind_of_file(directory_ / "modes.traction.h5"), results::FileKind::modes);
    const auto data = read_report_data(directory_);
    ASSERT_EQ(data.results.size(), 1u);
    EXPECT_EQ(data.files, std::vector<std::string>{"result.h5"});
    EXPECT_EQ(data.others, std::vector<std::string>{"modes.traction.h5"});

    ASSERT_EQ(data.stability.size(), 1u);
    EXPECT_EQ(data.stability[0].spring_law, "lloyd");
    EXPECT_EQ(data.stability[0].damping.beta, 0.001);
    EXPECT_EQ(data.stability[0].limits[0].integrator, "heun");
    EXPECT_EQ(data.stability[0].limits[0].damped.observed, 0.002783);
    EXPECT_TRUE(std::isnan(data.stability[0].limits[1].damped.observed));

    ASSERT_EQ(data.histories.size(), 1u);
    const auto &moved = data.histories[0].cases.at(0);
    EXPECT_EQ(moved.parameters, sample_histories().cases[0].parameters);
    EXPECT_EQ(moved.steps.at(1).displacement, (std::vector<double>{1, 0.5, 0.25}));
    EXPECT_EQ(moved.steps.at(0).diverged_at, 1.0);

    ASSERT_EQ(data.timings.size(), 1u);
    auto expected = tests::sample_timings().timings;
    ASSERT_EQ(data.timings[0].timings.size(), expected.size());
    for (const auto &timing : data.timings[0].timings) {
        const auto same = std::ranges::find(expected, timing.name, &results::Timing::name);
        ASSERT_NE(same, expected.end()) << timing.name;
        EXPECT_EQ(timing.seconds, same->seconds);
        EXPECT_EQ(timing.counters, same->counters);
        EXPECT_EQ(timing.is_wall_clock, same->is_wall_clock);
        EXPECT_EQ(timing.iterations, same->iterations);
    }
}

std::string text_of(const std::filesystem::path &path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// What is whole is worth a report; what is not stands in it, on standard error and in the exit status.
TEST_F(ReportFolder, SaysWhatItLeftOut) {
    results::write_result(path_, tests::sample_result());
    results::write_result(directory_ / "second.h5", tests::sample_result());
    std::filesystem::resize_file(directory_ / "second.h5", 5000);
    const auto outcome = tests::livermark("report " + directory_.string());
    EXPECT_EQ(outcome.status, 1) << outcome.output;
    EXPECT_NE(outcome.output.find("left out: " + (directory_ / "second.h5").string()), std::string::npos)
        << outcome.output;
    expect_parts(text_of(directory_ / "report.html"), {"1 of runs", "<dt>Left out</dt><dd>second.h5"});
}

TEST_F(ReportFolder, IsRefusedWithDamagedFilesAloneAndLeavesAnEarlierReport) {
    results::write_result(path_, tests::sample_result());
    ASSERT_EQ(tests::livermark("report " + directory_.string()).status, 0);
    const auto before = text_of(directory_ / "report.html");
    std::filesystem::resize_file(path_, 5000);
    const auto outcome = tests::livermark("report " + directory_.string());
    EXPECT_EQ(outcome.status, 2) << outcome.output;
    EXPECT_NE(outcome.output.find(path_.string()), std::string::npos) << outcome.output;
    EXPECT_EQ(text_of(directory_ / "report.html"), before);
    EXPECT_EQ(files().size(), 2u) << "something was left behind";
}

TEST_F(ReportFolder, SetsTable1BesideTheSpringsOfALiver) {
    auto result = tests::sample_result(); // a box of two litres
    result.models[1].name = "lloyd";
    result.reference_uncertainty->refined = "lloyd";
    result.motion_uncertainty->refined = "lloyd";
    results::write_result(path_, result);
    ASSERT_EQ(tests::livermark("report " + directory_.string()).status, 0);
    expect_parts(text_of(directory_ / "report.html"),
                 {"mass 1.9825 kg", "stiffness 5.4225 kPa", "damping 7.4525 N/m^2", "Table 1 of the paper beside box"});
}

} // namespace
} // namespace livermark::report
