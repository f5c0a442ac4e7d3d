#include "report/colour_map.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/units.hpp"
#include "report/html.hpp"
#include "report/ticks.hpp"

namespace livermark::report {

namespace {

/// The maps of the page, viewer/src/picture/colour_maps.ts: viridis, and magma from pale to dark without its ends.
constexpr std::size_t num_stops = 33;
using Stops = std::array<std::uint32_t, num_stops>;
constexpr Stops displacement_stops{
    0x440154, 0x470d60, 0x48186a, 0x482374, 0x472d7b, 0x453781, 0x424086, 0x3e4989, 0x3b528b, 0x375b8d, 0x33638d,
    0x2f6b8e, 0x2c728e, 0x297a8e, 0x26828e, 0x23898e, 0x21918c, 0x1f988b, 0x1fa088, 0x22a785, 0x28ae80, 0x32b67a,
    0x3fbc73, 0x4ec36b, 0x5ec962, 0x70cf57, 0x84d44b, 0x98d83e, 0xaddc30, 0xc2df23, 0xd8e219, 0xece51b, 0xfde725};
constexpr Stops error_stops{0xfcf0b2, 0xfde3a5, 0xfed799, 0xfecc8f, 0xfebf84, 0xfeb27a, 0xfea772, 0xfd9a6a, 0xfc8c63,
                            0xfa7f5e, 0xf8745c, 0xf4675c, 0xee5b5e, 0xe75263, 0xdf4a68, 0xd5446d, 0xca3e72, 0xc03a76,
                            0xb5367a, 0xaa337d, 0x9e2f7f, 0x942c80, 0x892881, 0x7e2482, 0x752181, 0x6a1c81, 0x5f187f,
                            0x54137d, 0x4a1079, 0x3f0f72, 0x331067, 0x29115a, 0x1e1149};
using core::millimetres;

} // namespace

Colour colour_at(Quantity quantity, double at) {
    const auto &stops = quantity == Quantity::displacement ? displacement_stops : error_stops;
    const double place = std::clamp(at, 0.0, 1.0) * static_cast<double>(num_stops - 1);
    const auto low = std::min(static_cast<std::size_t>(place), num_stops - 2);
    const double part = place - static_cast<double>(low);
    Colour colour{};
    for (std::size_t c = 0; c < 3; ++c) {
        const auto channel = [&](std::size_t stop) { return (stops[stop] >> (16U - 8U * c)) & 0xffU; };
        colour[c] = static_cast<std::uint8_t>(std::lround((1.0 - part) * channel(low) + part * channel(low + 1)));
    }
    return colour;
}

std::string hex(const Colour &colour) {
    return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

std::string colour_bar(Quantity quantity, double largest, const std::string &title) {
    constexpr double left = 6.0, width = 220.0, top = 18.0, height = 12.0;
    auto svg = fmt::format("<svg class=\"bar\" viewBox=\"0 0 {} 50\" role=\"img\"><title>{}</title><text x=\"{}\" "
                           "y=\"12\">{}</text>",
                           width + 2.0 * left, escaped(title), left, escaped(title));
    // Rectangles and not a gradient, which would need a name of its own in the page.
    constexpr int num_steps = 55;
    for (int i = 0; i < num_steps; ++i)
        svg += fmt::format("<rect x=\"{:.2f}\" y=\"{}\" width=\"{:.2f}\" height=\"{}\" fill=\"{}\"/>",
                           left + width * i / num_steps, top, width / num_steps + 0.4, height,
                           hex(colour_at(quantity, (i + 0.5) / num_steps)));
    for (const double tick : linear_ticks(0.0, millimetres * largest, 5))
        svg += fmt::format("<text x=\"{0:.2f}\" y=\"46\" text-anchor=\"middle\">{1}</text><line x1=\"{0:.2f}\" "
                           "x2=\"{0:.2f}\" y1=\"30\" y2=\"34\" stroke=\"#333\"/>",
                           left + width * tick / (millimetres * largest), tick_label(tick));
    return svg + "</svg>\n";
}

} // namespace livermark::report
