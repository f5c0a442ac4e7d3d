#include "report/plot.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "report/html.hpp"
#include "report/plot_labels.hpp"
#include "report/ticks.hpp"

namespace livermark::report {

namespace {

constexpr double key_length = 30.0; ///< of the piece of a line beside its name

/// Maps numbers of one axis to places on the page.
struct Ruler {
    Scale scale;
    double low, high; ///< numbers at the ends
    double from, to;  ///< their places

    static double straightened(Scale scale, double value) {
        return scale == Scale::logarithmic   ? std::log10(value)
               : scale == Scale::square_root ? std::sqrt(std::max(0.0, value))
                                             : value;
    }
    double place(double value) const {
        const double first = straightened(scale, low);
        return from + (to - from) * (straightened(scale, value) - first) / (straightened(scale, high) - first);
    }
    bool can_show(double value) const { return std::isfinite(value) && (scale != Scale::logarithmic || value > 0.0); }
    bool is_inside(double value) const { return value >= low && value <= high; }
};

Ruler ruler_of(const Axis &axis, const std::vector<double> &values, double from, double to) {
    Ruler ruler{axis.scale, 0.0, 0.0, from, to};
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double value : values)
        if (ruler.can_show(value)) {
            low = std::min(low, value);
            high = std::max(high, value);
        }
    if (!(low <= high))
        low = high = 1.0;
    if (axis.scale == Scale::logarithmic) {
        const double margin = std::max(std::pow(high / low, 0.07), 1.3);
        low /= margin;
        high *= margin;
    } else {
        const double margin = high > low ? 0.05 * (high - low) : std::max(1e-12, 0.1 * std::abs(high));
        low -= margin;
        high += margin;
    }
    ruler.low = axis.low.value_or(low);
    ruler.high = axis.high.value_or(high);
    return ruler;
}

std::vector<double> ticks_of(const Ruler &ruler) {
    if (ruler.scale == Scale::logarithmic)
        return logarithmic_ticks(ruler.low, ruler.high);
    if (ruler.scale == Scale::linear)
        return linear_ticks(ruler.low, ruler.high, 6);
    std::vector<double> ticks{0.0}; // squares of equal steps, near enough
    for (const double part : {0.05, 0.2, 0.5, 1.0})
        ticks.push_back(part * ruler.high);
    return ticks;
}

std::string marker_svg(Marker marker, double x, double y, const std::string &colour) {
    switch (marker) {
    case Marker::none:
        return "";
    case Marker::circle:
        return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>", x, y, colour);
    case Marker::square:
        return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"7\" height=\"7\" fill=\"{}\"/>", x - 3.5, y - 3.5,
                           colour);
    case Marker::diamond:
        return fmt::format("<path d=\"M{:.1f} {:.1f}l5 5l-5 5l-5 -5z\" fill=\"{}\"/>", x, y - 5.0, colour);
    case Marker::triangle:
        return fmt::format("<path d=\"M{:.1f} {:.1f}l4.7 8.4h-9.4z\" fill=\"{}\"/>", x, y - 5.0, colour);
    case Marker::cross:
        return fmt::format("<path d=\"M{:.1f} {:.1f}l9 9m0 -9l-9 9\" stroke=\"{}\" stroke-width=\"2\" fill=\"none\"/>",
                           x - 4.5, y - 4.5, colour);
    }
    return "";
}

/// A line of a series, from point to point.
std::string line_svg(const std::string &path, const SeriesStyle &style) {
    return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.8\"{}/>", path, style.colour,
                       style.dash.empty() ? "" : fmt::format(" stroke-dasharray=\"{}\"", style.dash));
}

/// Room and scales of one plot.
struct Panel {
    double left, right, top, bottom;
    Ruler x, y;

    bool can_show(const PlotPoint &point) const {
        return x.can_show(point.x) && y.can_show(point.y) && x.is_inside(point.x) && y.is_inside(point.y);
    }
};

Panel panel_of(const Plot &plot) {
    std::vector<double> xs, ys;
    double room = 12.0;
    for (const auto &series : plot.series) {
        if (!series.name.empty())
            room = std::max(room, text_width(series.name) + 24.0 + (plot.names == Names::key ? key_length : 0.0));
        for (const auto &point : series.points) {
            xs.push_back(point.x);
            ys.push_back(point.y);
        }
    }
    Panel panel{.left = 58.0, .right = plot.width - room, .top = 30.0, .bottom = plot.height - 46.0, .x = {}, .y = {}};
    panel.x = ruler_of(plot.x, xs, panel.left, panel.right);
    panel.y = ruler_of(plot.y, ys, panel.bottom, panel.top);
    return panel;
}

std::string axes_svg(const Plot &plot, const Panel &panel) {
    std::string svg;
    for (const double tick : ticks_of(panel.x))
        svg += fmt::format("<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>"
                           "<text class=\"tick\" x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4}</text>\n",
                           panel.x.place(tick), panel.top, panel.bottom, panel.bottom + 16.0, tick_label(tick));
    for (const double tick : ticks_of(panel.y))
        svg += fmt::format("<line class=\"grid\" x1=\"{1}\" x2=\"{2}\" y1=\"{0:.1f}\" y2=\"{0:.1f}\"/>"
                           "<text class=\"tick\" x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5}</text>\n",
                           panel.y.place(tick), panel.left, panel.right, panel.left - 7.0, panel.y.place(tick) + 4.0,
                           tick_label(tick));
    svg +=
        fmt::format("<path class=\"axis\" d=\"M{0} {1}V{2}H{3}\"/>", panel.left, panel.top, panel.bottom, panel.right);
    svg += fmt::format("<text class=\"label\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                       0.5 * (panel.left + panel.right), plot.height - 8.0, escaped(plot.x.label));
    svg += fmt::format("<text class=\"label\" transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}"
                       "</text>\n",
                       0.5 * (panel.top + panel.bottom), escaped(plot.y.label));
    return svg;
}

std::string series_svg(const Series &series, const Panel &panel) {
    constexpr double unseen = 0.4; // a point nearer to the last one than this adds bytes and no ink
    std::string path, markers;
    bool is_drawing = false;
    double last_x = 0.0, last_y = 0.0;
    for (const auto &point : series.points) {
        if (!panel.can_show(point)) {
            is_drawing = false;
            continue;
        }
        const double x = panel.x.place(point.x), y = panel.y.place(point.y);
        markers += marker_svg(series.style.marker, x, y, series.style.colour);
        if (is_drawing && std::hypot(x - last_x, y - last_y) < unseen)
            continue;
        path += fmt::format("{}{:.1f} {:.1f}", is_drawing ? "L" : "M", x, y);
        is_drawing = true;
        last_x = x;
        last_y = y;
    }
    return (series.style.has_line && !path.empty() ? line_svg(path, series.style) : "") + markers + "\n";
}

/// @param has_leader  a thin line from the point to the nearer end of the label
std::string label_svg(const Label &label, bool has_leader) {
    std::string svg;
    if (has_leader) {
        const double right = label.at_x + text_width(label.text);
        const double end = label.x < label.at_x ? label.at_x - 3.0 : std::min(label.x, right);
        const double below = label.x < label.at_x ? -4.0 : label.at_y < label.y ? 3.0 : -10.0;
        svg = fmt::format("<line class=\"leader\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>", label.x,
                          label.y, end, label.at_y + below);
    }
    return svg + fmt::format("<text class=\"name\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", label.at_x, label.at_y,
                             escaped(label.text));
}

/// Whether one could doubt which point a label beside points belongs to.
bool is_far(const Label &label) {
    return std::abs(label.at_y - label.y) > 1.6 * label_size;
}

/// The names of all series below each other, each behind a piece of its line.
std::string key_svg(const Plot &plot, const Panel &panel) {
    constexpr double line_height = 19.0;
    const double left = panel.right + 14.0;
    double y = panel.top + 8.0;
    std::string svg;
    for (const auto &series : plot.series)
        if (!series.name.empty()) {
            svg += line_svg(fmt::format("M{:.1f} {:.1f}h{}", left, y, key_length), series.style) +
                   marker_svg(series.style.marker, left + 0.5 * key_length, y, series.style.colour) +
                   fmt::format("<text class=\"name\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", left + key_length + 7.0,
                               y + 4.0, escaped(series.name));
            y += line_height;
        }
    return svg;
}

std::string labels_svg(const Plot &plot, const Panel &panel) {
    std::vector<Label> ends, beside;
    for (const auto &series : plot.series) {
        const auto shown = [&](const PlotPoint &point) { return panel.can_show(point); };
        const auto last = std::find_if(series.points.rbegin(), series.points.rend(), shown);
        if (plot.names == Names::at_ends && !series.name.empty() && last != series.points.rend())
            ends.push_back({series.name, panel.x.place(last->x), panel.y.place(last->y), 0.0, 0.0});
        for (const auto &point : series.points)
            if (!point.label.empty() && shown(point))
                beside.push_back({point.label, panel.x.place(point.x), panel.y.place(point.y), 0.0, 0.0});
    }
    spread_in_column(ends, panel.right + 14.0, panel.top, panel.bottom);
    place_beside_points(beside, panel.left, panel.right, panel.top, panel.bottom);
    auto svg = plot.names == Names::key ? key_svg(plot, panel) : std::string();
    for (const auto &label : ends)
        svg += label_svg(label, true);
    for (const auto &label : beside)
        svg += label_svg(label, is_far(label));
    return svg;
}

} // namespace

bool has_points(const Plot &plot) {
    const auto panel = panel_of(plot);
    return std::ranges::any_of(plot.series, [&](const Series &series) {
        return std::ranges::any_of(series.points, [&](const PlotPoint &point) { return panel.can_show(point); });
    });
}

std::string plot_svg(const Plot &plot) {
    const auto panel = panel_of(plot);
    auto svg = fmt::format("<svg class=\"plot\" viewBox=\"0 0 {} {}\" role=\"img\"><title>{}</title>\n"
                           "<text class=\"title\" x=\"{}\" y=\"16\">{}</text>\n",
                           plot.width, plot.height, escaped(plot.title), panel.left, escaped(plot.title));
    svg += axes_svg(plot, panel);
    for (const auto &series : plot.series)
        svg += series_svg(series, panel);
    return svg + labels_svg(plot, panel) + "</svg>\n";
}

} // namespace livermark::report
