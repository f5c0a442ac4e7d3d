#include "studies/report/report_data.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <numeric>
#include <system_error>
#include <utility>

#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/hdf5/result_files.hpp"
#include "results/one_reference.hpp"
#include "results/records/arena.hpp"
#include "results/records/experiment.hpp"
#include "results/records/needle.hpp"
#include "studies/run/benchmark_case.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

/// Bodies together, and of each the Poisson's ratios in order.
void sort_results(ReportData &data) {
    std::vector<std::size_t> order(data.results.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t r) {
        const auto &body = *data.results[r].problem.body;
        return std::pair(body.name, body.materials.front().poisson_ratio);
    });
    ReportData sorted;
    for (const auto r : order) {
        sorted.results.push_back(std::move(data.results[r]));
        sorted.files.results.push_back(std::move(data.files.results[r]));
    }
    data.results = std::move(sorted.results);
    data.files.results = std::move(sorted.files.results);
}

/// Numbers of two references are never in one table, so only the results of the one that most files have stay.
void keep_one_reference(std::vector<results::Result> &all, std::vector<std::string> &files,
                        std::vector<std::string> &faults) {
    std::map<std::string, int> counts;
    for (const auto &result : all)
        if (const auto reference = results::reference_of(result); !reference.empty())
            ++counts[reference];
    if (counts.size() < 2)
        return;
    const auto kept = std::ranges::max_element(counts, {}, [](const auto &count) { return count.second; })->first;
    std::vector<results::Result> stay;
    std::vector<std::string> names;
    for (std::size_t r = 0; r < all.size(); ++r)
        if (const auto reference = results::reference_of(all[r]); reference == kept || reference.empty()) {
            stay.push_back(std::move(all[r]));
            names.push_back(std::move(files[r]));
        } else {
            faults.push_back(fmt::format("{}: its errors are against {}, and those of most files here against {}, and "
                                         "no table mixes them; move it to a folder of its own for another report",
                                         files[r], reference, kept));
        }
    all = std::move(stay);
    files = std::move(names);
}

/// A cohort file speaks for the result files of its bodies below it.
struct SpokenFor {
    std::filesystem::path folder;
    std::vector<results::CohortBody> bodies;

    bool has(const std::filesystem::path &file) const {
        return std::ranges::mismatch(folder, file).in1 == folder.end() &&
               std::ranges::find(bodies, file.parent_path().filename().string(), &results::CohortBody::name) !=
                   bodies.end();
    }
};

void read_file(const std::filesystem::path &file, const std::string &name, ReportData &data) {
    const auto keep = [&](auto content, auto &contents, std::vector<std::string> &names) {
        contents.push_back(std::move(content));
        names.push_back(name);
    };
    switch (results::kind_of_file(file)) {
    case results::FileKind::result: {
        auto result = results::read_result(file);
        const bool is_large = result.problem.load_case.regime == core::Regime::large;
        keep(std::move(result), is_large ? data.large : data.results, is_large ? data.files.large : data.files.results);
        break;
    }
    case results::FileKind::stability:
        return keep(results::read_stability(file), data.stability, data.files.stability);
    case results::FileKind::timings:
        return keep(results::read_timings(file), data.timings, data.files.timings);
    case results::FileKind::arena:
        return keep(results::read_arena(file), data.arenas, data.files.arenas);
    case results::FileKind::experiment:
        return keep(results::read_experiment(file), data.experiments, data.files.experiments);
    case results::FileKind::needle:
        return keep(results::read_needles_file(file), data.needles, data.files.needles);
    case results::FileKind::sensitivity:
        data.files.sensitivities.push_back(name);
        break;
    case results::FileKind::cohort: // none is left in the list
    case results::FileKind::modes:
    case results::FileKind::calibration:
    case results::FileKind::other:
        data.files.others.push_back(name);
    }
}

/// Reads the cohort files, and takes them and what cannot be read from the list.
std::vector<SpokenFor> read_cohorts(std::vector<std::filesystem::path> &files, ReportData &data) {
    std::vector<SpokenFor> spoken_for;
    std::erase_if(files, [&](const std::filesystem::path &file) {
        try {
            if (results::kind_of_file(file) != results::FileKind::cohort)
                return false;
            data.cohorts.push_back(results::read_cohort(file));
            data.files.cohorts.push_back(file.lexically_relative(data.folder).string());
            spoken_for.push_back({file.parent_path(), data.cohorts.back().bodies});
        } catch (const support::InputError &fault) {
            data.faults.emplace_back(fault.what());
        }
        return true;
    });
    return spoken_for;
}

} // namespace

ReportData read_report_data(const std::filesystem::path &folder, const std::map<std::string, std::string> &left_out) {
    std::error_code error;
    if (!std::filesystem::is_directory(folder, error))
        throw support::InputError(
            fmt::format("{}: there is no such folder; give the one that `livermark run` filled", folder.string()));
    ReportData data;
    data.folder = folder;
    auto files = results::hdf5_files_below(folder);
    for (const auto &[name, fault] : left_out) {
        std::erase(files, folder / name);
        data.faults.push_back(fault);
    }
    const auto spoken_for = read_cohorts(files, data);
    for (const auto &file : files)
        try {
            if (std::ranges::none_of(spoken_for, [&](const SpokenFor &cohort) { return cohort.has(file); }))
                read_file(file, file.lexically_relative(folder).string(), data);
        } catch (const support::InputError &fault) {
            data.faults.emplace_back(fault.what());
        }
    if (data.results.empty() && data.large.empty() && data.cohorts.empty() && data.arenas.empty() &&
        data.stability.empty() && data.timings.empty() && data.experiments.empty() && data.needles.empty() &&
        data.files.sensitivities.empty())
        throw support::InputError(
            data.faults.empty() ? fmt::format("{0}: there are no result files here; make some with `livermark run "
                                              "--output {0}`",
                                              folder.string())
                                : data.faults.front());
    keep_one_reference(data.results, data.files.results, data.faults);
    keep_one_reference(data.large, data.files.large, data.faults);
    // Small and large deformations of one body are of one body.
    std::vector<results::Result> all = std::move(data.results);
    const auto num_small = static_cast<std::ptrdiff_t>(all.size());
    std::ranges::move(data.large, std::back_inserter(all));
    results::tell_bodies_apart(all);
    data.results.assign(std::move_iterator(all.begin()), std::move_iterator(all.begin() + num_small));
    data.large.assign(std::move_iterator(all.begin() + num_small), std::move_iterator(all.end()));
    sort_results(data);
    return data;
}

} // namespace livermark::studies
