#include "results/tables/studies/experiment_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

#include "core/units.hpp"

namespace livermark::results {

namespace {

std::string in_mm(double length, int decimals = 2) {
    return std::isfinite(length) ? fixed(core::millimetres * length, decimals) : "-";
}

std::string cell_of(const ExperimentRun &run) {
    const auto error = in_mm(run.error);
    return run.status == core::SolutionStatus::ok ? error : fmt::format("{} ({})", error, core::to_string(run.status));
}

/// The runs of a model on a mesh, by state.
struct ExperimentRow {
    std::string model;
    int tetrahedra = 0;
    std::vector<const ExperimentRun *> runs;

    /// The larger the worse, with those last that have no solution somewhere.
    double mean_error() const {
        double sum = 0.0;
        for (const auto *run : runs)
            sum += run->status == core::SolutionStatus::ok && std::isfinite(run->error) ? run->error : HUGE_VAL;
        return sum;
    }
};

std::vector<ExperimentRow> rows_of(const ExperimentResult &result) {
    std::vector<ExperimentRow> rows;
    for (const auto &run : result.runs) {
        if (rows.empty() || rows.back().model != run.model || rows.back().tetrahedra != run.tetrahedra)
            rows.push_back({run.model, run.tetrahedra, {}});
        rows.back().runs.push_back(&run);
    }
    std::ranges::stable_sort(rows, {}, &ExperimentRow::mean_error);
    return rows;
}

} // namespace

Layout experiment_table(const ExperimentResult &result) {
    Layout layout{{{"error [mm]", false}, {"tetrahedra", true}}, {}};
    for (const auto &state : result.states)
        layout.columns.push_back({state.name, true});
    layout.columns.push_back({"time [s]", true});
    const auto add = [&](const std::string &what, auto value) {
        std::vector<std::string> row{what, ""};
        for (const auto &state : result.states)
            row.push_back(value(state));
        row.emplace_back("");
        layout.rows.push_back(std::move(row));
    };
    add("noise of the measurement", [](const ExperimentState &s) { return s.noise > 0.0 ? in_mm(s.noise) : "-"; });
    add("no motion", [](const ExperimentState &s) { return in_mm(s.no_motion); });
    add("rigid motion, fitted", [](const ExperimentState &s) { return in_mm(s.rigid_motion); });
    const auto has = [&](auto member) {
        return std::ranges::any_of(result.states, [&](const auto &s) { return std::isfinite(s.*member); });
    };
    if (has(&ExperimentState::straight_line)) {
        add("straight line", [](const ExperimentState &s) { return in_mm(s.straight_line); });
        add("driven places off their markers", [](const ExperimentState &s) { return in_mm(s.fit_residual); });
    }
    add("reference, uncertainty of its mesh",
        [](const ExperimentState &s) { return in_mm(s.reference_uncertainty, 3); });
    for (const auto &of_model : rows_of(result)) {
        std::vector<std::string> row{of_model.model, fmt::format("{}", of_model.tetrahedra)};
        double seconds = 0.0;
        for (const auto *run : of_model.runs) {
            row.push_back(cell_of(*run));
            seconds += run->seconds;
        }
        row.push_back(fixed(seconds, 1));
        layout.rows.push_back(std::move(row));
    }
    return layout;
}

} // namespace livermark::results
