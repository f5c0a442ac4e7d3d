#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <thread>

#include "tests/child.hpp"
#include "tests/result_folder.hpp"

namespace livermark::segmentation {
namespace {

namespace fs = std::filesystem;

class EndedProgram : public tests::ResultFolder {};

/// Whether the program that makes bodies works on a file.
bool is_segmenting(const std::string &file) {
    std::error_code error;
    return std::ranges::any_of(fs::directory_iterator("/proc", error), [&](const fs::directory_entry &process) {
        std::ifstream stream(process.path() / "cmdline");
        std::string words;
        std::getline(stream, words); // of a process that ends meanwhile, an iterator of the buffer would throw
        return words.find("livermark-segment") != std::string::npos && words.find(file) != std::string::npos;
    });
}

/// As by `kill`, a time limit or a shell that is closed, of which only the program that was started hears.
TEST_F(EndedProgram, EndsTheOneThatItHasStarted) {
    const auto image = (directory_ / "phantom.nii.gz").string();
    const auto made =
        tests::run_child({LIVERMARK_BINARY, "mesh", "--phantom", "--spacing", "0.004", "0.004", "0.004", "-o", image},
                         {.folder = directory_});
    ASSERT_EQ(made.status, 0) << made.errors;
    for (const int signal : {SIGTERM, SIGHUP, SIGKILL}) {
        SCOPED_TRACE(signal);
        const auto end = tests::run_child(
            {LIVERMARK_BINARY, "mesh", "--labels", image, "--tetrahedra", "200000", "-o", "body.msh"},
            {.folder = directory_, .killed_when = [&] { return is_segmenting(image); }, .kill_signal = signal});
        EXPECT_EQ(end.signal, signal) << end.errors;
        const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (is_segmenting(image) && std::chrono::steady_clock::now() < limit)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        EXPECT_FALSE(is_segmenting(image));
        EXPECT_FALSE(fs::exists(directory_ / "body.msh"));
    }
}

} // namespace
} // namespace livermark::segmentation
