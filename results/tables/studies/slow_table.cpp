#include "results/tables/studies/slow_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vector>

#include "core/tool/slow_response.hpp"
#include "core/units.hpp"
#include "results/tables/overview.hpp"

namespace livermark::results {

namespace {

constexpr double millijoules = 1e3;
/// Below this part of the largest response of a tool, the one at first is rounding.
constexpr double smallest_response = 1e-6;

std::string percent_cell(double value, int decimals) {
    return std::isnan(value) ? "-" : fixed(core::percent * value, decimals);
}

/// The record at which the whole load is first there.
std::size_t first_whole_load(const core::SlowHistory &history) {
    return static_cast<std::size_t>(std::ranges::max_element(history.factors) - history.factors.begin());
}

std::vector<std::string> slow_row(const ModelResult &model, const Result &result, const core::SlowResponse &response,
                                  const std::string &body) {
    const auto &load_case = result.problem.load_case;
    const auto &history = *load_case.slow_history;
    const bool is_reference = std::ranges::any_of(result.models, [&](const ModelResult &other) {
        return other.comparison && other.comparison->reference == model.name;
    });
    std::vector<std::string> row{body, load_case.name, is_reference ? model.name + " (reference)" : model.name,
                                 response.place};
    if (response.values.size() == history.times.size()) {
        const double unit = response.is_force ? 1.0 : core::millimetres;
        const double first = response.values[first_whole_load(history)];
        const double largest =
            std::abs(*std::ranges::max_element(response.values, {}, [](double value) { return std::abs(value); }));
        const double last = response.values[static_cast<std::size_t>(history.whole_load_record())];
        row.push_back(significant(unit * first, 4) + (response.is_force ? " N" : " mm"));
        row.push_back(significant(unit * last, 4) + (response.is_force ? " N" : " mm"));
        row.push_back(std::abs(first) > smallest_response * largest ? percent_cell(last / first, 1) : "-");
    } else {
        row.insert(row.end(), 3, "-");
    }
    const auto *slow = model.comparison && model.comparison->slow ? &*model.comparison->slow : nullptr;
    row.push_back(slow ? percent_cell(slow->median_error, 2) : "-");
    row.push_back(slow ? percent_cell(slow->worst_error, 2) : "-");
    const double lost = core::lost_energy(history, model.solution);
    row.push_back(std::isnan(lost) ? "-" : significant(millijoules * lost, 4));
    row.push_back(slow ? percent_cell(slow->lost_energy, 1) : "-");
    row.push_back(fixed(model.solution.setup_seconds + model.solution.solve_seconds, 1));
    row.emplace_back(core::to_string(model.solution.status));
    return row;
}

} // namespace

Layout slow_table(std::span<const Result> results) {
    Layout layout{{{"body"}, {"load case"}, {"model"}, {"tool"}}, {}};
    for (const auto *title : {"at first", "at last", "left [%]", "median error [%]", "worst error [%]", "heat [mJ]",
                              "its error [%]", "time [s]"})
        layout.columns.push_back({title, true});
    layout.columns.push_back({"status"});
    for (const auto &result : results)
        if (result.problem.load_case.slow_history)
            for (const auto &model : result.models)
                for (const auto &response :
                     core::slow_responses(result.problem.body->mesh, result.problem.load_case, model.solution))
                    layout.rows.push_back(slow_row(model, result, response, body_label(result, results)));
    return layout;
}

std::string slow_legend() {
    return "at first, at last: force of the tool along its way when the whole load is first there, and when it is last "
           "there (of a given traction: the displacement along it); left: the last of the first; errors: of that force "
           "at each time from that of the reference, over its largest, median and largest over the times; heat: energy "
           "that the body turns into heat in the last cycle, the work done less what is stored more at its end\n";
}

} // namespace livermark::results
