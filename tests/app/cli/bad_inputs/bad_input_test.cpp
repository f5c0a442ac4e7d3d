#include <cctype>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <sstream>

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
    auto folder = fs::path(testing::TempDir()) / "livermark_bad_input" /
                  std::to_string(std::hash<std::string>()(test->name())); // names of tests are long
    fs::remove_all(folder);
    fs::create_directories(folder);
    return folder;
}

/// Messages on the page, by their input.
const std::map<std::string, std::string> &documented_messages() {
    static const auto all = [] {
        std::map<std::string, std::string> messages;
        std::istringstream text(support::read_text(LIVERMARK_SOURCE_DIR "/docs/studies/bad_input.md"));
        for (std::string line; std::getline(text, line);)
            if (const auto middle = line.find(" | "); line.starts_with("| ") && middle != std::string::npos)
                messages[line.substr(2, middle - 2)] = line.substr(middle + 3, line.size() - middle - 5);
        for (const auto *heading : {"---", "input"})
            messages.erase(heading);
        return messages;
    }();
    return all;
}

std::vector<BadInput> rows_to_try() {
    std::vector<BadInput> rows;
    for (const auto &group : all_bad_inputs())
        if (LIVERMARK_SEGMENTATION || !group.title.starts_with("Label images"))
            rows.insert(rows.end(), group.rows.begin(), group.rows.end());
    return rows;
}

/// "RandomBytesAsAMesh" for "random bytes as a mesh".
std::string name_of(const testing::TestParamInfo<BadInput> &info) {
    std::string name;
    bool begins_word = true;
    for (const char c : info.param.what) {
        const bool is_part = std::isalnum(static_cast<unsigned char>(c)) != 0;
        if (is_part)
            name += begins_word ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
        begins_word = !is_part;
    }
    return name;
}

class BadInputs : public testing::TestWithParam<BadInput> {};
INSTANTIATE_TEST_SUITE_P(Rows, BadInputs, testing::ValuesIn(rows_to_try()), name_of);

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
    ASSERT_TRUE(documented_messages().contains(row.what)) << "write the page again: scripts/golden";
    EXPECT_EQ(as_documented(lines[0], folder), documented_messages().at(row.what))
        << "if this is right, write the page again: scripts/golden";
    EXPECT_EQ(files_below(folder), before) << "something was left behind";
    EXPECT_EQ(end.output, "");
}

/// Otherwise a row could be refused for another reason than its own.
TEST(GoodInput, ThatTheRowsStartFromIsAccepted) {
    for (const auto &[arguments, load_case] : {std::pair{"mesh check two.msh", good_case},
                                               {"export bar.toml case.toml -o out", good_case},
                                               {"export bar.toml case.toml -o out", good_release},
                                               {"report runs -o page.html", good_case},
                                               {"table result.h5", good_case}}) {
        BadInput row{{}, arguments, {{"two.msh", good_msh}, {"case.toml", load_case}}};
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

TEST(BadInputTable, HasEachInputOnceAndNoOther) {
    std::set<std::string> inputs;
    for (const auto &group : all_bad_inputs())
        for (const auto &row : group.rows)
            EXPECT_TRUE(inputs.insert(row.what).second) << row.what << " is there twice";
    std::set<std::string> documented;
    for (const auto &[input, message] : documented_messages())
        documented.insert(input);
    EXPECT_EQ(documented, inputs);
}

} // namespace
} // namespace livermark::tests
