#pragma once

#include <optional>
#include <string>
#include <vector>

namespace livermark::report {

enum class Scale { linear, logarithmic, square_root };

struct Axis {
    std::string label; ///< with its unit
    Scale scale = Scale::linear;
    std::optional<double> low{}, high{}; ///< that of the points, with a margin, if there is none
};

struct PlotPoint {
    double x, y;
    std::string label{}; ///< stands beside it; may be empty
};

enum class Marker { none, circle, square, diamond, triangle, cross };

/// How one series looks: colour as in a style sheet, SVG's dash pattern.
struct SeriesStyle {
    std::string colour = "#222";
    Marker marker = Marker::circle;
    bool has_line = true;
    std::string dash{};
};

struct Series {
    std::string name; ///< stands at the right end of its line; may be empty
    std::vector<PlotPoint> points;
    SeriesStyle style;
};

/// Where the names of series stand: at the right ends of their lines, or with a piece of each in a list.
enum class Names { at_ends, key };

struct Plot {
    std::string title;
    Axis x, y;
    std::vector<Series> series;
    double width = 520.0, height = 350.0; ///< of the whole, in units of a CSS pixel
    Names names = Names::at_ends;
};

/// Inline SVG of points and lines with all labels written out: nothing is left for a pointer to find. Points that are
/// not finite, or not positive on a logarithmic axis, are left out, and lines break there. Labels are moved until they
/// do not cover each other.
std::string plot_svg(const Plot &plot);

/// Whether a plot has a point to draw.
bool has_points(const Plot &plot);

} // namespace livermark::report
