#include "results/records/cut.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "core/error_norms.hpp"
#include "core/units.hpp"
#include "results/hdf5/record_file.hpp"

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
    at.group("models", hdf5::Order::kept).each(cut.runs, &CutRun::model, [&](auto group, auto &run) {
        describe_cut_run(group, run, num_records);
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

/// NaN of none, as the next.
double middle_of(std::vector<double> values) {
    if (values.empty())
        return not_known;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double longest_of(const std::vector<double> &values) {
    return values.empty() ? not_known : *std::ranges::max_element(values);
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
    std::string in_time() const {
        return is_too_slow ? "too slow" : motion->worst_frame_seconds > motion->budget ? "but for cuts" : "yes";
    }
    std::vector<double> ready_seconds() const {
        auto seconds = motion->ready_seconds;
        std::erase_if(seconds, [](double time) { return !(time > 0.0); });
        return seconds;
    }

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
        return not_known;
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
    const auto &run = file.runs.front();
    std::vector<double> by_blade{0.0};
    for (std::size_t k = 1; k < file.num_records(); ++k)
        by_blade.push_back(by_blade.back() + std::max(0.0, file.tearing(k) - file.tearing(k - 1) - run.released(k) +
                                                               run.released(k - 1)));
    const auto at_record = [](const std::vector<double> &values) {
        return [&values](std::size_t k) { return values[k]; };
    };
    std::vector<std::size_t> records(file.num_records());
    std::iota(records.begin(), records.end(), 0);
    TableOf<std::size_t> table(std::move(records));
    table.number("blade at [mm]", at_record(file.depth), millimetres, 1);
    table.number("cut [cm^2]", at_record(file.area), square_centimetres, 2);
    table.number("opening [mm]", at_record(run.opening), millimetres, 3);
    table.number("stored [mJ]", at_record(run.stored), millijoules, 3);
    const auto released = [&](std::size_t k) { return run.released(k); };
    table.number("released [mJ]", released, millijoules, 3);
    table.number("over area [J/m^2]", [&](std::size_t k) { return fixed(file.release_rate(run, k), 3); });
    table.number("left to the blade [mJ]", at_record(by_blade), millijoules, 2);
    table.number("tool [N/m]", at_record(run.tool_stiffness), 1.0, 2);
    table.number("time of the cut [ms]", at_record(file.cut_seconds), milliseconds, 0);
    return table.layout();
}

Layout cut_models_table(const CutFile &file) {
    const auto last = file.num_records() - 1;
    const auto judge = file.judge_in_the_end();
    const auto &on_mesh = file.runs.front();
    const auto bar = [](const ErrorBar &number) { return std::isnan(number.value) ? "-" : "+- " + percent_of(number); };
    const auto judges = [&](auto &run) { return !judge.is_refined && &run == &on_mesh; };
    const auto off = [&](const CutRun &run, double value, double reference) {
        return judges(run) ? "-" : fixed(difference_in_percent(value, reference), 1);
    };
    /// Cells of the models, and one of the refined reference.
    const auto cells = [](auto cell, const std::string &refined = "-") {
        return [=](const CutRun *run) { return run ? cell(*run) : refined; };
    };
    std::vector<const CutRun *> rows(judge.is_refined ? 1 : 0, nullptr);
    for (const auto &run : file.runs)
        rows.push_back(&run);
    TableOf<const CutRun *> table(std::move(rows));
    table.text("model", cells([&](auto &run) { return run.model + (judges(run) ? " (reference)" : ""); },
                              on_mesh.model + ", refined (reference)"));
    table.number("opening [mm]", cells([&](auto &run) { return fixed(millimetres * run.opening[last], 3); },
                                       fixed(millimetres * judge.opening.value, 3)));
    table.number("off by [%]", cells([&](auto &run) { return off(run, run.opening[last], judge.opening.value); },
                                     bar(judge.opening)));
    table.number("released [mJ]", cells([&](auto &run) { return fixed(millijoules * run.released(last), 3); }));
    // The finer meshes have no energy of the body before the cut, and two references are never in one table.
    table.number("off by [%]", cells([&](auto &run) {
                     return judge.is_refined ? "-" : off(run, run.released(last), on_mesh.released(last));
                 }));
    table.number("over area [J/m^2]", cells([&](auto &run) { return fixed(run.released(last) / file.area[last], 3); }));
    table.number("tool [N/m]", cells([&](auto &run) { return fixed(run.tool_stiffness[last], 2); },
                                     fixed(judge.tool_stiffness.value, 2)));
    table.number("off by [%]",
                 cells([&](auto &run) { return off(run, run.tool_stiffness[last], judge.tool_stiffness.value); },
                       bar(judge.tool_stiffness)));
    const auto in_ms = [](double seconds) { return fixed(milliseconds * seconds, 0); };
    table.number("cut to ready [ms]", cells([&](auto &run) { return in_ms(middle_of(file.ready_seconds(run))); }));
    table.number("longest [ms]", cells([&](auto &run) { return in_ms(longest_of(file.ready_seconds(run))); }));
    table.number("equilibrium [ms]", cells([&](auto &run) { return in_ms(middle_of(file.equilibrium_seconds(run))); }));
    return table.layout();
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
    std::vector<CutRun> springs;
    std::ranges::copy_if(file.runs, std::back_inserter(springs),
                         [](auto &run) { return !run.critical_time_step.empty(); });
    const auto step = [](std::size_t number) {
        return [=](auto &run) {
            const auto &steps = run.critical_time_step;
            return number < steps.size() ? fixed(milliseconds * steps[number], 3) : "-";
        };
    };
    TableOf<CutRun> table(std::move(springs));
    table.text("springs", &CutRun::model);
    table.number("before [ms]", step(0));
    table.number("cut along facets [ms]", step(1));
    table.number("cut exactly [ms]", step(2));
    return table.layout();
}

Layout cut_motions_table(const CutFile &file) {
    using Row = RankedMotion;
    const auto seconds = [](double CutMotion::*value) { return [=](auto &row) { return row.motion->*value; }; };
    TableOf<Row> table(ranked_motions(file));
    table.text("method", [](auto &row) { return row.motion->method; });
    table.number("budget [ms]", seconds(&CutMotion::budget), milliseconds, 2);
    table.text("in time", &Row::in_time);
    table.number("steps x iterations",
                 [](auto &row) { return fmt::format("{} x {}", row.motion->steps, row.motion->iterations); });
    table.number("opening [mm]", [](auto &row) {
        return row.is_lost() ? "diverged" : fixed(millimetres * row.motion->opening.back(), 3);
    });
    table.number("off by [%]", &Row::opening, 1.0, 1);
    table.number("tool [N/m]", [](auto &row) { return fixed(row.motion->tool_stiffness.back(), 2); });
    table.number("off by [%]", &Row::tool, 1.0, 1);
    table.number("larger [%]", &Row::larger, 1.0, 1);
    table.text("is of", &Row::leads);
    const auto middle = [](auto &row) { return middle_of(row.ready_seconds()); };
    table.number("cut to next step [ms]", middle, milliseconds, 2);
    const auto longest = [](auto &row) { return longest_of(row.ready_seconds()); };
    table.number("longest [ms]", longest, milliseconds, 2);
    table.number("frame [ms]", seconds(&CutMotion::frame_seconds), milliseconds, 2);
    table.number("worst frame [ms]", seconds(&CutMotion::worst_frame_seconds), milliseconds, 2);
    return table.layout();
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
