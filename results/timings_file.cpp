#include "results/timings_file.hpp"

#include <algorithm>
#include <set>

#include "core/whole_file.hpp"
#include "results/file_parts.hpp"

namespace livermark::results {

namespace {

/// Makes a group and those above it.
void make_groups(hdf5::OutputFile &file, const std::string &path, std::set<std::string> &made) {
    for (auto end = path.find('/', 1);; end = path.find('/', end + 1)) {
        if (const auto group = path.substr(0, end); made.insert(group).second)
            file.group(group, true);
        if (end == std::string::npos)
            return;
    }
}

} // namespace

double median(std::vector<double> values) {
    std::ranges::sort(values);
    return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

void write_timings(const std::filesystem::path &path, const Timings &timings) {
    hdf5::OutputFile file;
    hdf5::write_provenance(file, timings.provenance);
    std::set<std::string> made;
    make_groups(file, "/timings", made);
    for (const auto &timing : timings.timings) {
        const auto group = "/timings/" + timing.name;
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
    core::write_whole(path, file.image());
}

} // namespace livermark::results
