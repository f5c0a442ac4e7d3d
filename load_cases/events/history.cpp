#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "load_cases/readers/event_reader.hpp"
#include "load_cases/readers/load_case_reader.hpp"

namespace livermark::load_cases {

namespace {

constexpr int intervals_of_a_press = 10, intervals_of_a_hold = 20, intervals_of_a_cycle = 20;
constexpr double most_cycles = 20.0;
constexpr double longest_time = 1e7; // [s], four months; longer ones are slips of the unit

double positive_time(const toml::table &table, std::string_view key) {
    const double time = support::required_number(table, key);
    if (!(time > 0.0) || time > longest_time)
        support::refuse(*table.get(key), "'{}' is {:g}; it has to be a positive time in seconds, {:g} at most", key,
                        time, longest_time);
    return time;
}

core::PronySeries series_of(const toml::table &table, const std::string &name) {
    core::PronySeries series{.name = name,
                             .moduli = support::required_numbers(table, "moduli"),
                             .times = support::required_numbers(table, "times")};
    const auto place = support::place_of(*table.get("moduli"));
    if (series.moduli.size() != series.times.size())
        throw support::InputError("{}: there are {} moduli and {} times; give one time for each modulus", place,
                                  series.moduli.size(), series.times.size());
    if (std::ranges::any_of(series.moduli, [](double modulus) { return modulus < 0.0; }) || !(series.remaining() > 0.0))
        throw support::InputError("{}: moduli are parts of the shear modulus that fade: none may be negative, and "
                                  "their sum {:g} has to be below 1; change them",
                                  place, 1.0 - series.remaining());
    if (std::ranges::any_of(series.times, [](double time) { return !(time > 0.0); }))
        support::refuse(*table.get("times"), "'times' have to be positive, in seconds");
    return series;
}

/// Reads a Prony series:
///
///     title = "what relaxes"
///     moduli = [0.3, 0.3]   # g_k, parts of the shear modulus of the elastic law that fade; their sum is below 1
///     times = [1.86, 51.3]  # tau_k [s], as many
///     source = "where the numbers come from"
///
/// @throws support::InputError with file, line and remedy
core::PronySeries read_prony_series(const std::filesystem::path &toml_file) {
    const auto table = support::parse_toml(support::read_text(toml_file), toml_file);
    support::refuse_unknown_keys(table, {"title", "moduli", "times", "source"});
    return series_of(table, toml_file.stem().string());
}

core::PronySeries read_relaxation(const toml::table &history, const std::filesystem::path &file) {
    const auto *node = history.get("relaxation");
    if (node && node->is_table()) {
        support::refuse_unknown_keys(*node->as_table(), {"moduli", "times"});
        return series_of(*node->as_table(), file.stem().string());
    }
    const auto name = support::required_string(history, "relaxation");
    if (std::filesystem::path(name).extension() == ".toml")
        return read_prony_series(file.parent_path() / name);
    const auto folder = support::root_folder() / "load_cases" / "relaxation";
    const auto known = support::list_toml(folder);
    if (std::ranges::find(known, name) == known.end())
        support::refuse(*node, "{}", support::unknown_name("Prony series", name, known));
    return read_prony_series(folder / (name + ".toml"));
}

/// Adds times at which the factor goes from its last value to another one, linearly.
void add_ramp(core::SlowHistory &history, double duration, double factor, int num_intervals) {
    const double start = history.times.back(), before = history.factors.back();
    for (int n = 1; n <= num_intervals; ++n) {
        const double part = static_cast<double>(n) / num_intervals;
        history.times.push_back(start + part * duration);
        history.factors.push_back(n == num_intervals ? factor : std::lerp(before, factor, part));
    }
}

/// Adds times at which nothing happens but time: each interval is longer than the one before by the same ratio.
/// @param first  about how long the first interval is [s]
void add_hold(core::SlowHistory &history, double duration, double first) {
    const auto sum = [&](double ratio) { // of the intervals, over the first
        double total = 0.0, interval = 1.0;
        for (int n = 0; n < intervals_of_a_hold; ++n, interval *= ratio)
            total += interval;
        return total;
    };
    double low = 1.0, high = 10.0;
    for (int halving = 0; halving < 60; ++halving) {
        const double middle = 0.5 * (low + high);
        (sum(middle) * first < duration ? low : high) = middle;
    }
    const double start = history.times.back();
    double interval = duration / sum(low), time = 0.0;
    for (int n = 1; n <= intervals_of_a_hold; ++n, interval *= low) {
        time += interval;
        history.times.push_back(n == intervals_of_a_hold ? start + duration : start + time);
        history.factors.push_back(history.factors.back());
    }
}

void add_cycles(core::SlowHistory &history, double frequency, int num_cycles) {
    for (int cycle = 0; cycle < num_cycles; ++cycle) {
        history.last_cycle = history.num_records() - 1;
        for (int n = 1; n <= intervals_of_a_cycle; ++n) {
            const double part = static_cast<double>(n) / intervals_of_a_cycle;
            history.times.push_back((cycle + part) / frequency);
            history.factors.push_back(n == intervals_of_a_cycle ? 0.0
                                      : 2 * n == intervals_of_a_cycle
                                          ? 1.0
                                          : 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * part));
        }
    }
}

int read_num_cycles(const toml::table &history) {
    const double number = support::required_number(history, "cycles");
    if (number < 1.0 || number > most_cycles || number != std::round(number))
        support::refuse(*history.get("cycles"), "'cycles' is {:g}; it has to be a whole number from 1 to {:g}", number,
                        most_cycles);
    return static_cast<int>(number);
}

/// A motion begins at the whole load.
void refuse_what_ends_before_a_release(const toml::table &table, const toml::table &history) {
    for (const auto *key : {"release", "rest", "frequency", "cycles"})
        if (history.contains(key))
            support::refuse(*history.get(key),
                            "a [release] lets go of the whole load where the [history] ends; say how long it takes to "
                            "'press' and to 'hold' there, and remove '{}' or the [release]",
                            key);
    if (table["regime"].value<std::string>() == "large")
        support::refuse(*table.get("regime"), "the motion of tissue that relaxes has a reference in the regime "
                                              "\"small\" alone; take that, or remove the [release] or the [history]");
}

void refuse_company_of_history(const toml::table &table, const toml::table &history) {
    support::refuse_unknown_keys(history, {"relaxation", "press", "hold", "release", "rest", "frequency", "cycles"});
    for (const auto *key : {"tool", "needle", "path"})
        if (table.contains(key))
            support::refuse(*table.get(key),
                            "a load case with a [history] is so slow that masses do not matter, and its loads grow "
                            "with time alone; remove '{}' or the [history]",
                            key);
    if (table.contains("release"))
        refuse_what_ends_before_a_release(table, history);
}

core::SlowHistory slow_history_of(const toml::table &read, const std::filesystem::path &file) {
    core::SlowHistory history{.relaxation = read_relaxation(read, file), .times = {0.0}, .factors = {0.0}};
    const bool has_cycles = read.contains("cycles") || read.contains("frequency");
    const bool has_phases =
        read.contains("press") || read.contains("hold") || read.contains("release") || read.contains("rest");
    if (has_cycles == has_phases)
        support::refuse(read, "a [history] says either how long it takes to 'press', and to 'hold', 'release' and "
                              "'rest' after that, or the 'frequency' and number of 'cycles'; give one of the two");
    if (has_cycles) {
        const double frequency = support::required_number(read, "frequency");
        if (!(frequency >= 1.0 / longest_time))
            support::refuse(*read.get("frequency"), "'frequency' is {:g}; it has to be positive, in hertz", frequency);
        add_cycles(history, frequency, read_num_cycles(read));
        return history;
    }
    const double press = positive_time(read, "press");
    add_ramp(history, press, 1.0, intervals_of_a_press);
    const auto shortest = [&](double duration) {
        double interval = std::min(press, duration) / intervals_of_a_press;
        for (const double time : history.relaxation.times)
            interval = std::min(interval, std::max(time, duration * 1e-3) / intervals_of_a_press);
        return interval;
    };
    if (read.contains("hold")) {
        const double hold = positive_time(read, "hold");
        add_hold(history, hold, shortest(hold));
    }
    if (read.contains("release"))
        add_ramp(history, positive_time(read, "release"), 0.0, intervals_of_a_press);
    if (read.contains("rest")) {
        if (!read.contains("release"))
            support::refuse(*read.get("rest"), "a 'rest' comes after a 'release'; add one, or 'hold' instead");
        const double rest = positive_time(read, "rest");
        add_hold(history, rest, shortest(rest));
    }
    return history;
}

void read_history(const Reading &reading) {
    const auto &history = support::required_table(reading.table, "history");
    refuse_company_of_history(reading.table, history);
    reading.load_case.slow_history = slow_history_of(history, reading.file);
    reading.load_case.path.clear();
}

void refuse_history_of_rest(const Reading &reading) {
    if (!core::is_driven(reading.load_case))
        support::refuse(
            *reading.table.get("history"),
            "nothing moves the body, so its [history] is one of rest; add a load, a displacement or an acceleration");
}

} // namespace

namespace events {

/// Loads that grow with time in tissue that relaxes.
EventReader history() {
    return {.name = {},
            .what = "is of tissue that relaxes",
            .folder = "load_cases/slow",
            .in_time = true,
            .begin = read_history,
            .check = refuse_history_of_rest};
}

} // namespace events

} // namespace livermark::load_cases
