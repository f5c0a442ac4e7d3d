#include "studies/run/amplitudes.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/units.hpp"

namespace livermark::studies {

namespace {

using core::percent;

std::string suffix(double amplitude) {
    return fmt::format("@{:g}", amplitude);
}

/// What a model is called in the rows, and what it did at the amplitudes so far.
struct AmplitudeRow {
    std::vector<std::string> key; ///< body, load case, model
    std::vector<std::string> cells;
    double fair_up_to = 0.0; ///< amplitude
    bool is_fair = true;     ///< at all amplitudes so far
};

AmplitudeRow &find_row(std::vector<AmplitudeRow> &rows, std::vector<std::string> key, std::size_t num_columns) {
    const auto found = std::ranges::find(rows, key, &AmplitudeRow::key);
    return found != rows.end()
               ? *found
               : rows.emplace_back(AmplitudeRow{std::move(key), std::vector<std::string>(num_columns, "-")});
}

void enter(AmplitudeRow &row, const core::Solution &solution, std::size_t column, double amplitude) {
    const bool is_solved = solution.status == core::SolutionStatus::ok;
    row.cells[column] =
        is_solved ? results::fixed(percent * solution.nonlinearity, 2) : core::to_string(solution.status);
    row.is_fair = row.is_fair && is_solved && solution.nonlinearity < fair_nonlinearity;
    if (row.is_fair)
        row.fair_up_to = amplitude;
}

} // namespace

std::vector<core::Problem> at_amplitudes(const core::Problem &problem, std::span<const double> amplitudes) {
    if (amplitudes.empty())
        return {problem};
    std::vector<core::Problem> problems;
    for (const double amplitude : amplitudes) {
        problems.push_back({problem.body, core::scaled(problem.load_case, amplitude)});
        problems.back().load_case.name += suffix(amplitude);
    }
    return problems;
}

results::Layout nonlinearity_by_amplitude(std::span<const results::Result> results,
                                          std::span<const double> amplitudes) {
    results::Layout layout{{{"body"}, {"load case"}, {"model"}}, {}};
    for (const double amplitude : amplitudes)
        layout.columns.push_back({fmt::format("x {:g} [%]", amplitude), true});
    layout.columns.push_back({fmt::format("below {:g} % up to", percent * fair_nonlinearity), true});
    std::vector<AmplitudeRow> rows;
    for (std::size_t column = 0; column < amplitudes.size(); ++column)
        for (const auto &result : results) {
            const auto &name = result.problem.load_case.name;
            const auto end = suffix(amplitudes[column]);
            if (!name.ends_with(end))
                continue;
            for (const auto &model : result.models)
                if (model.solution.springs || !std::isnan(model.solution.nonlinearity))
                    enter(find_row(rows,
                                   {result.problem.body->name, name.substr(0, name.size() - end.size()), model.name},
                                   amplitudes.size()),
                          model.solution, column, amplitudes[column]);
        }
    for (auto &row : rows) {
        layout.rows.push_back(std::move(row.key));
        layout.rows.back().insert(layout.rows.back().end(), row.cells.begin(), row.cells.end());
        layout.rows.back().push_back(row.fair_up_to > 0.0 ? fmt::format("x {:g}", row.fair_up_to) : "none");
    }
    return layout;
}

} // namespace livermark::studies
