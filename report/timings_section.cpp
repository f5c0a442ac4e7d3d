#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/sections.hpp"
#include "results/quantile.hpp"

namespace livermark::report {

namespace {

using core::percent;
constexpr double microseconds = 1e6;
constexpr double nanoseconds = 1e9;

std::string counter(const results::Timing &timing, const std::string &name, double unit, int digits) {
    const auto found = timing.counters.find(name);
    return found == timing.counters.end() ? "-" : fmt::format("{:.{}g}", unit * found->second, digits);
}

/// Never with an exponent, so that the column can be read down.
std::string in_microseconds(double seconds) {
    const double number = microseconds * seconds;
    return fmt::format("{:.{}f}", number, number < 10.0 ? 2 : number < 1000.0 ? 1 : 0);
}

std::string whole(const results::Timing &timing, const std::string &name) {
    const auto found = timing.counters.find(name);
    return found == timing.counters.end() ? "-" : fmt::format("{:.0f}", found->second);
}

/// How much of the machine's limit a step comes to, as a bar; empty where it is unknown.
std::string bar_of(const results::Timing &timing) {
    const auto found = timing.counters.find("of_limit");
    if (found == timing.counters.end())
        return "";
    constexpr double width = 120.0;
    return fmt::format(
        "<svg style=\"width:{0}px\" viewBox=\"0 0 {0} 10\"><rect class=\"track\" width=\"{0}\" height=\"10\"/>"
        "<rect width=\"{1:.1f}\" height=\"10\" fill=\"#0072b2\"/></svg>",
        width, width * std::clamp(found->second, 0.0, 1.0));
}

results::Layout layout_of(const results::Timings &timings) {
    results::Layout layout{{{"benchmark"},
                            {"median [us]", true},
                            {"shortest [us]", true},
                            {"repetitions", true},
                            {"clock"},
                            {"springs", true},
                            {"per spring [ns]", true},
                            {"of the limit [%]", true},
                            {"simulated s/s", true}},
                           {}};
    for (const auto &timing : timings.timings)
        layout.rows.push_back({timing.name, in_microseconds(results::median(timing.seconds)),
                               in_microseconds(*std::ranges::min_element(timing.seconds)),
                               fmt::format("{}", timing.seconds.size()), timing.is_wall_clock ? "wall" : "processor",
                               whole(timing, "springs"), counter(timing, "time_per_spring", nanoseconds, 3),
                               counter(timing, "of_limit", percent, 3), counter(timing, "real_time_factor", 1.0, 3)});
    return layout;
}

std::string table_of(const results::Timings &timings) {
    HtmlColumn bars{"of the limit", {}};
    for (const auto &timing : timings.timings)
        bars.contents.push_back(bar_of(timing));
    const bool has_bar = std::ranges::any_of(bars.contents, [](const auto &bar) { return !bar.empty(); });
    return table_html(layout_of(timings), {}, has_bar ? bars : HtmlColumn{}) +
           (has_bar ? "" : missing("No benchmark in this file is compared with the limit of the machine."));
}

} // namespace

std::string timings_section(const ReportData &data) {
    constexpr auto *title = "What a step takes";
    constexpr auto *command = "build/release/benchmarks/step_benchmark --hdf5=FILE";
    if (data.timings.empty())
        return section("timings", title, missing("There are no timing files here.", command));
    auto html = paragraph(
        "The limit is the least time that one evaluation of all spring forces can take on one core of "
        "this machine in single precision: gathering both ends of each spring, reading the data of a step, and its "
        "operations, each measured in the same process. 100 % is the limit of one core; several threads "
        "can be faster.");
    for (const auto &timings : data.timings) {
        const auto &made = timings.provenance;
        html += figure(
            "table", table_of(timings),
            fmt::format("Timings of {} ({}, {}, commit {}).", made.cpu, made.build_type, made.created, made.git_commit),
            {made.command});
    }
    return section("timings", title, html);
}

} // namespace livermark::report
