#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "results/records/result.hpp"

/// Stiffness at the tool in cells of tables, see core::ToolComparison.
namespace livermark::results {

/// Whether a model is what another one is compared with.
bool is_reference(const ModelResult &model, const Result &result);

/// Stiffness at the tool of a model under a load case; along a path of loads the one of the largest absolute value. NaN
/// where there is none.
double stiffness_at_tool(const ModelResult &model);

/// With its sign, and a mark where fingers feel it [%]; "-" for NaN.
std::string stiffness_cell(double stiffness);

/// The same of an absolute value.
std::string size_cell(double size);

/// Stiffness at the tool of one model over load cases.
struct StiffnessCases {
    std::vector<double> sizes{}; ///< absolute values
    bool has_positive = false, has_negative = false;
    double worst = std::numeric_limits<double>::quiet_NaN();
    std::string worst_load_case{};

    /// A NaN is left out.
    void enter(double stiffness, const std::string &load_case);
    /// Mean of absolute values; NaN where there are none.
    double mean() const;
    /// Mean, and median, of absolute values [%].
    std::string mean_cell() const;
    std::string median_cell() const;
    /// The median with a sign where all values have the same.
    std::string signed_median_cell() const;
    /// The one of the largest absolute value, with its sign and its load case.
    std::string worst_cell() const;
};

/// Meaning of the columns and the mark.
std::string tool_legend();

/// Meaning of means over load cases.
std::string mean_tool_legend();

/// A line with the radius of the smallest tool of each load case over the edge length under it, and one with that of
/// the contact of each ball along its path; empty without tools.
std::string tool_radii(std::span<const Result> results);

/// A sentence on the balls whose contact has a radius of less than core::smallest_contact edges; nothing where there is
/// none.
std::optional<std::string> note_on_small_contacts(std::span<const Result> results);

/// A sentence on the other tools with a radius of less than two edges; nothing where there is none.
std::optional<std::string> note_on_small_tools(std::span<const Result> results);

} // namespace livermark::results
