#include "studies/study.hpp"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <functional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::studies {

namespace {

/// The command that takes a load case which ships, and is of another kind than those of a folder; empty if none is.
std::string other_command(const std::string &name, std::string_view folder) {
    struct Kind {
        std::string_view folder, what, command;
    };
    std::vector<Kind> kinds{{load_cases_folder, "has neither a moving tool nor a needle", load_cases::run_command}};
    for (const auto &event : load_cases::all_events())
        if (event.folder)
            kinds.push_back({event.folder, event.what, event.command});
    for (const auto &kind : kinds) {
        const auto path = support::root_folder() / kind.folder;
        std::error_code nobody_cares; // a tree of somebody's own has fewer
        if (kind.folder != folder && std::filesystem::exists(path / (name + ".toml"), nobody_cares))
            return fmt::format("load case {} {}; give it to 'livermark {} --load-case {}'", name, kind.what,
                               kind.command, name);
    }
    return {};
}

} // namespace

std::vector<std::filesystem::path> find_toml_files(const std::vector<std::string> &wanted, const char *folder,
                                                   const char *word) {
    const auto path = support::root_folder() / folder;
    const auto known = support::list_toml(path);
    if (known.empty() && wanted.empty())
        throw support::InputError(
            fmt::format("{}: there is no {} here; set LIVERMARK_ROOT to a Livermark source tree", path.string(), word));
    const auto touching_path = support::root_folder() / touching_load_cases_folder;
    const bool may_touch = folder == std::string_view(load_cases_folder) && std::filesystem::exists(touching_path);
    const auto touching = may_touch ? support::list_toml(touching_path) : std::vector<std::string>{};
    std::vector<std::filesystem::path> files;
    for (const auto &name : wanted.empty() ? known : wanted) {
        std::filesystem::path file = name;
        if (std::ranges::find(known, name) != known.end())
            file = path / (name + ".toml");
        else if (std::ranges::find(touching, name) != touching.end())
            file = touching_path / (name + ".toml");
        else if (support::file_ending(file) != ".toml" &&
                 !(folder == std::string_view(bodies_folder) && file.has_extension())) {
            const auto elsewhere = folder == std::string_view(bodies_folder) ? "" : other_command(name, folder);
            throw support::InputError(elsewhere.empty() ? support::unknown_name(word, name, known) : elsewhere);
        }
        if (std::ranges::find(files, file) != files.end())
            throw support::InputError(fmt::format("{} '{}' is asked for twice; name it once", word, name));
        files.push_back(file);
    }
    return files;
}

OutputFolder::OutputFolder(std::filesystem::path path) : path_(std::move(path)) {
    std::error_code error;
    for (auto folder = path_; !folder.empty() && !std::filesystem::exists(folder, error);
         folder = folder.parent_path()) {
        if (folder.has_filename()) // none of "runs/", whose parent is "runs"
            made_.push_back(folder);
    }
    std::filesystem::create_directories(path_, error);
    if (error)
        throw support::InputError(
            fmt::format("{}: cannot be made ({}); choose another --output", path_.string(), error.message()));
}

OutputFolder::~OutputFolder() {
    std::error_code error;
    for (const auto &folder : made_)
        if (!std::filesystem::remove(folder, error)) // something is in it, or in the one around it
            break;
}

OutputFile::OutputFile(const std::filesystem::path &folder, const std::string &name)
    : folder_(std::make_unique<OutputFolder>(folder)), path_(folder_->path() / name) {
    support::check_place(path_);
    claim_ = std::make_unique<support::FileClaim>(path_);
}

void Steps::next(const std::string &about) {
    ++step_;
    if (report_)
        report_(std::min(step_, num_steps_), num_steps_, about); // a model that solves again is no step more
}

void TimeSpent::stop() {
    if (is_running_)
        add(current_, std::chrono::duration<double>(Clock::now() - start_).count());
    is_running_ = false;
}

void TimeSpent::begin(const std::string &stage) {
    stop();
    current_ = stage;
    is_running_ = true;
    start_ = Clock::now();
}

void TimeSpent::add(const std::string &stage, double seconds) {
    const auto found = std::ranges::find(stages_, stage, &decltype(stages_)::value_type::first);
    if (found != stages_.end())
        found->second += seconds;
    else
        stages_.emplace_back(stage, seconds);
}

void TimeSpent::add(const TimeSpent &other) {
    for (const auto &[stage, seconds] : other.stages_)
        add(stage, seconds);
}

std::string TimeSpent::text() const {
    constexpr double smallest_part = 0.01;
    double total = 0.0;
    for (const auto &[name, seconds] : stages_)
        total += seconds;
    auto longest_first = stages_;
    std::ranges::stable_sort(longest_first, std::greater<>{}, &decltype(stages_)::value_type::second);
    results::Layout layout{{{"stage"}, {"time [s]", true}, {"part [%]", true}}, {}};
    for (const auto &[name, seconds] : longest_first)
        if (seconds >= smallest_part * total)
            layout.rows.push_back({name, results::fixed(seconds, 1), results::fixed(100.0 * seconds / total, 0)});
    return fmt::format("Time spent: {:.1f} s\n\n{}", total, results::to_text(layout));
}

} // namespace livermark::studies
