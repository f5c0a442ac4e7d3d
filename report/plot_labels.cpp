#include "report/plot_labels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace livermark::report {

namespace {

constexpr double letter_width = 0.6 * label_size;
constexpr double line_height = 1.15 * label_size;
/// From the base line to the middle of small letters.
constexpr double half_letter = 0.35 * label_size;

struct Box {
    double left, right, top, bottom;
};

Box box_of(const Label &label) {
    return {label.at_x, label.at_x + text_width(label.text), label.at_y - 0.8 * label_size,
            label.at_y + 0.25 * label_size};
}

double common_area(const Box &a, const Box &b) {
    return std::max(0.0, std::min(a.right, b.right) - std::max(a.left, b.left)) *
           std::max(0.0, std::min(a.bottom, b.bottom) - std::max(a.top, b.top));
}

double area_outside(const Box &box, const Box &panel) {
    return (box.right - box.left) * (box.bottom - box.top) - common_area(box, panel);
}

} // namespace

double text_width(const std::string &text) {
    return letter_width * static_cast<double>(text.size());
}

void spread_in_column(std::vector<Label> &labels, double left, double top, double bottom) {
    std::ranges::stable_sort(labels, {}, &Label::y);
    double lowest = top + 0.5 * line_height;
    for (auto &label : labels) {
        label.at_x = left;
        label.at_y = std::max(label.y, lowest);
        lowest = label.at_y + line_height;
    }
    // What has been pushed out at the bottom comes back, and pushes the others up.
    double highest = bottom;
    for (auto label = labels.rbegin(); label != labels.rend(); ++label) {
        label->at_y = std::min(label->at_y, highest);
        highest = label->at_y - line_height;
    }
    for (auto &label : labels)
        label.at_y += half_letter;
}

void place_beside_points(std::vector<Label> &labels, double left, double right, double top, double bottom) {
    const Box panel{left, right, top, bottom};
    constexpr double gap = 7.0;
    constexpr double half_marker = 5.0;
    for (std::size_t l = 0; l < labels.size(); ++l) {
        auto &label = labels[l];
        const double width = text_width(label.text);
        double least = std::numeric_limits<double>::infinity();
        Label best = label;
        for (const double ring : {1.0, 2.0, 3.0, 4.5, 6.0})
            for (const auto &[side, up] : {std::array{1.0, 0.0},
                                           {-1.0, 0.0},
                                           {0.0, 1.0},
                                           {0.0, -1.0},
                                           {1.0, 1.0},
                                           {1.0, -1.0},
                                           {-1.0, 1.0},
                                           {-1.0, -1.0}}) {
                Label tried = label;
                tried.at_x = side > 0.0 ? label.x + gap : side < 0.0 ? label.x - gap - width : label.x - 0.5 * width;
                tried.at_y = label.y + half_letter - up * ring * line_height;
                const Box box = box_of(tried);
                double cost = 4.0 * area_outside(box, panel) + ring;
                for (std::size_t other = 0; other < labels.size(); ++other) {
                    const auto &there = labels[other];
                    cost += common_area(box, {there.x - half_marker, there.x + half_marker, there.y - half_marker,
                                              there.y + half_marker});
                    if (other < l)
                        cost += common_area(box, box_of(there));
                }
                if (cost < least) {
                    least = cost;
                    best = tried;
                }
            }
        label = best;
    }
}

} // namespace livermark::report
