#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace livermark::report {

using Colour = std::array<std::uint8_t, 3>; ///< red, green, blue

/// What colours show: each has its map, the same as on the page of `livermark view`.
enum class Quantity { displacement, error };

/// Viridis for displacements, magma from pale to dark for errors (van der Walt and Smith 2015), at 33 places and
/// straight between them: equal steps look equal, and they are legible in grey and to the colour-blind.
/// @param at  from 0 to 1; what is outside gets the colour of the end
Colour colour_at(Quantity quantity, double at);

/// As in a style sheet, #rrggbb.
std::string hex(const Colour &colour);

/// A bar of the colours from 0 to a length, as inline SVG with ticks in mm.
/// @param largest  [m], > 0
/// @param title    a text above it
std::string colour_bar(Quantity quantity, double largest, const std::string &title);

} // namespace livermark::report
