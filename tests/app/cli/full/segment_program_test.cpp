#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <utility>

#include "tests/livermark_command.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

void write_script(const fs::path &file, const std::string &text) {
    std::ofstream(file) << "#!/bin/sh\n" << text;
    fs::permissions(file, fs::perms::owner_all);
}

/// A build folder of a source tree, and a program `cmake` that stands for the true one.
/// @param cmake  what it does; `$2` is the build folder where it builds
fs::path build_folder(const std::string &name, const std::string &rules, const std::string &cmake) {
    const auto folder = fs::path(testing::TempDir()) / name;
    fs::remove_all(folder);
    fs::create_directories(folder / "tree" / "scripts");
    fs::create_directories(folder / "bin");
    fs::copy_file(LIVERMARK_BINARY, folder / "livermark");
    std::ofstream(folder / "tree" / "scripts" / "bootstrap") << "";
    std::ofstream(folder / "CMakeCache.txt") << "CMAKE_HOME_DIRECTORY:INTERNAL=" << (folder / "tree").string() << "\n";
    std::ofstream(folder / "build.ninja") << rules;
    write_script(folder / "bin" / "cmake", "echo \"cmake $*\"\n" + cmake);
    return folder;
}

tests::Outcome phantom_in(const fs::path &folder) {
    return tests::run_command(
        fmt::format("cd {0} && PATH={0}/bin:$PATH ./livermark mesh --phantom -o phantom.nii.gz", folder.string()));
}

TEST(SegmentProgram, IsBuiltWhereItIsMissingInABuildFolder) {
    const auto folder = build_folder("livermark_builds_segment", "build livermark-segment: link\n",
                                     "printf '#!/bin/sh\\necho \"$3\" is made\\n' > $2/livermark-segment\n"
                                     "chmod +x $2/livermark-segment\n");
    const auto outcome = phantom_in(folder);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_NE(outcome.output.find("which is compiled now"), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.output.find("cmake --build " + folder.string() + " --target livermark-segment"),
              std::string::npos)
        << outcome.output;
    EXPECT_NE(outcome.output.find("phantom is made"), std::string::npos) << outcome.output;
    EXPECT_EQ(phantom_in(folder).output.find("cmake"), std::string::npos) << "it is built once";
}

TEST(SegmentProgram, ThatCannotBeBuiltIsNamedWithTheCommandThatInstallsToo) {
    for (const auto &[rules, why] : {std::pair{"", "needs ITK and CGAL, and they are not installed"},
                                     {"build livermark-segment: link\n", "could not be compiled"}}) {
        const auto outcome = phantom_in(build_folder("livermark_cannot_build_segment", rules, "exit 0\n"));
        EXPECT_EQ(outcome.status, 2) << outcome.output;
        EXPECT_NE(outcome.output.find(why), std::string::npos) << outcome.output;
        EXPECT_NE(outcome.output.find("scripts/bootstrap --program --segmentation"), std::string::npos)
            << outcome.output;
    }
}

/// Who has copied the program alone is told how to build what segmentations need.
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
