#include "tests/fuzz/attempts.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#include "core/support/input_error.hpp"
#include "meshes/segmentation/images/segmentation.hpp"
#include "meshes/segmentation/surfaces/surface_file.hpp"
#include "results/hdf5/result_file.hpp"
#include "tests/child.hpp"
#include "tests/fuzz/mutations.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::tests {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Time of one input, by the clock: readers of small files are ended after 45 s, and the machine may be busy.
constexpr unsigned most_seconds = 120;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string bytes_of(const fs::path &file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void read_input(const std::string &kind, const fs::path &input) {
    std::vector<std::string> remarks;
    if (kind == "hdf5") {
        results::kind_of_file(input);
        results::read_result(input);
    } else if (kind == "stl" || kind == "ply" || kind == "obj_off") {
        segmentation::read_surface(input, remarks);
    } else {
        segmentation::read_label_image(input);
    }
}

/// A fault of a refusal; empty if it is a sentence.
std::string fault_of_sentence(const std::string &sentence, const std::string &file) {
    if (sentence.find('\n') != std::string::npos)
        return "has several lines";
    if (sentence.size() > 500)
        return "is long";
    if (sentence.find(file) == std::string::npos)
        return "does not name the file";
    if (std::ranges::any_of(sentence, [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
        return "holds characters that cannot be printed";
    return sentence.find("itk::") != std::string::npos || sentence.find("std::") != std::string::npos
               ? "is in words for programmers"
               : "";
}

std::set<std::string> names_in(const fs::path &folder) {
    std::set<std::string> names;
    for (const auto &entry : fs::recursive_directory_iterator(folder))
        names.insert(fs::relative(entry.path(), folder));
    return names;
}

constexpr int is_read = 0, is_refused = 2, is_no_sentence = 3, has_thrown = 4;

/// In a process of its own.
[[noreturn]] void read_and_exit(const std::string &kind, const fs::path &input, int out) {
    alarm(most_seconds);
    const auto tell = [&](const std::string &text) { return write(out, text.data(), text.size()) >= 0; };
    int ending = is_read;
    try {
        read_input(kind, input);
    } catch (const support::InputError &error) {
        const auto fault = fault_of_sentence(error.what(), input.filename().string());
        ending = fault.empty() ? is_refused : is_no_sentence;
        tell(fault.empty() ? error.what() : fmt::format("the refusal {}: {}", fault, error.what()));
    } catch (const std::exception &error) {
        ending = has_thrown;
        tell(error.what());
    }
    _exit(ending);
}

} // namespace

std::vector<std::string> kinds_to_try() {
    auto kinds = fuzz::kinds_of_seeds();
    kinds.emplace_back("hdf5");
    return kinds;
}

void Attempts::add(const Attempts &more) {
    num_tried += more.num_tried;
    num_read += more.num_read;
    num_refused += more.num_refused;
    longest = std::max(longest, more.longest);
    faults.insert(faults.end(), more.faults.begin(), more.faults.end());
}

Readers::Readers(const std::string &kind, fs::path folder) : kind_(kind), folder_(std::move(folder)) {
    if (kind != "hdf5") {
        seeds_ = fuzz::seeds_of(kind);
        blocks_.resize(seeds_.size());
        return;
    }
    const auto file = folder_ / "seed.h5";
    for (const auto &result : {without_motion(sample_result()), along_a_path(sample_result())}) {
        results::write_result(file, result);
        seeds_.push_back({"result.h5", bytes_of(file)});
        blocks_.push_back(fuzz::checksummed_blocks(seeds_.back().bytes));
    }
    fs::remove(file);
}

fs::path Readers::write(const fuzz::SeedFile &seed, std::string bytes) const {
    if (seed.is_gzipped)
        bytes = fuzz::gzipped(bytes);
    for (const auto &entry : fs::directory_iterator(folder_))
        fs::remove_all(entry);
    const auto place = seed.is_folder ? folder_ / "series" : folder_;
    fs::create_directories(place);
    for (const auto &[name, others] : seed.beside)
        std::ofstream(place / name, std::ios::binary) << others;
    std::ofstream(place / seed.name, std::ios::binary) << bytes;
    return seed.is_folder ? place : place / seed.name;
}

fs::path Readers::write(std::uint64_t number) const {
    const auto s = static_cast<std::size_t>(number % seeds_.size());
    return write(seeds_[s], fuzz::damaged(kind_, seeds_[s].bytes, number, blocks_[s]));
}

Attempts Readers::read_apart(const fs::path &input, const std::string &name) const {
    const auto before = names_in(folder_);
    std::array<int, 2> ends{};
    Attempts attempt{.num_tried = 1};
    if (pipe(ends.data()) != 0)
        throw std::runtime_error("no pipe to a reader");
    const auto start = Clock::now();
    const pid_t child = fork();
    if (child == 0)
        read_and_exit(kind_, input, ends[1]);
    close(ends[1]);
    std::string text(2000, '\0');
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(::read(ends[0], text.data(), text.size()), 0)));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    attempt.longest = seconds_since(start);
    if (WIFSIGNALED(status))
        attempt.faults.push_back(fmt::format("{}: {}", name, strsignal(WTERMSIG(status))));
    else if (WEXITSTATUS(status) == is_read)
        attempt.num_read = 1;
    else if (WEXITSTATUS(status) == is_refused)
        attempt.num_refused = 1;
    else
        attempt.faults.push_back(fmt::format("{}: {}", name, text));
    if (names_in(folder_) != before)
        attempt.faults.push_back(fmt::format("{}: something is left behind", name));
    return attempt;
}

Attempts Readers::try_seeds() const {
    Attempts all;
    for (const auto &seed : seeds_) {
        auto attempt = read_apart(write(seed, seed.bytes), "the seed");
        if (attempt.num_read != 1)
            attempt.faults.push_back(fmt::format("{}: the seed is refused", seed.name));
        all.add(attempt);
    }
    return all;
}

Attempts Readers::try_reader(std::uint64_t number) const {
    return read_apart(write(number), fmt::format("{} {}", kind_, number));
}

Attempts Readers::try_program(std::uint64_t number) const {
    const auto input = write(number).string();
    const bool makes_mesh = kind_ != "hdf5" && number % 8 == 0;
    const bool is_surface = kind_ == "stl" || kind_ == "ply" || kind_ == "obj_off";
    std::vector<std::string> words{LIVERMARK_BINARY};
    if (kind_ == "hdf5")
        words.insert(words.end(), {"table", input});
    else if (makes_mesh)
        words.insert(words.end(), {"mesh", is_surface ? "--surfaces" : "--labels", input, "--tetrahedra", "2000", "-o",
                                   (folder_ / "out.msh").string()});
    else
        words.insert(words.end(), {"mesh", "check", input});
    auto expected = names_in(folder_);
    const auto start = Clock::now();
    const auto end = run_child(words, {.killed_when = [=] { return seconds_since(start) > most_seconds; }});
    Attempts attempt{.num_tried = 1, .longest = seconds_since(start)};
    const auto fault = [&](const std::string &what) {
        attempt.faults.push_back(
            fmt::format("{} {}, by the program: {}: {}", kind_, number, what, end.errors.substr(0, 500)));
    };
    if (end.signal != 0)
        fault(strsignal(end.signal));
    else if (end.status == 0)
        attempt.num_read = 1;
    else if (end.status == 2)
        attempt.num_refused = 1;
    else
        fault(fmt::format("exit status {}", end.status));
    if (end.status == 2 && std::ranges::count(end.errors, '\n') != 1)
        fault("more than a sentence");
    if (end.status == 0 && makes_mesh)
        expected.insert({"out.msh", "out.toml"});
    if (names_in(folder_) != expected)
        fault("other files are there than should be");
    return attempt;
}

} // namespace livermark::tests
