#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tetra_mesh.hpp"
#include "report/colour_map.hpp"
#include "report/png.hpp"

namespace livermark::report {

/// Where one looks at a body from, along parallel lines, and which part of the plane across them is in the picture.
struct View {
    core::Vector3 right, up, toward; ///< of unit length, at right angles; `toward` points at who looks
    double low_x, low_y;             ///< corner of the picture along right and up [m]
    double pixel;                    ///< side of a pixel [m]
    int width, height;               ///< [pixel]
};

/// The surface of a body as it is to be drawn.
struct Surface {
    std::span<const std::array<int, 3>> triangles; ///< right-handed seen from outside
    std::span<const core::Vector3> points;         ///< (N) where the nodes are drawn [m]
    std::span<const double> values;                ///< (N) of the colours, all finite
    double largest;                                ///< value of the last colour, > 0
    Quantity quantity = Quantity::displacement;    ///< whose colours
};

/// One of sixteen directions around the body, from a little above or below: one that shows much of the body and of what
/// moves. Vertical is z.
/// @param displacement  (N) [m], all finite and not all zero
/// @param shapes        (N) each: all that is to be in the picture [m]
/// @param width         [pixel]
View find_view(std::span<const std::array<int, 3>> triangles, std::span<const core::Vector3> points,
               std::span<const core::Vector3> displacement, std::span<const std::vector<core::Vector3>> shapes,
               int width);

/// Which samples of a picture the outline of a shape covers; the same for all pictures of one view.
using Outline = std::vector<std::uint8_t>;

/// @param points  (N) nodes [m]
Outline outline_of(std::span<const std::array<int, 3>> triangles, std::span<const core::Vector3> points,
                   const View &view);

/// Draws a surface with colours of colour_at() between its nodes, lit from where one looks, so that a part that faces
/// the eye has the colours of the legend. White behind it. Edges are smooth: 9 samples per pixel. Channels are
/// multiples of 4, or 255.
/// @param outline  drawn over it as a line; of the same view, or empty
Picture draw_surface(const Surface &surface, const View &view, const Outline &outline = {});

} // namespace livermark::report
