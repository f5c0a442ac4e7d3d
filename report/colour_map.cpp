#include "report/colour_map.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "report/html.hpp"
#include "report/ticks.hpp"

namespace livermark::report {

namespace {

constexpr std::array<Colour, 9> stops{{{0x44, 0x01, 0x54},
                                       {0x47, 0x2d, 0x7b},
                                       {0x3b, 0x52, 0x8b},
                                       {0x2c, 0x72, 0x8e},
                                       {0x21, 0x91, 0x8c},
                                       {0x28, 0xae, 0x80},
                                       {0x5e, 0xc9, 0x62},
                                       {0xad, 0xdc, 0x30},
                                       {0xfd, 0xe7, 0x25}}};
constexpr double millimetres = 1000.0;

} // namespace

Colour viridis(double at) {
    const double place = std::clamp(at, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
    const auto low = std::min(static_cast<std::size_t>(place), stops.size() - 2);
    const double part = place - static_cast<double>(low);
    Colour colour{};
    for (std::size_t c = 0; c < 3; ++c)
        colour[c] = static_cast<std::uint8_t>(std::lround((1.0 - part) * stops[low][c] + part * stops[low + 1][c]));
    return colour;
}

std::string hex(const Colour &colour) {
    return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

std::string colour_bar(double largest, const std::string &title) {
    constexpr double left = 6.0, width = 220.0, top = 18.0, height = 12.0;
    auto svg = fmt::format("<svg class=\"bar\" viewBox=\"0 0 {} 50\" role=\"img\"><title>{}</title><text x=\"{}\" "
                           "y=\"12\">{}</text>",
                           width + 2.0 * left, escaped(title), left, escaped(title));
    // Rectangles and not a gradient, which would need a name of its own in the page.
    constexpr int num_steps = 55;
    for (int i = 0; i < num_steps; ++i)
        svg += fmt::format("<rect x=\"{:.2f}\" y=\"{}\" width=\"{:.2f}\" height=\"{}\" fill=\"{}\"/>",
                           left + width * i / num_steps, top, width / num_steps + 0.4, height,
                           hex(viridis((i + 0.5) / num_steps)));
    for (const double tick : linear_ticks(0.0, millimetres * largest, 5))
        svg += fmt::format("<text x=\"{0:.2f}\" y=\"46\" text-anchor=\"middle\">{1}</text><line x1=\"{0:.2f}\" "
                           "x2=\"{0:.2f}\" y1=\"30\" y2=\"34\" stroke=\"#333\"/>",
                           left + width * tick / (millimetres * largest), tick_label(tick));
    return svg + "</svg>\n";
}

} // namespace livermark::report
