#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// Who has built the program alone is told how to build what segmentations need.
TEST(SegmentProgram, IsNamedWithTheCommandThatBuildsItWhereItIsMissing) {
    const auto folder = fs::path(testing::TempDir()) / "livermark_without_segment";
    fs::remove_all(folder);
    fs::create_directories(folder);
    fs::copy_file(LIVERMARK_BINARY, folder / "livermark");
    const auto outcome =
        tests::run_command(fmt::format("cd {0} && ./livermark mesh --phantom -o phantom.nii.gz", folder.string()));
    EXPECT_EQ(outcome.status, 2) << outcome.output;
    EXPECT_NE(
        outcome.output.find("livermark-segment, which is not built here; build it with scripts/bootstrap --program "
                            "--segmentation"),
        std::string::npos)
        << outcome.output;
    EXPECT_FALSE(fs::exists(folder / "phantom.nii.gz"));
}

} // namespace
} // namespace livermark
