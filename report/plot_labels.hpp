#pragma once

#include <string>
#include <vector>

/// Where the labels of a plot stand. All lengths are those of the plot.
namespace livermark::report {

struct Label {
    std::string text;
    double x, y;       ///< the point that it belongs to
    double at_x, at_y; ///< left end of its base line, filled in
};

inline constexpr double label_size = 11.5; ///< height of the letters

/// Width of a text, about.
double text_width(const std::string &text);

/// Moves labels in one column up and down until no two overlap, in the order of their points.
/// @param left         at_x of all
/// @param top, bottom  where they have to stay, if there is room
void spread_in_column(std::vector<Label> &labels, double left, double top, double bottom);

/// Puts each label to one of the sides of its point, where it covers the least of labels and points that are there.
/// @param left, right, top, bottom  the panel
void place_beside_points(std::vector<Label> &labels, double left, double right, double top, double bottom);

} // namespace livermark::report
