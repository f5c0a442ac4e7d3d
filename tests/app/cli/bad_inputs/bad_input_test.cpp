#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <set>

#include "core/support/files.hpp"
#include "results/hdf5/result_file.hpp"

#include "tests/app/cli/bad_inputs/bad_inputs.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::tests {

void PrintTo(const BadInput &row, std::ostream *out) {
    *out << row.what;
}

namespace {

namespace fs = std::filesystem;

fs::path scratch_folder() {
    const auto *test = testing::UnitTest::GetInstance()->current_test_info();
    auto name = std::string(test->test_suite_name()) + "_" + test->name();
    std::ranges::replace(name, '/', '_');
    auto folder = fs::path(testing::TempDir()) / "livermark_bad_input" / name;
    fs::remove_all(folder);
    fs::create_directories(folder);
    return folder;
}

void expect_part(const std::string &text, const std::string &part) {
    EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is missing in: " << text;
}

/// What docs/studies/bad_input.md says of each input.
std::map<std::string, std::string> documented_messages() {
    std::map<std::string, std::string> messages;
    std::istringstream text(support::read_text(LIVERMARK_SOURCE_DIR "/docs/studies/bad_input.md"));
    for (std::string line; std::getline(text, line);)
        if (const auto middle = line.find(" | "); line.starts_with("| ") && middle != std::string::npos)
            messages[line.substr(2, middle - 2)] = line.substr(middle + 3, line.size() - middle - 5);
    return messages;
}

class BadInputs : public testing::TestWithParam<BadInput> {};

TEST_P(BadInputs, EndInOneSentenceAndLeaveNothing) {
    const auto &row = GetParam();
    const auto folder = scratch_folder();
    const auto before = prepare_bad_input(row, folder);
    const auto end = try_bad_input(row, folder);
    if (!end.was_started && row.how.without_rights)
        GTEST_SKIP() << "nobody may not start " LIVERMARK_BINARY ", so root cannot try what nobody may do";
    EXPECT_EQ(end.signal, 0) << "livermark crashed";
    EXPECT_EQ(end.status, 2) << end.output << end.errors;
    const auto lines = message_lines(end.errors);
    ASSERT_EQ(lines.size(), 1u) << end.errors;
    EXPECT_TRUE(lines[0].starts_with("livermark: ")) << lines[0];
    EXPECT_LT(lines[0].size(), 500u) << lines[0];
    for (const auto &part : {row.file, row.place, row.remedy})
        expect_part(lines[0], part);
    EXPECT_FALSE(row.remedy.empty());
    EXPECT_EQ(as_documented(lines[0], folder), documented_messages()[row.what])
        << "write the table again: build/release/tests/bad_input_table > docs/studies/bad_input.md";
    EXPECT_EQ(files_below(folder), before) << "something was left behind";
    EXPECT_EQ(end.output, "");
}

const auto name_of = [](const auto &info) { return info.param.name; };
INSTANTIATE_TEST_SUITE_P(Meshes, BadInputs, testing::ValuesIn(bad_meshes()), name_of);
INSTANTIATE_TEST_SUITE_P(Bodies, BadInputs, testing::ValuesIn(bad_bodies()), name_of);
INSTANTIATE_TEST_SUITE_P(LoadCases, BadInputs, testing::ValuesIn(bad_load_cases()), name_of);
INSTANTIATE_TEST_SUITE_P(Releases, BadInputs, testing::ValuesIn(bad_releases()), name_of);
INSTANTIATE_TEST_SUITE_P(Cuts, BadInputs, testing::ValuesIn(bad_cuts()), name_of);
INSTANTIATE_TEST_SUITE_P(Blades, BadInputs, testing::ValuesIn(bad_blades()), name_of);
INSTANTIATE_TEST_SUITE_P(Histories, BadInputs, testing::ValuesIn(bad_histories()), name_of);
INSTANTIATE_TEST_SUITE_P(Touches, BadInputs, testing::ValuesIn(bad_touches()), name_of);
INSTANTIATE_TEST_SUITE_P(Hdf5Files, BadInputs, testing::ValuesIn(bad_hdf5_files()), name_of);
INSTANTIATE_TEST_SUITE_P(Solutions, BadInputs, testing::ValuesIn(bad_solutions()), name_of);
INSTANTIATE_TEST_SUITE_P(Images, BadInputs,
                         testing::ValuesIn(LIVERMARK_SEGMENTATION ? bad_images() : std::vector<BadInput>()), name_of);
INSTANTIATE_TEST_SUITE_P(CommandLines, BadInputs, testing::ValuesIn(bad_command_lines()), name_of);
INSTANTIATE_TEST_SUITE_P(Places, BadInputs, testing::ValuesIn(bad_places()), name_of);

/// Otherwise a row could be refused for another reason than its own.
TEST(GoodInput, ThatTheRowsStartFromIsAccepted) {
    for (const auto &[arguments, load_case] : {std::pair{"mesh check two.msh", good_case},
                                               {"export bar.toml case.toml -o out", good_case},
                                               {"export bar.toml case.toml -o out", good_release},
                                               {"report runs -o page.html", good_case},
                                               {"table result.h5", good_case}}) {
        BadInput row{.name = {}, .what = {}, .arguments = arguments, .file = {}, .place = {}, .remedy = {}};
        row.files = {{"two.msh", good_msh}, {"case.toml", load_case}};
        row.prepare = [](const fs::path &folder) {
            write_bar(folder);
            results::write_result(folder / "result.h5", sample_result());
            fs::create_directory(folder / "runs");
            results::write_result(folder / "runs" / "result.h5", sample_result());
        };
        const auto folder = scratch_folder();
        prepare_bad_input(row, folder);
        const auto end = try_bad_input(row, folder);
        EXPECT_EQ(end.status, 0) << arguments << "\n" << end.errors;
    }
}

/// docs/studies/bad_input.md says with which command it is made; what stays of each message is checked here.
TEST(BadInputTable, StandsInTheDocumentation) {
    std::map<std::string, std::string> documented;
    std::size_t num_rows = 0;
    std::istringstream text(support::read_text(LIVERMARK_SOURCE_DIR "/docs/studies/bad_input.md"));
    for (std::string line; std::getline(text, line);)
        if (line.starts_with("| ") && !line.starts_with("| ---") && !line.starts_with("| input |")) {
            documented[line.substr(2, line.find(" | ") - 2)] = line;
            ++num_rows;
        }
    std::set<std::string> inputs;
    for (const auto &group : all_bad_inputs())
        for (const auto &row : group.rows) {
            EXPECT_TRUE(inputs.insert(row.what).second) << row.what << " is there twice";
            const auto found = documented.find(row.what);
            ASSERT_NE(found, documented.end()) << row.what;
            for (const auto &part : {row.file, row.place, row.remedy})
                expect_part(found->second, part);
        }
    EXPECT_EQ(num_rows, inputs.size());
}

} // namespace
} // namespace livermark::tests
