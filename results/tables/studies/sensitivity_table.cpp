#include "results/tables/studies/sensitivity_table.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/units.hpp"

namespace livermark::results {

namespace {

/// A value as people read it.
std::string value_cell(double value, const std::string &unit) {
    return unit == "m" ? fixed(core::millimetres * value, 3) : significant(value, 4);
}

std::string named(const OutputSensitivity &output) {
    return fmt::format("{} [{}]", output.name, output.unit == "m" ? "mm" : output.unit);
}

std::string percent_cell(double part) {
    return fixed(core::percent * part, 1);
}

std::string signed_percent_cell(double part) {
    return std::isfinite(part) ? fmt::format("{:+.1f}", core::percent * part) : "-";
}

std::string index_cell(double value, double lower, double upper) {
    return fmt::format("{} [{}, {}]", fixed(value, 3), fixed(lower, 3), fixed(upper, 3));
}

std::string range_cell(const UncertainParameter &parameter) {
    const bool is_length = parameter.unit == "m";
    const double scale = is_length ? core::millimetres : 1.0;
    const auto unit = is_length ? "mm" : parameter.unit;
    return fmt::format("{:g} to {:g}{}{}{}", scale * parameter.lower, scale * parameter.upper, unit.empty() ? "" : " ",
                       unit, parameter.is_logarithmic ? ", logarithmic" : "");
}

} // namespace

Layout output_table(const Sensitivity &sensitivity) {
    Layout layout{{{"output"},
                   {"as the files say", true},
                   {"mean", true},
                   {"deviation", true},
                   {"95 % from", true},
                   {"to", true},
                   {"not explained [%]", true}},
                  {}};
    for (const auto &output : sensitivity.outputs) {
        const auto cell = [&](double value) { return value_cell(value, output.unit); };
        layout.rows.push_back({named(output), cell(output.nominal), cell(output.mean), cell(output.deviation),
                               cell(output.lower), cell(output.upper), percent_cell(output.unexplained)});
    }
    return layout;
}

Layout index_table(const Sensitivity &sensitivity) {
    Layout layout{{{"parameter"}, {"range"}}, {}};
    for (const auto &output : sensitivity.outputs) {
        layout.columns.push_back({output.name + ": first", true});
        layout.columns.push_back({"total", true});
    }
    for (std::size_t p = 0; p < sensitivity.parameters.size(); ++p) {
        std::vector<std::string> row{sensitivity.parameters[p].name, range_cell(sensitivity.parameters[p])};
        for (const auto &output : sensitivity.outputs) {
            row.push_back(index_cell(output.first[p], output.first_lower[p], output.first_upper[p]));
            row.push_back(index_cell(output.total[p], output.total_lower[p], output.total_upper[p]));
        }
        layout.rows.push_back(std::move(row));
    }
    return layout;
}

Layout budget_table(const Sensitivity &sensitivity) {
    const auto &budget = sensitivity.budget;
    Layout layout{{{"load case"}, {"output"}, {"mesh", true}}, {}};
    for (const auto &model : budget.models)
        layout.columns.push_back({model.name, true});
    layout.columns.push_back({"law, large", true});
    layout.columns.push_back({"measurement", true});
    for (const auto &group : sensitivity.groups)
        layout.columns.push_back({group, true});
    layout.columns.push_back({"patient", true});
    layout.columns.push_back({"leading parameter known", true});
    for (std::size_t o = 0; o < sensitivity.outputs.size(); ++o) {
        const auto &output = sensitivity.outputs[o];
        std::vector<std::string> row{sensitivity.load_case, output.name, percent_cell(budget.mesh[o])};
        for (const auto &model : budget.models)
            row.push_back(signed_percent_cell(model.error[o]));
        row.push_back(signed_percent_cell(budget.law[o]));
        row.push_back(percent_cell(budget.measurement[o]));
        for (std::size_t g = 0; g < sensitivity.groups.size(); ++g)
            row.push_back(percent_cell(output.relative_deviation_of_group(g)));
        const auto leading = std::ranges::max_element(output.first) - output.first.begin();
        row.push_back(percent_cell(output.relative_deviation()));
        row.push_back(fmt::format("{} ({})", percent_cell(output.relative_deviation(static_cast<int>(leading))),
                                  sensitivity.parameters[leading].name));
        layout.rows.push_back(std::move(row));
    }
    return layout;
}

} // namespace livermark::results
