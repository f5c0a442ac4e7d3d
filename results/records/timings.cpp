#include "results/records/timings.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "results/hdf5/record_file.hpp"
#include "results/one_reference.hpp"

namespace livermark::results {

namespace {

const std::string top = "/timings";

/// Makes a group and those above it.
void make_groups(hdf5::OutputFile &file, const std::string &path, std::set<std::string> &made) {
    for (auto end = path.find('/', 1);; end = path.find('/', end + 1)) {
        if (const auto group = path.substr(0, end); made.insert(group).second)
            file.group(group, true);
        if (end == std::string::npos)
            return;
    }
}

/// Counters of a benchmark, as schema.md has them.
constexpr std::array counter_names{"springs",
                                   "nodes",
                                   "unknowns",
                                   "time_per_spring",
                                   "of_limit",
                                   "bytes",
                                   "bytes_per_spring",
                                   "held_steps",
                                   "steps_per_second",
                                   "real_time_factor",
                                   "time_step",
                                   "bytes_per_second",
                                   "flop_per_second",
                                   "livermark",
                                   "bullet",
                                   "bullet_over_livermark",
                                   "inner_iterations",
                                   "difference",
                                   "difference_converged"};

template <class At> void describe_counters(At at, hdf5::Of<At, std::map<std::string, double>> &counters) {
    if constexpr (At::reads)
        for (const auto *const name : counter_names)
            if (at.has(name))
                counters.emplace(name, 0.0);
    for (auto &[name, value] : counters)
        at.number(name, value);
}

template <class At> void describe_timing(At at, hdf5::Of<At, Timing> &timing) {
    std::string clock = timing.is_wall_clock ? "wall" : "processor";
    at.text("clock", clock);
    at.integer("iterations", timing.iterations);
    describe_counters(at, timing.counters);
    at.rows("seconds", timing.seconds, "s");
    at.check(!timing.seconds.empty() && std::ranges::all_of(timing.seconds, [](double value) { return value >= 0.0; }),
             "seconds", "is empty, or holds what is no time");
    if constexpr (At::reads) {
        timing.is_wall_clock = clock == "wall";
    } else {
        at.number("seconds_median", median(timing.seconds));
        at.number("seconds_min", *std::ranges::min_element(timing.seconds));
        at.number("seconds_max", *std::ranges::max_element(timing.seconds));
    }
}

/// A group without seconds holds benchmarks whose names go on.
void read_below(const hdf5::GroupReader &group, std::vector<Timing> &timings) {
    if (!group.file().has(group.path_of("seconds"))) {
        for (const auto &child : group.file().children(group.path()))
            read_below(group.on(child), timings);
        return;
    }
    describe_timing(group, timings.emplace_back());
    timings.back().name = group.path().substr(top.size() + 1);
}

void describe_timings(const hdf5::GroupReader &root, Timings &timings) {
    read_below(root.on("timings"), timings.timings);
}

void describe_timings(const hdf5::GroupWriter &root, const Timings &timings) {
    std::set<std::string> made;
    make_groups(root.file(), top, made);
    for (const auto &timing : timings.timings) {
        const auto group = root.on("timings").on(timing.name);
        make_groups(root.file(), group.path(), made);
        describe_timing(group, timing);
    }
}

} // namespace

void write_timings(const std::filesystem::path &path, const Timings &timings) {
    hdf5::write_record(path, timings, [](auto root, auto &record) { describe_timings(root, record); });
}

Timings read_timings(const std::filesystem::path &path) {
    return hdf5::read_record<Timings>(path, "step_benchmark --hdf5=FILE",
                                      [](auto root, auto &record) { describe_timings(root, record); });
}

} // namespace livermark::results
