#include "report/surface_picture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "report/colour_map.hpp"

namespace livermark::report {

namespace {

using core::Vector3;
using Triangle = std::array<int, 3>;

constexpr int samples = 3; ///< along each side of a pixel
/// Triangles that meet at a sharper angle are drawn with an edge between them.
constexpr double smooth_cosine = 0.75;
/// Brightness of a surface seen from its side.
constexpr double least_light = 0.5;
constexpr std::uint8_t white = 255;
constexpr std::uint8_t line_grey = 60;

/// Along right, up and toward, in samples of the picture; y goes down.
Vector3 project(const View &view, const Vector3 &point) {
    const double scale = samples / view.pixel;
    return {scale * (point.dot(view.right) - view.low_x),
            samples * view.height - scale * (point.dot(view.up) - view.low_y), scale * point.dot(view.toward)};
}

/// Which sample is covered by what.
struct Fragments {
    int width, height;
    std::vector<double> depth;                 ///< minus infinity where there is nothing
    std::vector<int> triangle;                 ///< -1 where there is nothing
    std::vector<std::array<float, 2>> weights; ///< of the second and the third corner

    std::size_t at(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

Fragments rasterise(std::span<const Triangle> triangles, std::span<const Vector3> points, const View &view) {
    Fragments seen{samples * view.width, samples * view.height, {}, {}, {}};
    const auto count = static_cast<std::size_t>(seen.width) * static_cast<std::size_t>(seen.height);
    seen.depth.assign(count, -std::numeric_limits<double>::infinity());
    seen.triangle.assign(count, -1);
    seen.weights.assign(count, {});
    const auto range = [](double low, double high, int size) {
        return std::array{std::max(0, static_cast<int>(std::floor(low))),
                          std::min(size - 1, static_cast<int>(std::ceil(high)))};
    };
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const Vector3 a = project(view, points[triangles[t][0]]);
        const Vector3 b = project(view, points[triangles[t][1]]);
        const Vector3 c = project(view, points[triangles[t][2]]);
        const double area = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
        if (area == 0.0)
            continue;
        const auto [first_x, last_x] =
            range(std::min({a.x(), b.x(), c.x()}), std::max({a.x(), b.x(), c.x()}), seen.width);
        const auto [first_y, last_y] =
            range(std::min({a.y(), b.y(), c.y()}), std::max({a.y(), b.y(), c.y()}), seen.height);
        for (int y = first_y; y <= last_y; ++y)
            for (int x = first_x; x <= last_x; ++x) {
                const double px = x + 0.5, py = y + 0.5;
                const double of_b = ((px - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (py - a.y())) / area;
                const double of_c = ((b.x() - a.x()) * (py - a.y()) - (px - a.x()) * (b.y() - a.y())) / area;
                if (of_b < 0.0 || of_c < 0.0 || of_b + of_c > 1.0)
                    continue;
                const auto at = seen.at(x, y);
                if (const double depth = a.z() + of_b * (b.z() - a.z()) + of_c * (c.z() - a.z());
                    depth > seen.depth[at]) {
                    seen.depth[at] = depth;
                    seen.triangle[at] = static_cast<int>(t);
                    seen.weights[at] = {static_cast<float>(of_b), static_cast<float>(of_c)};
                }
            }
    }
    return seen;
}

Vector3 area_vector(const Triangle &triangle, std::span<const Vector3> points) {
    return 0.5 * (points[triangle[1]] - points[triangle[0]]).cross(points[triangle[2]] - points[triangle[0]]);
}

/// A normal for each corner of each triangle: the mean of the triangles at its node that go on smoothly from it.
std::vector<std::array<Vector3, 3>> corner_normals(std::span<const Triangle> triangles,
                                                   std::span<const Vector3> points) {
    std::vector<std::vector<int>> at_node(points.size());
    std::vector<Vector3> area, normal;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        area.push_back(area_vector(triangles[t], points));
        normal.push_back(area.back().normalized());
        for (const int node : triangles[t])
            at_node[node].push_back(static_cast<int>(t));
    }
    std::vector<std::array<Vector3, 3>> normals(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c) {
            Vector3 sum = Vector3::Zero();
            for (const int other : at_node[triangles[t][c]])
                if (normal[other].dot(normal[t]) > smooth_cosine)
                    sum += area[other];
            normals[t][c] = sum.normalized();
        }
    return normals;
}

/// In 64 steps, which nobody sees, and which halve the size of a file.
std::uint8_t coarse(int channel) {
    return static_cast<std::uint8_t>(std::min<int>(white, (channel + 2) / 4 * 4));
}

/// The mean of the samples in each pixel.
Picture averaged(const std::vector<Colour> &colours, const View &view) {
    Picture picture{view.width, view.height, {}};
    picture.rgb.reserve(3 * static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                int sum = 0;
                for (int s = 0; s < samples * samples; ++s)
                    sum += colours[static_cast<std::size_t>(samples * y + s / samples) *
                                       static_cast<std::size_t>(samples * view.width) +
                                   static_cast<std::size_t>(samples * x + s % samples)][c];
                picture.rgb.push_back(coarse((sum + samples * samples / 2) / (samples * samples)));
            }
    return picture;
}

View looking_along(double azimuth, double elevation) {
    View view{};
    view.toward = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                   std::sin(elevation)};
    view.right = Vector3::UnitZ().cross(view.toward).normalized();
    view.up = view.toward.cross(view.right);
    return view;
}

/// How much of a surface one sees, and how much of its displacement.
struct Sight {
    double area = 0.0, motion = 0.0;
};

Sight sight_of(const View &view, std::span<const Triangle> triangles, std::span<const Vector3> points,
               std::span<const Vector3> displacement) {
    Sight sight;
    for (const auto &triangle : triangles) {
        Vector3 mean = Vector3::Zero();
        for (const int node : triangle)
            mean += displacement[node] / 3.0;
        const double area = std::max(0.0, area_vector(triangle, points).dot(view.toward));
        sight.area += area;
        sight.motion += area * mean.norm();
    }
    return sight;
}

void fit(View &view, std::span<const std::vector<Vector3>> shapes, int width) {
    Eigen::AlignedBox2d box;
    for (const auto &shape : shapes)
        for (const auto &point : shape)
            box.extend(Eigen::Vector2d(point.dot(view.right), point.dot(view.up)));
    constexpr int margin = 4;       // [pixel] on either side
    constexpr double tallest = 1.5; // of the width
    const Eigen::Vector2d size = box.sizes();
    Eigen::Vector2d low = box.min();
    view.pixel = std::max(size.x(), size.y() / tallest) / (width - 2 * margin);
    low.x() -= 0.5 * ((width - 2 * margin) * view.pixel - size.x()); // in the middle
    view.width = width;
    view.height = static_cast<int>(std::ceil(size.y() / view.pixel)) + 2 * margin;
    view.low_x = low.x() - margin * view.pixel;
    view.low_y = low.y() - margin * view.pixel;
}

} // namespace

View find_view(std::span<const Triangle> triangles, std::span<const Vector3> points,
               std::span<const Vector3> displacement, std::span<const std::vector<Vector3>> shapes, int width) {
    std::vector<View> views;
    std::vector<Sight> sights;
    Sight most;
    for (const double elevation : {0.3, -0.3})
        for (int i = 0; i < 8; ++i) {
            views.push_back(looking_along(std::numbers::pi * (0.25 * i - 0.5) - 0.2, elevation));
            sights.push_back(sight_of(views.back(), triangles, points, displacement));
            most.area = std::max(most.area, sights.back().area);
            most.motion = std::max(most.motion, sights.back().motion);
        }
    // The broad side and what moves there count alike.
    const auto merit = [&](const Sight &sight) { return sight.area / most.area + sight.motion / most.motion; };
    auto best = views[static_cast<std::size_t>(std::ranges::max_element(sights, {}, merit) - sights.begin())];
    fit(best, shapes, width);
    return best;
}

Outline outline_of(std::span<const Triangle> triangles, std::span<const Vector3> points, const View &view) {
    const auto shape = rasterise(triangles, points, view);
    const auto is_inside = [&](int x, int y) {
        return x >= 0 && y >= 0 && x < shape.width && y < shape.height && shape.triangle[shape.at(x, y)] >= 0;
    };
    Outline outline(shape.triangle.size(), 0);
    for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x) {
            const bool inside = is_inside(x, y);
            outline[shape.at(x, y)] = inside != is_inside(x - 1, y) || inside != is_inside(x + 1, y) ||
                                              inside != is_inside(x, y - 1) || inside != is_inside(x, y + 1)
                                          ? 1
                                          : 0;
        }
    return outline;
}

Picture draw_surface(const Surface &surface, const View &view, const Outline &outline) {
    const auto seen = rasterise(surface.triangles, surface.points, view);
    const auto normals = corner_normals(surface.triangles, surface.points);
    std::vector<Colour> colours(seen.triangle.size(), Colour{white, white, white});
    for (std::size_t s = 0; s < colours.size(); ++s) {
        const int t = seen.triangle[s];
        if (t < 0)
            continue;
        double value = 0.0;
        Vector3 normal = Vector3::Zero();
        const auto [of_b, of_c] = seen.weights[s];
        const std::array<double, 3> weights{1.0 - of_b - of_c, of_b, of_c};
        for (std::size_t c = 0; c < 3; ++c) {
            value += weights[c] * surface.values[surface.triangles[t][c]];
            normal += weights[c] * normals[t][c];
        }
        const double facing = std::abs(normal.normalized().dot(view.toward));
        const double light = least_light + (1.0 - least_light) * facing;
        colours[s] = colour_at(surface.quantity, value / surface.largest);
        for (auto &channel : colours[s])
            channel = static_cast<std::uint8_t>(std::lround(light * channel));
    }
    for (std::size_t s = 0; s < outline.size(); ++s)
        if (outline[s] != 0)
            colours[s] = {line_grey, line_grey, line_grey};
    return averaged(colours, view);
}

} // namespace livermark::report
