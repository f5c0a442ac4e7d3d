#include "support/processes/python_program.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "support/input_error.hpp"
#include "support/processes/child_process.hpp"
#include "support/root_folder.hpp"

namespace livermark::support {

namespace {

/// Of the source tree; or of an installed package, whose folder livermark/data is the root then.
std::filesystem::path package_folder() {
    const auto in_tree = root_folder() / "python";
    return std::filesystem::exists(in_tree / "livermark") ? in_tree : root_folder() / ".." / "..";
}

/// The variable that makes the package found, before the absolute places that it held.
std::string search_path() {
    auto path = fmt::format("PYTHONPATH={}", std::filesystem::absolute(package_folder()).string());
    const char *others = std::getenv("PYTHONPATH"); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    std::istringstream places(others ? others : "");
    for (std::string place; std::getline(places, place, ':');)
        if (place.starts_with('/'))
            path += ":" + place;
    return path;
}

/// Whether there is no such interpreter, or one that lacks a library.
bool is_lacking(const FilterOutcome &outcome, const std::string &last) {
    constexpr int no_such_program = 127; // what env says
    return outcome.status == no_such_program || last.starts_with("ModuleNotFoundError: ") ||
           last.starts_with("ImportError: ") ||
           std::ranges::any_of(outcome.lines, [](const auto &line) { return line.starts_with("Unknown option: -P"); });
}

} // namespace

std::string remedy_for_modules(const std::vector<std::string> &lines) {
    const char *places = std::getenv("PYTHONPATH"); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    if (!places || *places == '\0' || lines.empty())
        return "";
    const bool is_foreign = lines.back().starts_with("ImportError: "); // what is missing has another name, and remedy
    const bool cannot_start =
        lines.front().starts_with("Python path configuration") || lines.front().starts_with("Fatal Python error");
    return is_foreign || cannot_start ? "unset PYTHONPATH, which may name modules of another Python" : "";
}

std::vector<std::string> start_of_python(const std::string &interpreter) {
    return {"env", "-u", "PYTHONHOME", "-u", "PYTHONINSPECT", "-u", "PYTHONSTARTUP", search_path(), interpreter, "-P"};
}

std::string run_python(const std::string &part, const std::vector<std::string> &arguments, std::string_view input,
                       const std::string &purpose, const std::string &packages) {
    std::string lacking, remedy;
    for (const auto *const interpreter : {"/usr/bin/python3", "python3"}) {
        auto words = start_of_python(interpreter);
        words.insert(words.end(), {"-m", "livermark." + part});
        words.insert(words.end(), arguments.begin(), arguments.end());
        auto outcome = run_filter(words, input);
        const auto last = outcome.lines.empty() ? "no reason given" : outcome.lines.back();
        if (outcome.status == 0)
            return std::move(outcome.output);
        if (outcome.status == 2 && !is_lacking(outcome, last))
            throw InputError(last);
        if (remedy.empty())
            remedy = remedy_for_modules(outcome.lines);
        if (!is_lacking(outcome, last) && !remedy.empty())
            break;
        if (!is_lacking(outcome, last))
            throw std::runtime_error(fmt::format("livermark.{} failed: {}", part, fmt::join(outcome.lines, "\n")));
        if (lacking.empty())
            lacking = last.find(": ") == std::string::npos ? last : last.substr(last.find(": ") + 2);
    }
    throw InputError(fmt::format("{} needs libraries of Python ({}); {}", purpose,
                                 lacking.empty() ? "it does not start" : lacking,
                                 remedy.empty() ? "apt-get install " + packages : remedy));
}

} // namespace livermark::support
