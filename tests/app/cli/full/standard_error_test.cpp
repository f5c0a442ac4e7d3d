#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>

#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// A bar that is pulled, in a folder, and the command that runs it there.
std::string run_of_a_bar(const fs::path &folder) {
    std::ofstream(folder / "pull.toml")
        << "title = \"pull\"\ntarget_peak_displacement = 0.001\n[[condition]]\npatch = \"x_min\"\n"
           "displacement = [0.0, 0.0, 0.0]\n[[condition]]\npatch = \"x_max\"\ntraction = [10.0, 0.0, 0.0]\n";
    const auto place = folder.string();
    return LIVERMARK_BINARY " run --body " + place + "/bar.toml --load-case " + place +
           "/pull.toml --model lloyd --static --reference-on-mesh --jobs 1 --output " + place + "/runs";
}

/// A disk that is full, a stream that is closed, a reader that has gone: progress goes nowhere, and the run does not
/// mind.
TEST(StandardError, ThatCannotBeWrittenDoesNotEndARun) {
    const auto folder = tests::folder_with_bar("standard_error");
    const auto command = run_of_a_bar(folder);
    const auto status = (folder / "status").string();
    for (const auto &whole : {command + " 2>/dev/full; echo $? >" + status, command + " 2>&-; echo $? >" + status,
                              "( " + command + " 2>&1 >/dev/null; echo $? >" + status + " ) | true"}) {
        SCOPED_TRACE(whole);
        fs::remove_all(folder / "runs");
        fs::remove(status);
        tests::run_command("( " + whole + " )");
        std::ifstream stream(status);
        EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), "0\n");
        EXPECT_TRUE(fs::exists(folder / "runs" / "bar" / "pull.h5"));
    }
}

} // namespace
} // namespace livermark
