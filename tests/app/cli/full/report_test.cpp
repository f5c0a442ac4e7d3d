#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <memory>

#include "core/support/files.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/experiment.hpp"
#include "results/records/needle.hpp"
#include "studies/report/report_data.hpp"
#include "studies/run/run.hpp"
#include "tests/livermark_command.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_records.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::studies {
namespace {

void expect_parts(const std::string &page, const std::vector<std::string> &parts) {
    for (const auto &part : parts)
        EXPECT_NE(page.find(part), std::string::npos) << part;
}

std::string text_of(const std::filesystem::path &path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
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

results::Result with_body(results::Result result, const std::function<void(core::Body &)> &change) {
    auto body = *result.problem.body;
    change(body);
    result.problem.body = std::make_shared<core::Body>(body);
    return result;
}

class Report : public tests::ResultFolder {
  protected:
    /// The page of the files in the folder.
    std::string page() const {
        const auto outcome = tests::livermark("report " + directory_.string());
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        return text_of(directory_ / "report.html");
    }
    void write(const std::string &name, const results::Result &result) const {
        results::write_result(directory_ / name, result);
    }
};

/// Every section, from a file that has everything and one that has nothing for it.
TEST_F(Report, HasTheNumbersOfTheFiles) {
    auto result = tests::sample_result();
    result.models[1].comparison->relative_l2 = 0.123456;
    result.models[1].comparison->max_error = 0.0012344;
    result.reference_uncertainty->relative_l2 = 0.0301;
    write("result.h5", result);
    auto large = tests::along_a_path(tests::sample_result());
    large.problem.load_case.regime = core::Regime::large;
    write("large.h5", large);
    results::write_stability(directory_ / "stability.lloyd.h5", sample_stability());
    results::write_timings(directory_ / "timings.h5", tests::sample_timings());
    const auto text = page();
    expect_parts(text, {"<strong>12.35</strong>", "every model under every large load case", "pull_and_hang: z_max",
                        "± 3.01", "up to 1.234 mm", "pull_and_hang", "2.7850", "2.7830", "-0.07", "none", "2.8166",
                        "2.8112", "-0.19", "not observed", "step/newmark/fem_p1/box", "200000",
                        "livermark run --body box", "livermark report ", "0123abc-dirty"});
    EXPECT_NE(text.find("<td class=\"number\">50</td>"), std::string::npos) << "part of the machine's limit [%]";
    EXPECT_EQ(text.find("<section id=\"arena\">"), std::string::npos);
}

TEST_F(Report, SaysWhatIsMissingInItsPlaceAndNamesEmptyPartsAtTheEnd) {
    auto result = tests::without_motion(tests::sample_result());
    result.reference_uncertainty.reset();
    for (auto &model : result.models) {
        model.solution.springs.reset();
        model.solution.explicit_steps.reset();
    }
    write("result.h5", result);
    const auto text = page();
    expect_parts(text, {"own error is not known under pull_and_hang", "blown_up: diverged: a node left the room",
                        "unfinished: not_converged: 100 iterations were not enough", "What else a report can show",
                        "Livers of other people: <code>livermark cohort",
                        "Time steps, predicted and observed: <code>livermark stability"});
    for (const auto *part : {"cost", "poisson", "refinement", "steps", "timings", "arena", "large"})
        EXPECT_EQ(text.find(fmt::format("<section id=\"{}\">", part)), std::string::npos) << part;
}

/// Puts a dataset of 8 GB into a file of which nothing is written.
void add_empty_dataset(const std::filesystem::path &path) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    const hsize_t extent = hsize_t{1} << 30, chunk = 1024;
    const hid_t space = H5Screate_simple(1, &extent, nullptr), properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(properties, 1, &chunk);
    const hid_t dataset = H5Dcreate2(file, "/nothing", H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    ASSERT_GE(dataset, 0);
    H5Dclose(dataset);
    H5Pclose(properties);
    H5Sclose(space);
    H5Fclose(file);
}

/// One has damage where this program reads nothing and h5py looks when it opens a file; the other has what the reader
/// in Python alone refuses.
TEST_F(Report, IsMadeOfTheOtherFilesWhereOneIsRefused) {
    write("good.h5", tests::without_motion(tests::sample_result()));
    write("damaged.h5", tests::without_motion(tests::sample_result()));
    auto bytes = text_of(directory_ / "damaged.h5");
    const auto last_header = bytes.rfind("OHDR");
    ASSERT_NE(last_header, std::string::npos);
    bytes[last_header + 8] = static_cast<char>(bytes[last_header + 8] ^ 1);
    std::ofstream(directory_ / "damaged.h5", std::ios::binary) << bytes;
    write("empty.h5", tests::without_motion(tests::sample_result()));
    add_empty_dataset(directory_ / "empty.h5");
    const auto outcome = tests::livermark("report " + directory_.string());
    EXPECT_EQ(outcome.status, 1) << outcome.output;
    for (const auto *file : {"damaged.h5", "empty.h5"})
        EXPECT_NE(outcome.output.find("left out: " + (directory_ / file).string()), std::string::npos)
            << outcome.output;
    EXPECT_EQ(outcome.output.find("Traceback"), std::string::npos) << outcome.output;
    EXPECT_NE(text_of(directory_ / "report.html").find("good.h5"), std::string::npos);
    const auto table = tests::livermark("table " + directory_.string());
    tests::expect_outcome(table, 0, {"passed over: "});
}

TEST_F(Report, IsThereWithoutAnyRun) {
    results::write_timings(directory_ / "timings.h5", tests::sample_timings());
    const auto text = page();
    EXPECT_NE(text.find("What a step takes"), std::string::npos);
    EXPECT_EQ(text.find("<section id=\"errors\">"), std::string::npos);
    EXPECT_EQ(text.find("<img"), std::string::npos);
}

TEST_F(Report, SetsModelsBesideMeasurementsAndNeedles) {
    results::write_experiment(directory_ / "jelly.h5", tests::sample_experiment());
    results::write_needles(directory_ / "needle.biopsy.h5", tests::sample_needles());
    const auto data = read_report_data(directory_);
    EXPECT_EQ(data.files.experiments, std::vector<std::string>{"jelly.h5"});
    EXPECT_EQ(data.files.needles, std::vector<std::string>{"needle.biopsy.h5"});
    EXPECT_TRUE(data.files.others.empty());
    const auto text = page();
    expect_parts(text, {"A jelly under a spoon", "it is a jelly", "our kitchen", "Nearest to the markers is elements",
                        "noise of the measurement", "Error of the markers", "Let go: much", "4.00 ± 0.10 Hz",
                        "nearest over time is springs, +5.0 %", "Damping is fitted on much alone", "lost (diverged)",
                        "depth of the needle", "1 of experiments, 1 of needles"});
}

TEST_F(Report, ShowsErrorsOverPoissonRatiosAndMeshSizes) {
    for (const double ratio : {0.25, 0.45, 0.49})
        write(fmt::format("{}.h5", ratio),
              with_body(tests::without_motion(tests::sample_result()),
                        [&](core::Body &body) { body.materials[0].poisson_ratio = ratio; }));
    write("fine.h5", with_body(tests::sample_result(4), [](core::Body &body) { body.name = "box_2"; }));
    write("coarse.h5", with_body(tests::sample_result(2), [](core::Body &body) { body.name = "box_1"; }));
    const auto text = page();
    expect_parts(text, {"box_, pull_and_hang, nu 0.45", ">Poisson's ratio", "size of an element [mm]", "box, nu 0.25"});
}

TEST_F(Report, EscapesWhatFilesSay) {
    auto result = with_body(tests::sample_result(), [](core::Body &body) {
        body.name = "<script>alert(1)</script>";
        body.assumptions = {"a & b < c"};
    });
    result.problem.load_case.title = "\"><img src=x onerror='alert(2)'>";
    result.problem.load_case.name = "bad \xff\x01 bytes";
    result.provenance.command = "livermark run </code><script>";
    result.models[1].name = "<b>springs $x_1$";
    result.reference_uncertainty->refined = result.models[1].name;
    result.motion_uncertainty->refined = result.models[1].name;
    write("result.h5", result);
    const auto text = page();
    EXPECT_EQ(text.find("<script"), std::string::npos);
    EXPECT_EQ(text.find("<img src=x"), std::string::npos);
    EXPECT_EQ(text.find("<b>"), std::string::npos);
    expect_parts(text, {"&lt;script&gt;alert(1)&lt;/script&gt;", "a &amp; b &lt; c", "&lt;b&gt;springs $x_1$",
                        "bad \xef\xbf\xbd\xef\xbf\xbd bytes"});
}

/// A file may say that a solution is ok whatever is in it.
TEST_F(Report, DoesNotDrawWhatHasLeftTheRoom) {
    for (const double length : {std::nan(""), 1e200, 1e3}) {
        auto result = tests::sample_result();
        result.models[1].solution.displacement[0].x() = length;
        write("result.h5", result);
        const auto text = page();
        EXPECT_EQ(text.find("<img"), std::string::npos) << length;
        EXPECT_EQ(tests::count(text, "No model was compared with a reference here"), 1u);
        auto far = tests::sample_result();
        for (auto &displacement : far.models[0].solution.displacement)
            displacement.z() = length;
        write("result.h5", far);
        EXPECT_EQ(tests::count(page(), "The reference does not move, or has diverged"), 1u);
    }
    auto still = tests::sample_result();
    for (auto &displacement : still.models[0].solution.displacement)
        displacement.setZero();
    write("result.h5", still);
    EXPECT_EQ(tests::count(page(), "The reference does not move"), 1u);
}

TEST_F(Report, ReadsFilesByTheirKind) {
    results::write_result(path_, tests::sample_result());
    results::write_stability(directory_ / "stability.lloyd.h5", sample_stability());
    results::write_timings(directory_ / "timings.h5", tests::sample_timings());
    auto modes = tests::sample_result();
    modes.models.clear();
    modes.reference_uncertainty.reset();
    modes.motion_uncertainty.reset();
    results::write_result(directory_ / "modes.traction.h5", modes);
    EXPECT_EQ(results::kind_of_file(directory_ / "modes.traction.h5"), results::FileKind::modes);
    const auto data = read_report_data(directory_);
    ASSERT_EQ(data.results.size(), 1u);
    EXPECT_EQ(data.files.results, std::vector<std::string>{"result.h5"});
    EXPECT_EQ(data.files.stability, std::vector<std::string>{"stability.lloyd.h5"});
    EXPECT_EQ(data.files.others, std::vector<std::string>{"modes.traction.h5"});

    ASSERT_EQ(data.stability.size(), 1u);
    EXPECT_EQ(data.stability[0].spring_law, "lloyd");
    EXPECT_EQ(data.stability[0].damping.beta, 0.001);
    EXPECT_EQ(data.stability[0].limits[0].integrator, "heun");
    EXPECT_EQ(data.stability[0].limits[0].damped.observed, 0.002783);
    EXPECT_TRUE(std::isnan(data.stability[0].limits[1].damped.observed));

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

/// Whole files are worth a report; others stand in it, on standard error and in the exit status.
TEST_F(Report, SaysWhatItLeftOut) {
    results::write_result(path_, tests::sample_result());
    write("second.h5", tests::sample_result());
    std::filesystem::resize_file(directory_ / "second.h5", 5000);
    const auto outcome = tests::livermark("report " + directory_.string());
    tests::expect_outcome(outcome, 1, {"left out: " + (directory_ / "second.h5").string()});
    expect_parts(text_of(directory_ / "report.html"), {"1 of runs", "<dt>Left out</dt><dd>second.h5"});
}

TEST_F(Report, IsRefusedWithDamagedFilesAloneAndLeavesAnEarlierReport) {
    results::write_result(path_, tests::sample_result());
    const auto before = page();
    std::filesystem::resize_file(path_, 5000);
    const auto outcome = tests::livermark("report " + directory_.string());
    tests::expect_outcome(outcome, 2, {path_.string()});
    EXPECT_EQ(text_of(directory_ / "report.html"), before);
    EXPECT_EQ(files().size(), 2u) << "something was left behind";
}

/// A folder with a module of that name that cannot be imported stands in for a machine without it.
TEST_F(Report, SaysWhatToInstallWherePythonLacksALibrary) {
    std::filesystem::create_directories(directory_ / "runs");
    write("runs/result.h5", tests::sample_result());
    for (const std::string library : {"matplotlib", "jinja2", "h5py"}) {
        const auto module = directory_ / (library + ".py");
        std::ofstream(module) << "raise ModuleNotFoundError(\"No module named '" << library << "'\")\n";
        const auto outcome =
            tests::run_command(fmt::format("PYTHONDONTWRITEBYTECODE=1 PYTHONPATH={} {} report {}", directory_.string(),
                                           LIVERMARK_BINARY, (directory_ / "runs").string()));
        EXPECT_EQ(outcome.status, 2) << outcome.output;
        expect_parts(outcome.output, {fmt::format("No module named '{}'", library),
                                      "apt-get install python3-matplotlib python3-jinja2 python3-h5py"});
        EXPECT_EQ(tests::count(outcome.output, "\n"), 1u) << outcome.output;
        EXPECT_FALSE(std::filesystem::exists(directory_ / "runs" / "report.html"));
        std::filesystem::remove(module);
    }
}

/// Somebody may have put them into a folder of results that is handed on.
TEST_F(Report, NoModuleOfTheWorkingDirectoryIsRun) {
    write("result.h5", tests::sample_result());
    for (const std::string library : {"numpy", "json", "matplotlib", "h5py", "meshio", "livermark"})
        std::ofstream(directory_ / (library + ".py")) << "open('was_run', 'w').close()\n";
    std::ofstream(directory_ / "bar.vtk") << "# vtk DataFile Version 3.0\nbar\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                                             "POINTS 4 double\n0 0 0 0.1 0 0 0 0.1 0 0 0 0.1\n"
                                             "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n";
    for (const std::string words : {"report .", "mesh check beam --picture patches.png", "mesh check bar.vtk"})
        for (const std::string path : {"", ":", ".:"}) {
            const auto outcome = tests::run_command(
                fmt::format("cd {}; PYTHONPATH={} {} {}", directory_.string(), path, LIVERMARK_BINARY, words));
            EXPECT_EQ(outcome.status, 0) << words << ": " << outcome.output;
            EXPECT_FALSE(std::filesystem::exists(directory_ / "was_run")) << words << " with '" << path << "'";
        }
    EXPECT_TRUE(std::filesystem::exists(directory_ / "report.html"));
}

/// Conda and others set it for their own interpreter, and that of the distribution does not start with it.
TEST_F(Report, IsMadeWherePythonHomeIsThatOfAnotherInterpreter) {
    write("result.h5", tests::sample_result());
    const auto outcome =
        tests::run_command(fmt::format("PYTHONHOME=/nowhere {} report {}", LIVERMARK_BINARY, directory_.string()));
    EXPECT_EQ(outcome.status, 0) << outcome.output;
}

/// ParaView and others set it for their own interpreter, of which no other can load what is compiled.
TEST_F(Report, SaysWhatToUnsetWherePythonPathIsThatOfAnotherInterpreter) {
    std::filesystem::create_directories(directory_ / "runs");
    write("runs/result.h5", tests::sample_result());
    std::filesystem::create_directories(directory_ / "other" / "numpy");
    std::ofstream(directory_ / "other" / "numpy" / "__init__.py") << "raise ImportError('built for another Python')\n";
    std::ofstream(directory_ / "bar.inp") << "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n4, 0, 0, 1\n"
                                             "*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n";
    for (const std::string words : {"report runs", "mesh check bar.inp"}) {
        const auto outcome = tests::run_command(
            fmt::format("cd {0}; PYTHONPATH={0}/other {1} {2}", directory_.string(), LIVERMARK_BINARY, words));
        EXPECT_EQ(outcome.status, 2) << outcome.output;
        expect_parts(outcome.output, {"built for another Python", "unset PYTHONPATH"});
        EXPECT_EQ(tests::count(outcome.output, "\n"), 1u) << outcome.output;
    }
}

TEST_F(Report, PatchesOfABodyAreDrawnInTheirColours) {
    const auto picture = directory_ / "patches.png";
    const auto outcome = tests::livermark("mesh check beam --picture " + picture.string());
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    expect_parts(outcome.output,
                 {"from the front, from behind, from above and from below", "#77aadd  x_max", "#bbcc33  z_min"});
    EXPECT_TRUE(text_of(picture).starts_with("\x89PNG"));
}

TEST_F(Report, VesselsOfABodyAreDrawnWithItsPatches) {
    const auto picture = directory_ / "patches.png";
    const auto body = support::root_folder() / "examples/bodies/liver_with_vessels.toml";
    const auto outcome = tests::livermark("mesh check " + body.string() + " --picture " + picture.string());
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    expect_parts(outcome.output, {"  anterior\n", "#2878f5  vessels"});
}

} // namespace
} // namespace livermark::studies
