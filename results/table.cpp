#include "results/table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <vector>

namespace livermark::results {

namespace {

struct Column {
    const char *title;
    bool is_number;
};

constexpr std::array<Column, 15> columns{{{"body", false},
                                          {"load case", false},
                                          {"model", false},
                                          {"peak [mm]", true},
                                          {"L2 [%]", true},
                                          {"+- [%]", true},
                                          {"max [mm]", true},
                                          {"max [%]", true},
                                          {"react. [%]", true},
                                          {"energy [%]", true},
                                          {"nonlin. [%]", true},
                                          {"set-up [s]", true},
                                          {"solve [s]", true},
                                          {"status", false},
                                          {"band", false}}};

using Row = std::array<std::string, columns.size()>;

constexpr double percent = 100.0;
constexpr double millimetres = 1000.0;
/// From here on a diverged solution would blow up the width of its column.
constexpr double largest_fixed = 1e5;

std::string fixed(double value, int decimals) {
    return std::abs(value) < largest_fixed || !std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals)
                                                                    : fmt::format("{:.1e}", value);
}

/// [m]; NaN if one displacement is NaN
double peak_displacement(const core::Solution &solution) {
    double peak = 0.0;
    for (const core::Vector3 &displacement : solution.displacement) {
        const double length = displacement.norm();
        if (std::isnan(length))
            return length;
        peak = std::max(peak, length);
    }
    return peak;
}

bool is_reference(const ModelResult &model, const Result &result) {
    return std::ranges::any_of(result.models, [&](const ModelResult &other) {
        return other.comparison && other.comparison->reference == model.name;
    });
}

/// For the reference its own uncertainty, for the others whether they are within it.
std::string uncertainty(const ModelResult &model, const Result &result) {
    const auto &known = result.reference_uncertainty;
    if (known && model.name == known->reference)
        return fixed(percent * known->relative_l2, 2);
    return is_within_uncertainty(model, result) ? "within" : "-";
}

std::string verdict(const ModelResult &model) {
    const auto met = meets_band(model);
    if (!met)
        return "no band";
    return *met
               ? "in band"
               : fmt::format("missed {:.2f} +- {:.2f} %", percent * model.band->expected, percent * model.band->margin);
}

Row row_of(const ModelResult &model, const Result &result) {
    const core::Solution &solution = model.solution;
    const bool reference = is_reference(model, result);
    Row row{result.problem.body->name,
            result.problem.load_case.name,
            reference ? model.name + " (reference)" : model.name,
            fixed(millimetres * peak_displacement(solution), 3),
            "-",
            uncertainty(model, result),
            "-",
            "-",
            "-",
            "-",
            std::isnan(solution.nonlinearity) ? "-" : fixed(percent * solution.nonlinearity, 2),
            fmt::format("{:.3g}", solution.setup_seconds),
            fmt::format("{:.3g}", solution.solve_seconds),
            core::to_string(solution.status),
            reference && !model.band ? "-" : verdict(model)};
    if (const auto &comparison = model.comparison) {
        row[4] = fixed(percent * comparison->relative_l2, 2);
        row[6] = fixed(millimetres * comparison->max_error, 3);
        row[7] = fixed(percent * comparison->max_error_relative, 2);
        row[8] = fixed(percent * comparison->reaction_error, 2);
        row[9] = fmt::format("{}{}", comparison->energy_error > 0.0 ? "+" : "",
                             fixed(percent * comparison->energy_error, 2));
    }
    return row;
}

Row titles() {
    Row row;
    std::ranges::transform(columns, row.begin(), [](const Column &column) { return column.title; });
    return row;
}

/// The titles, then a row per model.
std::vector<Row> rows_of(std::span<const Result> results) {
    std::vector<Row> rows{titles()};
    for (const Result &result : results)
        for (const ModelResult &model : result.models)
            rows.push_back(row_of(model, result));
    return rows;
}

std::string legend(std::span<const Result> results) {
    for (const Result &result : results)
        for (const ModelResult &model : result.models)
            if (is_within_uncertainty(model, result))
                return "\nwithin: closer to the reference than the reference's own uncertainty; not to be ranked above "
                       "another such model\n";
    return "";
}

/// A line for each time-dependent load case: what its rows are, and how the histories compare.
std::string histories(std::span<const Result> results, const std::string &bullet) {
    std::string lines;
    for (const Result &result : results) {
        if (!result.problem.load_case.release)
            continue;
        std::vector<std::string> remarks;
        for (const ModelResult &model : result.models)
            if (model.comparison && model.comparison->history_relative_l2)
                remarks.push_back(fmt::format("{} {} % off {}", model.name,
                                              fixed(percent * *model.comparison->history_relative_l2, 2),
                                              model.comparison->history_reference));
            else if (!model.solution.history)
                remarks.push_back(model.name + " gives no motion");
        lines +=
            fmt::format("{}{}, {}: the rows are the static start; motion of the probes, relative L2 in time: {}\n",
                        bullet, result.problem.body->name, result.problem.load_case.name, fmt::join(remarks, ", "));
    }
    return lines.empty() ? lines : fmt::format("\n{}", lines);
}

std::string failures(std::span<const Result> results, const std::string &bullet) {
    std::string lines;
    for (const Result &result : results)
        for (const ModelResult &model : result.models)
            if (model.solution.status != core::SolutionStatus::ok)
                lines += fmt::format("{}{}, {}, {}: {}: {}\n", bullet, result.problem.body->name,
                                     result.problem.load_case.name, model.name, core::to_string(model.solution.status),
                                     model.solution.message);
    return lines.empty() ? lines : fmt::format("\n{}", lines);
}

std::string escape_markdown(const std::string &cell) {
    std::string escaped;
    for (const char c : cell) {
        if (c == '|')
            escaped += '\\';
        escaped += c;
    }
    return escaped;
}

} // namespace

std::string text_table(std::span<const Result> results) {
    const auto rows = rows_of(results);
    std::array<std::size_t, columns.size()> width{};
    for (const Row &row : rows)
        for (std::size_t c = 0; c < row.size(); ++c)
            width[c] = std::max(width[c], row[c].size());

    std::string table;
    for (const Row &row : rows) {
        for (std::size_t c = 0; c < row.size(); ++c) {
            table += c == 0 ? "" : "  ";
            table += columns[c].is_number ? fmt::format("{:>{}}", row[c], width[c])
                                          : fmt::format("{:<{}}", row[c], width[c]);
        }
        table += '\n';
        if (&row == &rows.front()) {
            for (std::size_t c = 0; c < row.size(); ++c)
                table += fmt::format("{}{:-<{}}", c == 0 ? "" : "  ", "", width[c]);
            table += '\n';
        }
    }
    return table + legend(results) + histories(results, "") + failures(results, "");
}

std::string markdown_table(std::span<const Result> results) {
    const auto rows = rows_of(results);
    std::string table;
    for (const Row &row : rows) {
        for (const std::string &cell : row)
            table += fmt::format("| {} ", escape_markdown(cell));
        table += "|\n";
        if (&row == &rows.front()) {
            for (const Column &column : columns)
                table += column.is_number ? "| ---: " : "| --- ";
            table += "|\n";
        }
    }
    return table + legend(results) + histories(results, "- ") + failures(results, "- ");
}

} // namespace livermark::results
