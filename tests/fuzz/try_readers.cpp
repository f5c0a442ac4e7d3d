// try_readers NUMBER PROGRAM [KIND...]: tries so many damaged inputs of each kind with its reader, and so many with the
// program, and prints a table in Markdown. Exit status 1 if one of them did not end as it should.
//
// try_readers --write KIND NUMBER FOLDER: writes the input of a number.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "support/child_process.hpp"
#include "tests/fuzz/attempts.hpp"

namespace tests = livermark::tests;

int main(int argc, char **argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    if (words.size() == 4 && words[0] == "--write") {
        std::filesystem::create_directories(words[3]);
        fmt::print("{}\n", tests::Readers(words[1], words[3]).write(std::stoull(words[2])).string());
        return 0;
    }
    if (words.size() < 2) {
        fmt::print(stderr, "usage: try_readers NUMBER PROGRAM [KIND...], or --write KIND NUMBER FOLDER\n");
        return 2;
    }
    const auto num_by_reader = std::stoull(words[0]), num_by_program = std::stoull(words[1]);
    const auto kinds = words.size() > 2 ? std::vector(words.begin() + 2, words.end()) : tests::kinds_to_try();
    fmt::print("| kind | by its reader | by the program | read | refused | otherwise | longest [s] |\n"
               "| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    std::size_t num_faults = 0;
    for (const auto &kind : kinds) {
        const livermark::support::ScratchFolder scratch;
        const tests::Readers readers(kind, scratch.path);
        auto all = readers.try_seeds();
        const auto num_seeds = static_cast<std::uint64_t>(all.num_tried);
        for (std::uint64_t number = 0; number < num_by_reader; ++number)
            all.add(readers.try_reader(number));
        for (std::uint64_t number = 0; number < num_by_program; ++number)
            all.add(readers.try_program(number));
        fmt::print("| {} | {} | {} | {} | {} | {} | {:.1f} |\n", kind, num_seeds + num_by_reader, num_by_program,
                   all.num_read, all.num_refused, all.faults.size(), all.longest);
        std::fflush(stdout);
        for (const auto &fault : all.faults)
            fmt::print(stderr, "{}\n", fault);
        num_faults += all.faults.size();
    }
    return num_faults == 0 ? 0 : 1;
}
