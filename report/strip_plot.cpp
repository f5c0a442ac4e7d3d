#include "report/strip_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "report/html.hpp"
#include "report/plot_labels.hpp"
#include "report/ticks.hpp"

namespace livermark::report {

namespace {

// In units of a CSS pixel.
constexpr double width = 420.0;
constexpr double left = 10.0, right = 410.0, top = 62.0, below = 42.0;
constexpr double name_height = 19.0, strip_height = 15.0;

/// Of the axis, which is logarithmic.
struct Range {
    double low, high;

    double place(double value) const { return left + (right - left) * std::log(value / low) / std::log(high / low); }
};

Range range_of(const StripPlot &plot) {
    double low = std::numeric_limits<double>::infinity(), high = 0.0;
    for (const auto &row : plot.rows)
        for (const auto &strip : row.strips)
            for (const double value : strip.values)
                if (value > 0.0) {
                    low = std::min(low, value);
                    high = std::max(high, value);
                }
    const double margin = std::max(std::pow(high / low, 0.05), 1.1);
    return {low / margin, high * margin};
}

std::string strip_marker(std::size_t strip, double x, double y) {
    constexpr std::array colours{"#0072b2", "#d55e00"};
    const auto *const colour = colours[strip % colours.size()];
    if (strip % 2 == 0)
        return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.2\" fill=\"{}\" fill-opacity=\"0.75\"/>", x, y,
                           colour);
    return fmt::format("<path d=\"M{:.1f} {:.1f}l4 4l-4 4l-4 -4z\" fill=\"{}\" fill-opacity=\"0.75\"/>", x, y - 4.0,
                       colour);
}

/// What each marker stands for, in one line.
std::string strip_key(const StripPlot &plot) {
    std::string svg;
    double x = left + 5.0;
    for (std::size_t s = 0; s < plot.strip_names.size(); ++s) {
        svg += strip_marker(s, x, 34.0) + fmt::format("<text class=\"name\" x=\"{:.1f}\" y=\"38\">{}</text>\n", x + 9.0,
                                                      escaped(plot.strip_names[s]));
        x += text_width(plot.strip_names[s]) + 34.0;
    }
    return svg;
}

std::string strip_svg(const Strip &strip, std::size_t number, const Range &range, double y) {
    std::string svg;
    if (strip.values.empty())
        return svg;
    const auto inside = [&](double value) { return range.place(std::clamp(value, range.low, range.high)); };
    svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"9\" fill=\"#c3cad0\"/>",
                       inside(strip.median_low), y - 4.5,
                       std::max(1.0, inside(strip.median_high) - inside(strip.median_low)));
    for (const double value : strip.values)
        if (value > 0.0)
            svg += strip_marker(number, range.place(value), y);
    return svg + fmt::format("<path d=\"M{:.1f} {:.1f}v13\" stroke=\"#1d2329\" stroke-width=\"2\"/>\n",
                             inside(strip.median), y - 6.5);
}

} // namespace

std::string strip_plot_svg(const StripPlot &plot) {
    const auto range = range_of(plot);
    const double row_height = name_height + strip_height * static_cast<double>(plot.strip_names.size());
    const double bottom = top + row_height * static_cast<double>(plot.rows.size());
    auto svg = fmt::format("<svg class=\"plot\" style=\"max-width:{0}px\" viewBox=\"0 0 {1} {2}\" role=\"img\">"
                           "<title>{3}</title>\n<text class=\"title\" x=\"{4}\" y=\"16\">{3}</text>\n",
                           1.25 * width, width, bottom + below, escaped(plot.title), left);
    svg += strip_key(plot);
    for (const double tick : logarithmic_ticks(range.low, range.high))
        svg += fmt::format("<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>"
                           "<text class=\"tick\" x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4}</text>\n",
                           range.place(tick), top - 10.0, bottom, bottom + 16.0, tick_label(tick));
    double y = top;
    for (const auto &row : plot.rows) {
        svg += fmt::format("<text class=\"name\" x=\"{}\" y=\"{:.1f}\">{}</text>\n", left, y + 7.0, escaped(row.name));
        for (std::size_t s = 0; s < row.strips.size(); ++s)
            svg += strip_svg(row.strips[s], s, range, y + name_height + strip_height * static_cast<double>(s));
        y += row_height;
    }
    return svg + fmt::format("<path class=\"axis\" d=\"M{} {:.1f}H{}\"/><text class=\"label\" x=\"{}\" y=\"{:.1f}\" "
                             "text-anchor=\"middle\">{}</text></svg>\n",
                             left, bottom, right, 0.5 * (left + right), bottom + below - 8.0, escaped(plot.label));
}

} // namespace livermark::report
