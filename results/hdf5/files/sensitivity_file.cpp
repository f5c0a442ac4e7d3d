#include "results/hdf5/files/sensitivity_file.hpp"

#include "results/hdf5/file_parts.hpp"

namespace livermark::results {

namespace {

template <class At> void describe_parameters(At at, hdf5::Of<At, std::vector<UncertainParameter>> &parameters) {
    auto columns = hdf5::columns_of(at, parameters);
    columns.texts("names", &UncertainParameter::name);
    columns.texts("unit_names", &UncertainParameter::unit);
    columns.texts("groups", &UncertainParameter::group);
    columns.texts("sources", &UncertainParameter::source);
    columns.column("lower", &UncertainParameter::lower);
    columns.column("upper", &UncertainParameter::upper);
    columns.column("is_logarithmic", &UncertainParameter::is_logarithmic);
    at.check(!parameters.empty(), "is empty");
}

/// Numbers have the unit of the output.
template <class At> void describe_outputs(At at, hdf5::Of<At, Sensitivity> &sensitivity, std::size_t num_outputs) {
    auto columns = hdf5::columns_of(at, sensitivity.outputs, num_outputs);
    columns.texts("names", &OutputSensitivity::name);
    columns.texts("unit_names", &OutputSensitivity::unit);
    columns.column("nominal", &OutputSensitivity::nominal);
    columns.column("mean", &OutputSensitivity::mean);
    columns.column("deviation", &OutputSensitivity::deviation);
    columns.column("lower", &OutputSensitivity::lower);
    columns.column("upper", &OutputSensitivity::upper);
    columns.column("unexplained", &OutputSensitivity::unexplained);
    const auto num_parameters = sensitivity.parameters.size();
    columns.blocks("first", &OutputSensitivity::first, num_parameters);
    columns.blocks("first_lower", &OutputSensitivity::first_lower, num_parameters);
    columns.blocks("first_upper", &OutputSensitivity::first_upper, num_parameters);
    columns.blocks("total", &OutputSensitivity::total, num_parameters);
    columns.blocks("total_lower", &OutputSensitivity::total_lower, num_parameters);
    columns.blocks("total_upper", &OutputSensitivity::total_upper, num_parameters);
    columns.blocks("group_total", &OutputSensitivity::group_total, sensitivity.groups.size());
}

template <class At> void describe_budget(At at, hdf5::Of<At, ErrorBudget> &budget, std::size_t num_outputs) {
    at.text("reference", budget.reference);
    auto models = hdf5::columns_of(at, budget.models);
    models.texts("models", &BudgetModel::name);
    at.rows("mesh", budget.mesh, "", num_outputs);
    at.rows("law", budget.law, "", num_outputs);
    at.rows("measurement", budget.measurement, "", num_outputs);
    models.blocks("error", &BudgetModel::error, num_outputs);
}

/// Points are drawn all at once, and solved one after the other: the file has those that are solved.
template <class At> void describe_samples(At at, hdf5::Of<At, Sensitivity> &sensitivity) {
    auto &values = sensitivity.values;
    std::int64_t num_outputs = values.empty() ? 0 : std::ssize(values.front());
    at.integer("num_outputs", num_outputs, 1);
    auto solved = sensitivity.points;
    solved.resize(values.size());
    at.matrix("points", solved, sensitivity.parameters.size());
    at.check(!solved.empty(), "is empty");
    at.matrix("values", values, static_cast<std::size_t>(num_outputs), "", solved.size());
    if constexpr (At::reads)
        sensitivity.points = std::move(solved);
}

template <class At> void describe_sensitivity(At root, hdf5::Of<At, Sensitivity> &sensitivity) {
    const auto at = root.group("sensitivity");
    at.text("body", sensitivity.body);
    at.text("load_case", sensitivity.load_case);
    at.text("title", sensitivity.title);
    at.text("model", sensitivity.model);
    at.text("fingerprint", sensitivity.fingerprint);
    at.texts("groups", sensitivity.groups);
    describe_parameters(at.group("parameters"), sensitivity.parameters);
    describe_samples(at.group("samples"), sensitivity);
    if (!at.has("outputs", !sensitivity.outputs.empty()))
        return;
    describe_outputs(at.group("outputs"), sensitivity, sensitivity.values.front().size());
    describe_budget(at.group("budget"), sensitivity.budget, sensitivity.outputs.size());
}

} // namespace

void write_sensitivity(const std::filesystem::path &path, const Sensitivity &sensitivity) {
    hdf5::write_record(path, sensitivity, [](auto root, auto &record) { describe_sensitivity(root, record); });
}

Sensitivity read_sensitivity(const std::filesystem::path &path) {
    return hdf5::read_record<Sensitivity>(path, "livermark sensitivity",
                                          [](auto root, auto &record) { describe_sensitivity(root, record); });
}

} // namespace livermark::results
