#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <sstream>
#include <toml++/toml.h>

#include "core/units.hpp"
#include "studies/sensitivity/sensitivity.hpp"

namespace livermark::studies {

namespace {

/// An error is small, or large, beside an uncertainty that many times larger, or smaller.
constexpr double clearly = 3.0;

std::string words_of(const std::string &name) {
    if (name == "stiffness_at_tool")
        return "the stiffness at the tool";
    return name == "tumour_displacement" ? "the place of the tumour" : "the peak displacement";
}

/// The parameter that most of the variance is due to, alone.
int leading_parameter(const results::OutputSensitivity &output) {
    return static_cast<int>(std::ranges::max_element(output.first) - output.first.begin());
}

toml::array json_numbers(const std::vector<double> &values) {
    toml::array array;
    for (const double value : values)
        array.push_back(value);
    return array;
}

/// A number for each output by its name; what is unknown is left out, because JSON has no NaN.
toml::table by_output(const results::Sensitivity &sensitivity, const std::vector<double> &values) {
    toml::table table;
    for (std::size_t o = 0; o < values.size(); ++o)
        if (std::isfinite(values[o]))
            table.insert(sensitivity.outputs[o].name, values[o]);
    return table;
}

toml::table json_of_output(const results::OutputSensitivity &output) {
    return toml::table{{"name", output.name},
                       {"unit", output.unit},
                       {"nominal", output.nominal},
                       {"mean", output.mean},
                       {"deviation", output.deviation},
                       {"lower", output.lower},
                       {"upper", output.upper},
                       {"unexplained", output.unexplained},
                       {"first", json_numbers(output.first)},
                       {"first_lower", json_numbers(output.first_lower)},
                       {"first_upper", json_numbers(output.first_upper)},
                       {"total", json_numbers(output.total)},
                       {"total_lower", json_numbers(output.total_lower)},
                       {"total_upper", json_numbers(output.total_upper)},
                       {"group_total", json_numbers(output.group_total)}};
}

toml::table json_of_study(const results::Sensitivity &sensitivity) {
    toml::array parameters, groups, outputs, models, verdicts;
    for (const auto &parameter : sensitivity.parameters)
        parameters.push_back(toml::table{{"name", parameter.name},
                                         {"unit", parameter.unit},
                                         {"group", parameter.group},
                                         {"lower", parameter.lower},
                                         {"upper", parameter.upper},
                                         {"logarithmic", parameter.is_logarithmic},
                                         {"source", parameter.source}});
    for (const auto &group : sensitivity.groups)
        groups.push_back(group);
    for (std::size_t o = 0; o < sensitivity.outputs.size(); ++o) {
        outputs.push_back(json_of_output(sensitivity.outputs[o]));
        verdicts.push_back(verdict(sensitivity, o));
    }
    for (const auto &model : sensitivity.budget.models)
        models.push_back(toml::table{{"name", model.name}, {"error", by_output(sensitivity, model.error)}});
    return toml::table{{"body", sensitivity.body},
                       {"load_case", sensitivity.load_case},
                       {"model", sensitivity.model},
                       {"samples", static_cast<std::int64_t>(sensitivity.values.size())},
                       {"parameters", std::move(parameters)},
                       {"groups", std::move(groups)},
                       {"outputs", std::move(outputs)},
                       {"budget", toml::table{{"reference", sensitivity.budget.reference},
                                              {"mesh", by_output(sensitivity, sensitivity.budget.mesh)},
                                              {"law", by_output(sensitivity, sensitivity.budget.law)},
                                              {"measurement", by_output(sensitivity, sensitivity.budget.measurement)},
                                              {"models", std::move(models)}}},
                       {"verdicts", std::move(verdicts)}};
}

} // namespace

std::string verdict(const results::Sensitivity &sensitivity, std::size_t output) {
    const auto &of_output = sensitivity.outputs[output];
    const double patient = of_output.relative_deviation();
    const int leading = leading_parameter(of_output);
    const double rest = of_output.relative_deviation(leading);
    const auto of_patient = fmt::format(
        "not knowing the patient makes {:.1f} % of {} uncertain, and {:.1f} % if {} were known",
        core::percent * patient, words_of(of_output.name), core::percent * rest, sensitivity.parameters[leading].name);
    const auto &model = sensitivity.budget.models.front();
    const double error = std::abs(model.error[output]);
    if (!std::isfinite(error))
        return fmt::format("{} / {}: {}; {} has no answer to compare.", sensitivity.body, sensitivity.load_case,
                           of_patient, model.name);
    const auto size_beside = [&](double uncertainty) {
        return clearly * error <= uncertainty ? "small" : error >= clearly * uncertainty ? "large" : "of the same size";
    };
    const std::string beside_all = size_beside(patient), beside_rest = size_beside(rest);
    const auto judged = beside_all == beside_rest
                            ? beside_all + " beside both"
                            : fmt::format("{} beside the first and {} beside the second", beside_all, beside_rest);
    return fmt::format("{} / {}: {}; {} is off by {:.1f} %, which is {}.", sensitivity.body, sensitivity.load_case,
                       of_patient, model.name, core::percent * error, judged);
}

std::string to_json(const std::vector<results::Sensitivity> &of_load_case) {
    toml::array all;
    for (const auto &sensitivity : of_load_case)
        all.push_back(json_of_study(sensitivity));
    std::ostringstream stream;
    stream << toml::json_formatter(toml::table{{"load_cases", std::move(all)}});
    return stream.str();
}

} // namespace livermark::studies
