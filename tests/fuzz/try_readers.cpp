// try_readers [--from FIRST] NUMBER PROGRAM [KIND...]: tries so many damaged inputs of each kind with its reader, and
// so many with the program, from the first number on, and prints a table in Markdown. Exit status 1 if one of them did
// not end as it should. After SIGINT or SIGTERM the table has what was tried until then.
//
// try_readers --write KIND NUMBER FOLDER: writes the input of a number.
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "core/support/processes/child_process.hpp"
#include "tests/fuzz/attempts.hpp"

namespace tests = livermark::tests;

namespace {

volatile std::sig_atomic_t is_to_end = 0;

/// Tries inputs until there are enough.
template <class Try> int try_all(std::uint64_t first, std::uint64_t most, tests::Attempts &all, const Try &try_one) {
    int num_tried = 0;
    for (std::uint64_t number = first; number < first + most; ++number) {
        const auto attempt = try_one(number);
        if (is_to_end != 0) // it may have ended by the same signal
            break;
        all.add(attempt);
        ++num_tried;
    }
    return num_tried;
}

} // namespace

int main(int argc, char **argv) {
    std::vector<std::string> words(argv + 1, argv + argc);
    std::uint64_t first = 0;
    if (words.size() > 2 && words[0] == "--from") {
        first = std::stoull(words[1]);
        words.erase(words.begin(), words.begin() + 2);
    }
    if (words.size() == 4 && words[0] == "--write") {
        std::filesystem::create_directories(words[3]);
        fmt::print("{}\n", tests::Readers(words[1], words[3]).write(std::stoull(words[2])).string());
        return 0;
    }
    if (words.size() < 2) {
        fmt::print(stderr,
                   "usage: try_readers [--from FIRST] NUMBER PROGRAM [KIND...], or --write KIND NUMBER FOLDER\n");
        return 2;
    }
    for (const int signal : {SIGINT, SIGTERM})
        std::signal(signal, [](int) { is_to_end = 1; });
    const auto num_by_reader = std::stoull(words[0]), num_by_program = std::stoull(words[1]);
    const auto kinds = words.size() > 2 ? std::vector(words.begin() + 2, words.end()) : tests::kinds_to_try();
    fmt::print("| kind | by its reader | by the program | read | refused | otherwise | longest [s] |\n"
               "| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    std::size_t num_faults = 0;
    for (const auto &kind : kinds) {
        const livermark::support::ScratchFolder scratch;
        const tests::Readers readers(kind, scratch.path);
        auto all = readers.try_seeds();
        const int num_seeds = all.num_tried;
        const int by_reader = num_seeds + try_all(first, num_by_reader, all,
                                                  [&](std::uint64_t number) { return readers.try_reader(number); });
        const int by_program =
            try_all(first, num_by_program, all, [&](std::uint64_t number) { return readers.try_program(number); });
        fmt::print("| {} | {} | {} | {} | {} | {} | {:.1f} |\n", kind, by_reader, by_program, all.num_read,
                   all.num_refused, all.faults.size(), all.longest);
        std::fflush(stdout);
        for (const auto &fault : all.faults)
            fmt::print(stderr, "{}\n", fault);
        num_faults += all.faults.size();
        if (is_to_end != 0)
            break;
    }
    return num_faults == 0 ? 0 : 1;
}
