#include "results/hdf5/files/sensitivity_file.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>

#include "results/hdf5/file_parts.hpp"
#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/read_apart.hpp"
#include "support/whole_file.hpp"

namespace livermark::results {

namespace {

using hdf5::InputFile;
using hdf5::OutputFile;

constexpr const char *sensitivity_group = "/sensitivity", *parameters_group = "/sensitivity/parameters",
                     *samples_group = "/sensitivity/samples", *outputs_group = "/sensitivity/outputs",
                     *budget_group = "/sensitivity/budget";

std::string in_group(const char *group, const char *name) {
    return fmt::format("{}/{}", group, name);
}

/// Calls for each number of an output with its name and the member; these have the unit of the output.
template <class Visit> void for_each_number_of_output(Visit visit) {
    visit("nominal", &OutputSensitivity::nominal);
    visit("mean", &OutputSensitivity::mean);
    visit("deviation", &OutputSensitivity::deviation);
    visit("lower", &OutputSensitivity::lower);
    visit("upper", &OutputSensitivity::upper);
    visit("unexplained", &OutputSensitivity::unexplained);
}

/// The same for each row of indices, with one for each parameter.
template <class Visit> void for_each_index(Visit visit) {
    visit("first", &OutputSensitivity::first);
    visit("first_lower", &OutputSensitivity::first_lower);
    visit("first_upper", &OutputSensitivity::first_upper);
    visit("total", &OutputSensitivity::total);
    visit("total_lower", &OutputSensitivity::total_lower);
    visit("total_upper", &OutputSensitivity::total_upper);
}

template <class Row, class Value> auto column_of(const std::vector<Row> &rows, Value Row::*member) {
    std::vector<Value> column;
    std::ranges::transform(rows, std::back_inserter(column), member);
    return column;
}

/// Rows of a matrix, one behind the other.
std::vector<double> flat(const std::vector<std::vector<double>> &rows) {
    std::vector<double> all;
    for (const auto &row : rows)
        all.insert(all.end(), row.begin(), row.end());
    return all;
}

std::vector<std::vector<double>> rows_of_size(const std::vector<double> &all, std::size_t columns) {
    std::vector<std::vector<double>> rows;
    for (auto from = all.begin(); from != all.end(); from += static_cast<std::ptrdiff_t>(columns))
        rows.emplace_back(from, from + static_cast<std::ptrdiff_t>(columns));
    return rows;
}

void write_parameters(OutputFile &file, const std::vector<UncertainParameter> &parameters) {
    file.group(parameters_group);
    file.texts(parameters_group, "names", column_of(parameters, &UncertainParameter::name));
    file.texts(parameters_group, "unit_names", column_of(parameters, &UncertainParameter::unit));
    file.texts(parameters_group, "groups", column_of(parameters, &UncertainParameter::group));
    file.texts(parameters_group, "sources", column_of(parameters, &UncertainParameter::source));
    file.dataset(in_group(parameters_group, "lower"), column_of(parameters, &UncertainParameter::lower), "");
    file.dataset(in_group(parameters_group, "upper"), column_of(parameters, &UncertainParameter::upper), "");
    std::vector<std::uint8_t> is_logarithmic;
    for (const auto &parameter : parameters)
        is_logarithmic.push_back(parameter.is_logarithmic ? 1 : 0);
    file.dataset(in_group(parameters_group, "is_logarithmic"), is_logarithmic, "");
}

void write_outputs(OutputFile &file, const Sensitivity &sensitivity) {
    const auto &outputs = sensitivity.outputs;
    file.group(outputs_group);
    file.texts(outputs_group, "names", column_of(outputs, &OutputSensitivity::name));
    file.texts(outputs_group, "unit_names", column_of(outputs, &OutputSensitivity::unit));
    for_each_number_of_output([&](const char *name, auto member) {
        file.dataset(in_group(outputs_group, name), column_of(outputs, member), "");
    });
    for_each_index([&](const char *name, auto member) {
        file.blocks(in_group(outputs_group, name), flat(column_of(outputs, member)), sensitivity.parameters.size(), "");
    });
    file.blocks(in_group(outputs_group, "group_total"), flat(column_of(outputs, &OutputSensitivity::group_total)),
                sensitivity.groups.size(), "");
}

void write_budget(OutputFile &file, const ErrorBudget &budget, std::size_t num_outputs) {
    file.group(budget_group);
    file.text(budget_group, "reference", budget.reference);
    file.texts(budget_group, "models", column_of(budget.models, &BudgetModel::name));
    file.dataset(in_group(budget_group, "mesh"), budget.mesh, "");
    file.dataset(in_group(budget_group, "law"), budget.law, "");
    file.dataset(in_group(budget_group, "measurement"), budget.measurement, "");
    file.blocks(in_group(budget_group, "error"), flat(column_of(budget.models, &BudgetModel::error)), num_outputs, "");
}

} // namespace

void write_sensitivity(const std::filesystem::path &path, const Sensitivity &sensitivity) {
    OutputFile file;
    hdf5::write_provenance(file, sensitivity.provenance);
    file.group(sensitivity_group);
    file.text(sensitivity_group, "body", sensitivity.body);
    file.text(sensitivity_group, "load_case", sensitivity.load_case);
    file.text(sensitivity_group, "title", sensitivity.title);
    file.text(sensitivity_group, "model", sensitivity.model);
    file.text(sensitivity_group, "fingerprint", sensitivity.fingerprint);
    file.texts(sensitivity_group, "groups", sensitivity.groups);
    write_parameters(file, sensitivity.parameters);
    file.group(samples_group);
    file.integer(samples_group, "num_outputs", std::ssize(sensitivity.values.front()));
    const auto num_solved = static_cast<std::ptrdiff_t>(sensitivity.values.size());
    const std::vector solved(sensitivity.points.begin(), sensitivity.points.begin() + num_solved);
    file.blocks(in_group(samples_group, "points"), flat(solved), sensitivity.parameters.size(), "");
    file.blocks(in_group(samples_group, "values"), flat(sensitivity.values), sensitivity.values.front().size(), "");
    if (!sensitivity.outputs.empty()) {
        write_outputs(file, sensitivity);
        write_budget(file, sensitivity.budget, sensitivity.outputs.size());
    }
    support::write_whole(path, file.image());
}

namespace {

std::vector<UncertainParameter> read_parameters(const InputFile &file) {
    const auto names = file.texts(parameters_group, "names"), units = file.texts(parameters_group, "unit_names"),
               groups = file.texts(parameters_group, "groups"), sources = file.texts(parameters_group, "sources");
    const auto count = names.size();
    if (count == 0 || units.size() != count || groups.size() != count || sources.size() != count)
        file.refuse(parameters_group, "has not as many units, groups and sources as names");
    const auto lower = file.dataset<double>(in_group(parameters_group, "lower"), count);
    const auto upper = file.dataset<double>(in_group(parameters_group, "upper"), count);
    const auto is_logarithmic = file.dataset<std::uint8_t>(in_group(parameters_group, "is_logarithmic"), count);
    std::vector<UncertainParameter> parameters;
    for (std::size_t p = 0; p < count; ++p)
        parameters.push_back({names[p], units[p], groups[p], lower[p], upper[p], is_logarithmic[p] != 0, sources[p]});
    return parameters;
}

void read_outputs(const InputFile &file, Sensitivity &sensitivity) {
    const auto names = file.texts(outputs_group, "names"), units = file.texts(outputs_group, "unit_names");
    const auto count = names.size(), num_parameters = sensitivity.parameters.size();
    if (count == 0 || units.size() != count || sensitivity.values.front().size() != count)
        file.refuse(outputs_group, "has not as many names and units as a sample has values");
    for (std::size_t o = 0; o < count; ++o)
        sensitivity.outputs.push_back({.name = names[o], .unit = units[o]});
    for_each_number_of_output([&](const char *name, auto member) {
        const auto values = file.dataset<double>(in_group(outputs_group, name), count);
        for (std::size_t o = 0; o < count; ++o)
            sensitivity.outputs[o].*member = values[o];
    });
    const auto read_rows = [&](const char *name, std::size_t columns, auto member) {
        const auto rows = rows_of_size(file.blocks<double>(in_group(outputs_group, name), count, columns), columns);
        for (std::size_t o = 0; o < count; ++o)
            sensitivity.outputs[o].*member = rows[o];
    };
    for_each_index([&](const char *name, auto member) { read_rows(name, num_parameters, member); });
    read_rows("group_total", sensitivity.groups.size(), &OutputSensitivity::group_total);
}

ErrorBudget read_budget(const InputFile &file, std::size_t num_outputs) {
    ErrorBudget budget{.reference = file.text(budget_group, "reference"),
                       .mesh = file.dataset<double>(in_group(budget_group, "mesh"), num_outputs),
                       .law = file.dataset<double>(in_group(budget_group, "law"), num_outputs),
                       .measurement = file.dataset<double>(in_group(budget_group, "measurement"), num_outputs),
                       .models = {}};
    const auto names = file.texts(budget_group, "models");
    const auto rows =
        rows_of_size(file.blocks<double>(in_group(budget_group, "error"), names.size(), num_outputs), num_outputs);
    for (std::size_t m = 0; m < names.size(); ++m)
        budget.models.push_back({names[m], rows[m]});
    return budget;
}

Sensitivity sensitivity_in(const std::filesystem::path &path) {
    const InputFile file(path, "livermark sensitivity");
    hdf5::check_schema(file);
    Sensitivity sensitivity{.provenance = hdf5::read_provenance(file),
                            .body = file.text(sensitivity_group, "body"),
                            .load_case = file.text(sensitivity_group, "load_case"),
                            .title = file.text(sensitivity_group, "title"),
                            .model = file.text(sensitivity_group, "model"),
                            .fingerprint = file.text(sensitivity_group, "fingerprint"),
                            .parameters = read_parameters(file),
                            .groups = file.texts(sensitivity_group, "groups"),
                            .points = {},
                            .values = {},
                            .outputs = {},
                            .budget = {}};
    const auto num_parameters = sensitivity.parameters.size();
    sensitivity.points =
        rows_of_size(file.blocks<double>(in_group(samples_group, "points"), num_parameters), num_parameters);
    const auto num_outputs = file.integer(samples_group, "num_outputs");
    if (sensitivity.points.empty() || num_outputs < 1)
        file.refuse(samples_group, "is empty");
    const auto columns = static_cast<std::size_t>(num_outputs);
    sensitivity.values = rows_of_size(
        file.blocks<double>(in_group(samples_group, "values"), sensitivity.points.size(), columns), columns);
    if (file.has(outputs_group)) {
        read_outputs(file, sensitivity);
        sensitivity.budget = read_budget(file, sensitivity.outputs.size());
    }
    return sensitivity;
}

} // namespace

Sensitivity read_sensitivity(const std::filesystem::path &path) {
    return hdf5::read_once_tried(path, [&] { return sensitivity_in(path); });
}

} // namespace livermark::results
