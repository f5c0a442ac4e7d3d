#include "results/records/cut.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "core/observed_error.hpp"
#include "core/units.hpp"
#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/columns.hpp"

namespace livermark::results {

namespace {

using core::millimetres, core::millijoules, core::milliseconds;

constexpr double square_centimetres = 1e4;

/// @param num_records  K
template <class At> void describe_cut_run(At at, hdf5::Of<At, CutRun> &run, std::size_t num_records) {
    at.rows("stored", run.stored, "J", num_records);
    at.rows("work", run.work, "J", num_records);
    at.rows("opening", run.opening, "m", num_records);
    at.rows("tool_stiffness", run.tool_stiffness, "N/m", num_records);
    at.rows("setup_seconds", run.setup_seconds, "s", num_records);
    at.rows("solve_seconds", run.solve_seconds, "s", num_records);
    if (at.has("critical_time_step",
               !run.critical_time_step.empty())) // of springs, and not in files of an older version
        at.rows("critical_time_step", run.critical_time_step, "s");
}

template <class At> void describe_cut_motions(At at, hdf5::Of<At, CutFile> &cut) {
    at.number("frame_interval", cut.frame_interval);
    at.integer("frames_per_step", cut.frames_per_step, 1);
    auto columns = hdf5::columns_of(at, cut.motions);
    columns.texts("methods", &CutMotion::method);
    columns.texts("settings", &CutMotion::setting);
    columns.column("budget", &CutMotion::budget, "s");
    columns.column("steps", &CutMotion::steps);
    columns.column("iterations", &CutMotion::iterations);
    columns.column("setup_seconds", &CutMotion::setup_seconds, "s");
    columns.column("frame_seconds", &CutMotion::frame_seconds, "s");
    columns.column("worst_frame_seconds", &CutMotion::worst_frame_seconds, "s");
    columns.blocks("opening", &CutMotion::opening, cut.depth.size(), "m");
    columns.blocks("tool_stiffness", &CutMotion::tool_stiffness, cut.depth.size(), "N/m");
    columns.blocks("ready_seconds", &CutMotion::ready_seconds, cut.depth.size(), "s");
}

template <class At> void describe_finer_cuts(At at, hdf5::Of<At, CutFile> &cut) {
    auto columns = hdf5::columns_of(at, cut.levels);
    columns.texts("ways", &CutLevel::way, "cut");
    columns.column("tetrahedra", &CutLevel::tetrahedra, "", "tetrahedra");
    columns.column("area", &CutLevel::area, "m^2", {"cut [cm^2]", square_centimetres, 2});
    columns.column("depth", &CutLevel::depth, "m", {"rim at [mm]", millimetres, 1});
    columns.column("opening", &CutLevel::opening, "m", {"opening [mm]", millimetres, 3});
    columns.column("tool_stiffness", &CutLevel::tool_stiffness, "N/m", {"tool [N/m]", 1.0, 2});
    columns.column("solve_seconds", &CutLevel::solve_seconds, "s", {"time [s]", 1.0, 1});
}

template <class At> void describe_cut(At root, hdf5::Of<At, CutFile> &cut) {
    hdf5::describe_head(root, cut);
    const auto at = root.group("cut", hdf5::Order::kept);
    at.number("toughness", cut.toughness);
    std::string reference = cut.runs.empty() ? "" : cut.runs.front().model;
    at.text("reference", reference);
    if (at.has("regime")) // not in files of an older version
        at.word("regime", cut.regime);
    at.rows("blade", cut.blade, "m");
    at.rows("depth", cut.depth, "m");
    at.check(!cut.depth.empty(), "depth", "is empty");
    const auto num_records = cut.depth.size();
    at.rows("area", cut.area, "m^2", num_records);
    at.rows("cut_seconds", cut.cut_seconds, "s", num_records);
    at.rows("nodes", cut.nodes, "", num_records);
    at.group("models", hdf5::Order::kept).each(cut.runs, &CutRun::model, [&](auto of_model, auto &run) {
        describe_cut_run(of_model, run, num_records);
    });
    at.check(!cut.runs.empty() && cut.runs.front().model == reference, "does not begin with its reference");
    if (at.has("finer", !cut.levels.empty())) // only where the reference was refined
        describe_finer_cuts(at.group("finer"), cut);
    if (at.has("motions", !cut.motions.empty())) // only where methods have moved
        describe_cut_motions(at.group("motions"), cut);
}

double difference_in_percent(double value, double reference) {
    return core::percent * (value / reference - 1.0);
}

std::string percent_of(const ErrorBar &number) {
    return fixed(core::percent * number.error / number.value, 1);
}

double middle_of(std::vector<double> values) {
    if (values.empty())
        return std::numeric_limits<double>::quiet_NaN();
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double longest_of(const std::vector<double> &values) {
    return values.empty() ? std::numeric_limits<double>::quiet_NaN() : *std::ranges::max_element(values);
}

/// Errors of a motion in the end, and whether it has kept its budget.
struct RankedMotion {
    const CutMotion *motion;
    double opening, tool; ///< off by [%]; tool is NaN where nothing is touched
    bool is_too_slow;

    bool is_lost() const { return std::isnan(opening); }
    bool tool_leads() const { return std::abs(tool) > std::abs(opening); } // NaN does not
    double larger() const { return std::abs(tool_leads() ? tool : opening); }
    std::string leads() const { return is_lost() ? "-" : tool_leads() ? "tool" : "opening"; }

    /// Order within one budget. What is too slow stands behind what is not, and what was lost behind all.
    bool is_better_than(const RankedMotion &other) const {
        const auto rank = [](const RankedMotion &motion) { return std::pair(motion.is_lost(), motion.is_too_slow); };
        if (rank(*this) != rank(other))
            return rank(*this) < rank(other);
        return larger() < other.larger();
    }
};

/// The best setting of each method within each budget, budget by budget.
std::vector<RankedMotion> ranked_motions(const CutFile &file) {
    const auto judge = file.judge_in_the_end();
    std::vector<RankedMotion> ranked;
    for (const auto &motion : file.motions) {
        const RankedMotion here{&motion, difference_in_percent(motion.opening.back(), judge.opening.value),
                                difference_in_percent(motion.tool_stiffness.back(), judge.tool_stiffness.value),
                                motion.frame_seconds > motion.budget};
        const auto same = std::ranges::find_if(ranked, [&](const RankedMotion &other) {
            return other.motion->method == motion.method && other.motion->budget == motion.budget;
        });
        if (same == ranked.end())
            ranked.push_back(here);
        else if (here.is_better_than(*same))
            *same = here;
    }
    std::ranges::stable_sort(ranked, [](const RankedMotion &a, const RankedMotion &b) {
        return a.motion->budget != b.motion->budget ? a.motion->budget < b.motion->budget : a.is_better_than(b);
    });
    return ranked;
}

} // namespace

std::vector<double> CutFile::ready_seconds(const CutRun &run) const {
    std::vector<double> seconds;
    for (std::size_t k = 1; k < num_records(); ++k)
        if (run.solve_seconds[k] > 0.0)
            seconds.push_back(cut_seconds[k] + run.setup_seconds[k]);
    return seconds;
}

std::vector<double> CutFile::equilibrium_seconds(const CutRun &run) const {
    std::vector<double> seconds;
    for (std::size_t k = 1; k < num_records(); ++k)
        if (run.solve_seconds[k] > 0.0)
            seconds.push_back(run.solve_seconds[k] - run.setup_seconds[k]);
    return seconds;
}

double CutFile::release_rate(const CutRun &run, std::size_t record) const {
    if (record == 0 || !(area[record] > area[record - 1]))
        return std::numeric_limits<double>::quiet_NaN();
    return (run.released(record) - run.released(record - 1)) / (area[record] - area[record - 1]);
}

std::optional<ErrorBar> CutFile::in_the_end(const std::string &way, double CutLevel::*number) const {
    constexpr std::size_t enough_levels = 3; // to observe an order
    std::vector<double> values;
    for (const auto &level : levels)
        if (level.way == way)
            values.push_back(level.*number);
    if (values.size() < enough_levels)
        return std::nullopt;
    return ErrorBar{values.back(), core::observed_error(values)};
}

CutJudge CutFile::judge_in_the_end() const {
    const auto opening = in_the_end("facets", &CutLevel::opening);
    const auto tool = in_the_end("facets", &CutLevel::tool_stiffness);
    if (opening && tool)
        return {*opening, *tool, true};
    return {{runs.front().opening.back()}, {runs.front().tool_stiffness.back()}, false};
}

void write_cut(const std::filesystem::path &path, const CutFile &cut) {
    hdf5::write_record(path, cut, [](auto root, auto &record) { describe_cut(root, record); });
}

CutFile read_cut_file(const std::filesystem::path &path) {
    return hdf5::read_record<CutFile>(path, "livermark cut",
                                      [](auto root, auto &record) { describe_cut(root, record); });
}

Layout cut_table(const CutFile &file) {
    auto table = headed({}, {"blade at [mm]", "cut [cm^2]", "opening [mm]", "stored [mJ]", "released [mJ]",
                             "over area [J/m^2]", "left to the blade [mJ]", "tool [N/m]", "time of the cut [ms]"});
    const auto &run = file.runs.front();
    double by_blade = 0.0;
    for (std::size_t k = 0; k < file.num_records(); ++k) {
        if (k > 0)
            by_blade += std::max(0.0, file.tearing(k) - file.tearing(k - 1) - run.released(k) + run.released(k - 1));
        table.rows.push_back({fixed(millimetres * file.depth[k], 1), fixed(square_centimetres * file.area[k], 2),
                              fixed(millimetres * run.opening[k], 3), fixed(millijoules * run.stored[k], 3),
                              fixed(millijoules * run.released(k), 3), fixed(file.release_rate(run, k), 3),
                              fixed(millijoules * by_blade, 2), fixed(run.tool_stiffness[k], 2),
                              fixed(milliseconds * file.cut_seconds[k], 0)});
    }
    return table;
}

Layout cut_models_table(const CutFile &file) {
    auto table =
        headed({"model"}, {"opening [mm]", "off by [%]", "released [mJ]", "off by [%]", "over area [J/m^2]",
                           "tool [N/m]", "off by [%]", "cut to ready [ms]", "longest [ms]", "equilibrium [ms]"});
    const auto last = file.num_records() - 1;
    const auto judge = file.judge_in_the_end();
    const auto &on_mesh = file.runs.front();
    const auto bar = [](const ErrorBar &number) { return std::isnan(number.value) ? "-" : "+- " + percent_of(number); };
    if (judge.is_refined)
        table.rows.push_back({on_mesh.model + ", refined (reference)", fixed(millimetres * judge.opening.value, 3),
                              bar(judge.opening), "-", "-", "-", fixed(judge.tool_stiffness.value, 2),
                              bar(judge.tool_stiffness), "-", "-", "-"});
    for (const auto &run : file.runs) {
        const bool judges = !judge.is_refined && &run == &on_mesh;
        const auto off = [&](double value, double reference) {
            return judges ? "-" : fixed(difference_in_percent(value, reference), 1);
        };
        const auto ready = file.ready_seconds(run);
        // The finer meshes have no energy of the body before the cut, and two references are never in one table.
        table.rows.push_back({judges ? run.model + " (reference)" : run.model,
                              fixed(millimetres * run.opening[last], 3), off(run.opening[last], judge.opening.value),
                              fixed(millijoules * run.released(last), 3),
                              judge.is_refined ? "-" : off(run.released(last), on_mesh.released(last)),
                              fixed(run.released(last) / file.area[last], 3), fixed(run.tool_stiffness[last], 2),
                              off(run.tool_stiffness[last], judge.tool_stiffness.value),
                              fixed(milliseconds * middle_of(ready), 0), fixed(milliseconds * longest_of(ready), 0),
                              fixed(milliseconds * middle_of(file.equilibrium_seconds(run)), 0)});
    }
    return table;
}

std::string cut_judge_note(const CutFile &file) {
    const auto judge = file.judge_in_the_end();
    const auto &name = file.runs.front().model;
    if (!judge.is_refined)
        return fmt::format("Errors are against {} on the mesh of the models, which has no error bar.\n", name);
    const bool has_tool = !std::isnan(judge.tool_stiffness.value);
    return fmt::format("Errors are against {} on the finest mesh, which is uncertain by {} % in the opening{}.\n", name,
                       percent_of(judge.opening),
                       has_tool ? fmt::format(" and {} % at the tool", percent_of(judge.tool_stiffness)) : "");
}

Layout cut_levels_table(const CutFile &file) {
    hdf5::Cells cells;
    describe_finer_cuts(cells, file);
    return cells.table({"ways", "tetrahedra", "area", "depth", "opening", "tool_stiffness", "solve_seconds"});
}

std::string cut_levels_note(const CutFile &file) {
    std::string note;
    std::vector<std::string> ways;
    for (const auto &level : file.levels)
        if (std::ranges::find(ways, level.way) == ways.end())
            ways.push_back(level.way);
    for (const auto &way : ways) {
        const auto opening = file.in_the_end(way, &CutLevel::opening);
        const auto tool = file.in_the_end(way, &CutLevel::tool_stiffness);
        if (!opening || !tool)
            continue;
        const auto &coarsest = *std::ranges::find(file.levels, way, &CutLevel::way);
        const bool has_tool = !std::isnan(tool->value);
        note += fmt::format("{}: opening {} +- {} mm", way, fixed(millimetres * opening->value, 3),
                            fixed(millimetres * opening->error, 3));
        if (has_tool)
            note += fmt::format(", tool {} +- {} N/m", fixed(tool->value, 2), fixed(tool->error, 2));
        note += fmt::format("; on the coarsest of these meshes {} is off by {} %", file.runs.front().model,
                            fixed(difference_in_percent(coarsest.opening, opening->value), 1));
        if (has_tool)
            note += fmt::format(" and {} %", fixed(difference_in_percent(coarsest.tool_stiffness, tool->value), 1));
        note += ".\n";
    }
    return note;
}

Layout cut_steps_table(const CutFile &file) {
    auto table = headed({"springs"}, {"before [ms]", "cut along facets [ms]", "cut exactly [ms]"});
    for (const auto &run : file.runs)
        if (!run.critical_time_step.empty()) {
            auto &row = table.rows.emplace_back(std::vector<std::string>{run.model});
            for (const double step : run.critical_time_step)
                row.push_back(fixed(milliseconds * step, 3));
            row.resize(table.columns.size(), "-");
        }
    return table;
}

Layout cut_motions_table(const CutFile &file) {
    Layout table{{{"method"},
                  {"budget [ms]", true},
                  {"in time"},
                  {"steps x iterations", true},
                  {"opening [mm]", true},
                  {"off by [%]", true},
                  {"tool [N/m]", true},
                  {"off by [%]", true},
                  {"larger [%]", true},
                  {"is of"},
                  {"cut to next step [ms]", true},
                  {"longest [ms]", true},
                  {"frame [ms]", true},
                  {"worst frame [ms]", true}},
                 {}};
    const auto in_ms = [](double seconds) { return fixed(milliseconds * seconds, 2); };
    for (const auto &ranked : ranked_motions(file)) {
        const auto *motion = ranked.motion;
        std::vector<double> ready;
        std::ranges::copy_if(motion->ready_seconds, std::back_inserter(ready), [](double s) { return s > 0.0; });
        table.rows.push_back({motion->method, in_ms(motion->budget),
                              ranked.is_too_slow                             ? "too slow"
                              : motion->worst_frame_seconds > motion->budget ? "but for cuts"
                                                                             : "yes",
                              fmt::format("{} x {}", motion->steps, motion->iterations),
                              ranked.is_lost() ? "diverged" : fixed(millimetres * motion->opening.back(), 3),
                              fixed(ranked.opening, 1), fixed(motion->tool_stiffness.back(), 2), fixed(ranked.tool, 1),
                              fixed(ranked.larger(), 1), ranked.leads(), in_ms(middle_of(ready)),
                              in_ms(longest_of(ready)), in_ms(motion->frame_seconds),
                              in_ms(motion->worst_frame_seconds)});
    }
    return table;
}

std::string cut_note(const CutFile &file) {
    const auto &judge = file.runs.front();
    double largest = 0.0;
    std::size_t above = 0, cutting = 0;
    for (std::size_t k = 1; k < file.num_records(); ++k)
        if (const double rate = file.release_rate(judge, k); !std::isnan(rate)) {
            largest = std::max(largest, rate);
            above += rate > file.toughness ? 1 : 0;
            ++cutting;
        }
    return fmt::format(
        "Tearing takes {:g} J/m^2; {} of {} steps that cut something release more over their area, the most {:.3g} "
        "J/m^2. If a step releases more, the cut grows by itself; otherwise the blade does the rest of the work.\n",
        file.toughness, above, cutting, largest);
}

} // namespace livermark::results
