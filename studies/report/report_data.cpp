#include "studies/report/report_data.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <numeric>
#include <sstream>
#include <system_error>
#include <toml++/toml.h>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/one_reference.hpp"
#include "results/records/arena.hpp"
#include "results/records/cohort.hpp"
#include "results/records/experiment.hpp"
#include "results/records/needle.hpp"
#include "results/records/springs.hpp"
#include "results/tables/table.hpp"
#include "studies/run/run.hpp"

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

template <class Values> toml::array array_of(const Values &values) {
    toml::array array;
    for (const auto &value : values)
        array.push_back(value);
    return array;
}

toml::table json_of(const results::Layout &layout) {
    toml::array columns, rows;
    for (const auto &column : layout.columns)
        columns.push_back(toml::table{{"title", column.title}, {"is_number", column.is_number}});
    for (const auto &row : layout.rows)
        rows.push_back(array_of(row));
    return toml::table{{"columns", std::move(columns)}, {"rows", std::move(rows)}};
}

toml::array json_of(const std::vector<results::Standing> &standings) {
    toml::array array;
    for (const auto &standing : standings)
        array.push_back(toml::table{{"body", standing.body},
                                    {"load_case", standing.load_case},
                                    {"model", standing.model},
                                    {"integrator", standing.integrator},
                                    {"cost", standing.at.cost},
                                    {"error", standing.at.error},
                                    {"is_ranked", standing.is_ranked()},
                                    {"is_on_front", standing.is_on_front}});
    return array;
}

/// Numbers of the first page of the report.
toml::array json_of(const std::vector<results::BriefNumbers> &all) {
    toml::array array;
    for (const auto &[body, model, numbers] : all)
        array.push_back(toml::table{{"body", body},
                                    {"model", model},
                                    {"error", numbers.median_error},
                                    {"stiffness", numbers.median_stiffness},
                                    {"cells", toml::array{numbers.error, numbers.stiffness}},
                                    {"is_spring_model", numbers.is_spring_model}});
    return array;
}

toml::array files_with_labels(const std::vector<std::string> &files, const std::vector<results::Result> &results) {
    toml::array array;
    for (std::size_t r = 0; r < results.size(); ++r)
        array.push_back(toml::table{{"file", files[r]},
                                    {"label", results::body_label(results[r], results)},
                                    {"counts", results::counts_in_means(results[r])},
                                    {"leaves_regime", results::leaves_regime(results[r])},
                                    {"remarks", array_of(results::result_remarks({&results[r], 1}))}});
    return array;
}

/// Table and forces of one body, for its part of the section on large deformations.
toml::table large_body(const std::string &label, const std::vector<results::Result> &all) {
    std::vector<results::Result> body_results;
    toml::array forces;
    for (const auto &result : all)
        if (results::body_label(result, all) == label) {
            body_results.push_back(result);
            for (const auto &curve : results::force_curves(result))
                forces.push_back(toml::table{{"load_case", result.problem.load_case.name},
                                             {"place", curve.place},
                                             {"way", array_of(curve.way)},
                                             {"model", curve.model},
                                             {"force", array_of(curve.force)}});
        }
    return toml::table{
        {"label", label}, {"table", json_of(results::large_table(body_results))}, {"forces", std::move(forces)}};
}

toml::array large_bodies(const std::vector<results::Result> &all) {
    toml::array bodies;
    std::vector<std::string> labels;
    for (const auto &result : all)
        if (const auto label = results::body_label(result, all); std::ranges::find(labels, label) == labels.end()) {
            labels.push_back(label);
            bodies.push_back(large_body(label, all));
        }
    return bodies;
}

/// Responses over time to each tool of a load case in which time passes in the material.
toml::array slow_curves(const results::Result &result) {
    const auto &problem = result.problem;
    toml::array curves;
    for (const auto &model : result.models)
        for (const auto &response : core::slow_responses(problem.body->mesh, problem.load_case, model.solution))
            curves.push_back(toml::table{{"model", model.name},
                                         {"place", response.place},
                                         {"is_force", response.is_force},
                                         {"values", array_of(response.values)}});
    return curves;
}

toml::array slow_of(const std::vector<results::Result> &all, const std::vector<std::string> &files) {
    toml::array array;
    for (std::size_t r = 0; r < all.size(); ++r)
        if (const auto &history = all[r].problem.load_case.slow_history)
            array.push_back(toml::table{{"file", files[r]},
                                        {"label", results::body_label(all[r], all)},
                                        {"time", array_of(history->times)},
                                        {"curves", slow_curves(all[r])},
                                        {"table", json_of(results::slow_table({&all[r], 1}))}});
    return array;
}

toml::array arenas_of(const ReportData &data) {
    toml::array array;
    for (std::size_t a = 0; a < data.arenas.size(); ++a) {
        const auto &arena = data.arenas[a];
        const auto overview = arena.reference.empty() ? results::arena_forces(arena) : results::arena_overview(arena);
        array.push_back(toml::table{{"file", data.files.arenas[a]},
                                    {"overview", json_of(overview)},
                                    {"table", json_of(results::arena_table(arena))},
                                    {"series", json_of(results::arena_series(arena))}});
    }
    return array;
}

toml::array toml_array_of(const std::vector<std::string> &texts) {
    toml::array array;
    for (const auto &text : texts)
        array.push_back(text);
    return array;
}

toml::array experiments_of(const ReportData &data) {
    toml::array array;
    for (std::size_t e = 0; e < data.experiments.size(); ++e) {
        const auto &experiment = data.experiments[e];
        array.push_back(toml::table{{"file", data.files.experiments[e]},
                                    {"table", json_of(results::experiment_table(experiment))},
                                    {"force_table", json_of(results::force_table(experiment))},
                                    {"null_notes", toml_array_of(results::notes_on_nulls(experiment))},
                                    {"ring_down_table", json_of(results::ring_down_table(experiment))},
                                    {"ring_down_note", results::ring_down_note(experiment)}});
    }
    return array;
}

toml::array needles_of(const ReportData &data) {
    toml::array array;
    for (std::size_t n = 0; n < data.needles.size(); ++n)
        array.push_back(toml::table{{"file", data.files.needles[n]},
                                    {"table", json_of(results::needle_table(data.needles[n]))},
                                    {"note", results::needle_note(data.needles[n])}});
    return array;
}

toml::array stability_of(const ReportData &data) {
    toml::array array;
    for (std::size_t s = 0; s < data.stability.size(); ++s)
        array.push_back(toml::table{{"file", data.files.stability[s]},
                                    {"table", json_of(results::stability_table(data.stability[s]))}});
    return array;
}

/// A sentence in which the files of a folder are named from there.
std::string below(const std::filesystem::path &folder, std::string sentence) {
    const auto start = (folder / "").string();
    for (auto at = sentence.find(start); at != std::string::npos; at = sentence.find(start, at))
        sentence.erase(at, start.size());
    return sentence;
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

std::string report_tables(const ReportData &data, const std::string &command_line) {
    toml::array faults;
    for (const auto &fault : data.faults)
        faults.push_back(below(data.folder, fault));
    const toml::table tables{
        {"folder", data.folder.string()},
        {"command", command_line},
        {"results", files_with_labels(data.files.results, data.results)},
        {"large", files_with_labels(data.files.large, data.large)},
        {"slow", slow_of(data.results, data.files.results)},
        {"large_slow", slow_of(data.large, data.files.large)},
        {"slow_legend", results::slow_legend()},
        {"cohorts", array_of(data.files.cohorts)},
        {"arenas", arenas_of(data)},
        {"stability", stability_of(data)},
        {"experiments", experiments_of(data)},
        {"needles", needles_of(data)},
        {"sensitivities", array_of(data.files.sensitivities)},
        {"timings", array_of(data.files.timings)},
        {"others", array_of(data.files.others)},
        {"faults", std::move(faults)},
        {"brief", json_of(results::brief_numbers(data.results))},
        {"large_brief", json_of(results::brief_numbers(data.large))},
        {"large_bodies", large_bodies(data.large)},
        {"large_legend", results::large_legend()},
        {"tool_legend", results::tool_legend()},
        {"smallest_felt_difference", core::smallest_felt_difference},
        {"reference", results::reference_sentence(data.results)},
        {"large_reference", results::reference_sentence(data.large)},
        {"standings", toml::table{{"rest", json_of(results::standings_at_rest(data.results))},
                                  {"motion", json_of(results::standings_in_motion(data.results))}}},
        {"tables", toml::table{{"errors", json_of(results::error_table(data.results))},
                               {"rest", json_of(results::static_accuracy(data.results))},
                               {"motion", json_of(results::motion_accuracy(data.results))},
                               {"means", json_of(results::mean_errors(data.results))},
                               {"summary", json_of(results::summary(data.large))}}}};
    std::ostringstream text;
    text << toml::json_formatter(tables, toml::json_formatter::default_flags & ~toml::format_flags::indentation);
    return text.str();
}

} // namespace livermark::studies
