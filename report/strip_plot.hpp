#pragma once

#include <string>
#include <vector>

namespace livermark::report {

/// Positive numbers of one kind, a marker each, and their median.
struct Strip {
    std::vector<double> values;
    double median = 0.0;
    double median_low = 0.0, median_high = 0.0; ///< interval of the median
};

/// Strips below one name, in the order of StripPlot::strip_names.
struct StripRow {
    std::string name;
    std::vector<Strip> strips; ///< without values where there is none
};

struct StripPlot {
    std::string title;
    std::string label; ///< of the axis, with its unit
    std::vector<std::string> strip_names;
    std::vector<StripRow> rows;
};

/// Inline SVG: the values of each row on one logarithmic axis, strips below each other and told apart by marker and
/// colour. A grey bar is the interval of the median, a black stroke the median. Names stand above their strips, so that
/// the plot can be read on a narrow screen.
/// @param plot  with a positive value
std::string strip_plot_svg(const StripPlot &plot);

} // namespace livermark::report
