#include "results/hdf5/files/timings_file.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <set>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "results/quantile.hpp"
#include "support/whole_file.hpp"

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

/// What schema.md says that a benchmark may count.
constexpr std::array counter_names{"springs",
                                   "nodes",
                                   "unknowns",
                                   "time_per_spring",
                                   "of_limit",
                                   "bytes",
                                   "bytes_per_spring",
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

/// A group without seconds holds benchmarks whose names go on.
void read_below(const hdf5::InputFile &file, const std::string &group, std::vector<Timing> &timings) {
    if (!file.has(group + "/seconds")) {
        for (const auto &child : file.children(group))
            read_below(file, fmt::format("{}/{}", group, child), timings);
        return;
    }
    Timing timing{.name = group.substr(top.size() + 1),
                  .seconds = file.dataset<double>(group + "/seconds"),
                  .is_wall_clock = file.text(group, "clock") == "wall",
                  .iterations = file.integer(group, "iterations"),
                  .counters = {}};
    if (timing.seconds.empty() || !std::ranges::all_of(timing.seconds, [](double value) { return value >= 0.0; }))
        file.refuse(group + "/seconds", "is empty, or holds what is no time");
    for (const auto *const counter : counter_names)
        if (file.has_attribute(group, counter))
            timing.counters[counter] = file.number(group, counter);
    timings.push_back(std::move(timing));
}

} // namespace

void write_timings(const std::filesystem::path &path, const Timings &timings) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, timings.provenance);
    std::set<std::string> made;
    make_groups(file, top, made);
    for (const auto &timing : timings.timings) {
        const auto group = top + "/" + timing.name;
        make_groups(file, group, made);
        file.number(group, "seconds_median", median(timing.seconds));
        file.number(group, "seconds_min", *std::ranges::min_element(timing.seconds));
        file.number(group, "seconds_max", *std::ranges::max_element(timing.seconds));
        file.text(group, "clock", timing.is_wall_clock ? "wall" : "processor");
        file.integer(group, "iterations", timing.iterations);
        for (const auto &[name, value] : timing.counters)
            file.number(group, name, value);
        file.dataset(group + "/seconds", timing.seconds, "s");
    }
    support::write_whole(path, file.image());
}

namespace {

Timings timings_in(const std::filesystem::path &path) {
    const hdf5::InputFile file(path, "step_benchmark --hdf5=FILE");
    hdf5::check_schema(file);
    Timings timings{.provenance = hdf5::read_provenance(file), .timings = {}};
    read_below(file, top, timings.timings);
    return timings;
}

} // namespace

Timings read_timings(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return timings_in(path); });
}

} // namespace livermark::results
