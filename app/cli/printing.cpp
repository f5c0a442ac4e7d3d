#include "app/cli/commands.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fmt/format.h>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <toml++/toml.h>
#include <unistd.h>
#include <vector>

#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "results/one_reference.hpp"
#include "results/records/arena.hpp"
#include "results/tables/table.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::cli {

namespace {

constexpr const char *erase_line = "\r\033[K";

/// The line of a terminal.
class Line {
  public:
    Line() = default;
    ~Line() {
        if (is_terminal_ && is_written_)
            fmt::print(stderr, "{}", erase_line);
    }
    Line(const Line &) = delete;
    Line &operator=(const Line &) = delete;

    void write(const std::string &text) {
        is_written_ = true;
        if (is_terminal_)
            fmt::print(stderr, "{}{}", erase_line, text);
        else
            fmt::print(stderr, "{}\n", text);
        std::fflush(stderr);
    }

  private:
    bool is_terminal_ = isatty(fileno(stderr)) != 0;
    bool is_written_ = false;
};

/// "1:05", or "1:02:05" from an hour on.
std::string clock_text(double seconds) {
    const auto whole = static_cast<long>(seconds);
    return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                        : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

constexpr auto *small_title = "Small deformations; reference: linear elasticity.";
constexpr auto *slow_title = "Tissue that relaxes: the force over time.";
constexpr auto *large_title = "Large deformations; reference: hyperelasticity along the path of the load.";

/// Which reference the numbers of the tables belong to, and what is not as it should be.
std::string judged_by(std::span<const results::Result> results, const std::string &bullet) {
    auto text = " " + results::printable(results::reference_sentence(results)) + "\n";
    const auto remarks = results::result_remarks(results);
    text += remarks.empty() ? "" : "\n";
    for (const auto &remark : remarks)
        text += bullet + results::printable(remark) + "\n";
    return text;
}

const char *title_of(core::Regime regime) {
    return regime == core::Regime::small ? small_title : large_title;
}

class Printer {
  public:
    explicit Printer(bool markdown) : markdown_(markdown) {}

    void print(const std::string &text) {
        fmt::print("{}{}", is_first_ ? "" : "\n", text);
        is_first_ = false;
    }
    std::string as_text(const results::Layout &layout) const { return table_text(layout, markdown_); }
    bool is_markdown() const { return markdown_; }

  private:
    bool markdown_;
    bool is_first_ = true;
};

bool is_slow(const results::Result &result) {
    return result.problem.load_case.slow_history.has_value();
}

/// @param results  of one regime and reference, at least one
void print_group(Printer &printer, std::span<const results::Result> results, TableKind kind) {
    if (kind == TableKind::brief) {
        const auto layout = results::brief(results);
        if (!layout.rows.empty()) {
            printer.print(title_of(results.front().problem.load_case.regime) +
                          judged_by(results, printer.is_markdown() ? "- " : ""));
            return printer.print(printer.as_text(layout) + "\n" + results::brief_legend(results));
        }
        kind = TableKind::all;
    }
    const bool is_all = kind == TableKind::all;
    const auto regime = results.front().problem.load_case.regime;
    const bool is_large = regime == core::Regime::large;
    // All tables have that of the tool below the first.
    const auto legend = "\n" + results::mean_tool_legend() + (is_all ? "" : results::tool_legend());
    printer.print(title_of(regime) + judged_by(results, printer.is_markdown() ? "- " : ""));
    if (is_all || kind == TableKind::models) {
        if (is_large)
            printer.print(printer.as_text(results::large_table(results)) + "\n" + results::large_legend() +
                          results::tool_radii(results) + results::yielded_places(results) +
                          results::motion_lines(results, printer.is_markdown() ? "- " : ""));
        else
            printer.print(printer.is_markdown() ? results::markdown_table(results) : results::text_table(results));
    }
    if (kind == TableKind::forces)
        printer.print(printer.as_text(results::force_table(results)));
    if (is_all || kind == TableKind::summary)
        printer.print(printer.as_text(results::summary(results)) + legend);
    if (kind == TableKind::overview || (is_all && results::has_several_poisson_ratios(results)))
        printer.print(printer.as_text(results::overview(results)) + legend);
    if (kind == TableKind::medians || (is_all && results::has_several_load_cases(results))) {
        const auto layout = results::median_errors(results);
        if (layout.rows.empty())
            throw support::InputError("there is no static load case here to take a median of; give result files of "
                                      "`livermark run --static`");
        printer.print(printer.as_text(layout) + "\n" + results::median_legend(results));
    }
    if (kind == TableKind::means)
        printer.print(printer.as_text(results::mean_errors(results)) + legend);
}

} // namespace

studies::ProgressReport print_progress() {
    using Clock = std::chrono::steady_clock;
    return [line = std::make_shared<Line>(), start = std::make_shared<std::optional<Clock::time_point>>()](
               int step, int num_steps, const std::string &about) {
        const auto now = Clock::now();
        if (!*start)
            *start = now;
        const double passed = std::chrono::duration<double>(now - **start).count();
        constexpr double soonest = 5.0; // [s]
        std::string times; // since the first step, and of the rest if its steps are as long as those before
        if (step > 1 && passed >= soonest)
            times = fmt::format(" ({}, about {} left)", clock_text(passed),
                                clock_text(passed / (step - 1) * (num_steps - step + 1)));
        line->write(fmt::format("[{}/{}] {}{}", step, num_steps, about, times));
    };
}

std::string table_text(const results::Layout &layout, bool markdown) {
    return markdown ? results::to_markdown(layout) : results::to_text(layout);
}

void print_notes(const std::vector<std::string> &notes) {
    for (const auto &note : notes)
        fmt::print(stderr, "livermark: {}\n", note);
}

void print_tables(std::span<const results::Result> results, TableKind kind, bool markdown) {
    if (kind == TableKind::cohort)
        return print_cohort(results::cohort_errors(results), markdown);
    Printer printer(markdown);
    auto groups = results::groups_by_reference(results);
    if (kind == TableKind::forces)
        std::erase_if(groups, [](const std::vector<results::Result> &group) {
            return group.front().problem.load_case.regime == core::Regime::small;
        });
    if (kind == TableKind::brief || kind == TableKind::all)
        for (auto &group : groups) {
            std::vector<results::Result> slow;
            std::ranges::copy_if(group, std::back_inserter(slow), is_slow);
            std::erase_if(group, is_slow);
            if (slow.empty())
                continue;
            printer.print(slow_title + judged_by(slow, markdown ? "- " : ""));
            printer.print(printer.as_text(results::slow_table(slow)) + "\n" + results::slow_legend() +
                          results::motion_lines(slow, markdown ? "- " : ""));
        }
    std::erase_if(groups, [](const std::vector<results::Result> &group) { return group.empty(); });
    if (kind == TableKind::forces && groups.empty())
        throw support::InputError("no path of large deformations is here to take forces from; give result files of "
                                  "load cases of the large regime");
    for (const auto &group : groups)
        print_group(printer, group, kind);
}

void print_cohort(std::span<const results::CohortError> errors, bool markdown) {
    const auto column = [&](auto value) {
        toml::array values;
        for (const auto &error : errors)
            values.push_back(value(error));
        return values;
    };
    using Error = results::CohortError;
    const toml::table question{
        {"errors",
         toml::table{{"body", column([](const Error &e) { return e.body; })},
                     {"regime", column([](const Error &e) { return core::to_string(e.regime); })},
                     {"poisson_ratio", column([](const Error &e) { return e.poisson_ratio; })},
                     {"load_case", column([](const Error &e) { return e.load_case; })},
                     {"model", column([](const Error &e) { return e.model; })},
                     {"is_ok", column([](const Error &e) { return e.status == core::SolutionStatus::ok; })},
                     {"relative_l2", column([](const Error &e) { return e.relative_l2; })},
                     {"stiffness", column([](const Error &e) { return e.stiffness; })},
                     {"reference", column([](const Error &e) { return e.reference; })},
                     {"uncertainty", column([](const Error &e) { return e.uncertainty; })},
                     {"stiffness_uncertainty", column([](const Error &e) { return e.stiffness_uncertainty; })}}},
        {"titles", toml::table{{"small", small_title}, {"large", large_title}}},
        {"tool_legend", results::tool_legend()},
        {"smallest_felt_difference", core::smallest_felt_difference},
        {"markdown", markdown}};
    std::ostringstream text;
    text << question;
    fmt::print("{}", support::run_python("studies.cohort", {"table"}, text.str(), "statistics of a cohort",
                                         "python3-numpy python3-h5py"));
}

} // namespace livermark::cli
