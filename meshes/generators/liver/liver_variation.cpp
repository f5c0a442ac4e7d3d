#include "meshes/generators/liver/liver_variation.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <tuple>
#include <utility>

#include "meshes/generators/cube_root.hpp"
#include "meshes/generators/surface_mesh.hpp"
#include "support/input_error.hpp"
#include "support/random_numbers.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;
using support::RandomNumbers;

constexpr double smallest_volume = 0.9e-3; // [m^3]
constexpr double largest_volume = 2.2e-3;  // [m^3]

/// @return body surface [m^2] and liver volume [m^3]
std::pair<double, double> draw_person(RandomNumbers &random) {
    while (true) {
        const double surface = random.normal(1.8, 0.2);
        const double volume = 1e-6 * (1267.28 * surface - 794.41 + random.normal(0.0, 200.0));
        if (volume >= smallest_volume && volume <= largest_volume)
            return {surface, volume};
    }
}

LiverShape draw_shape(RandomNumbers &random) {
    LiverShape shape;
    const double length = random.uniform(0.72, 1.15);
    const double thickness = random.uniform(0.85, 1.2);
    shape.left_lobe = shape.left_lobe.cwiseProduct(Vector3(length, thickness, thickness));
    shape.right_lobe.z() *= random.uniform(0.92, 1.12);
    shape.visceral_height += random.uniform(-7.0, 4.0);
    shape.stomach *= random.uniform(0.9, 1.06);
    shape.metres_per_unit.y() *= random.uniform(0.86, 1.16);
    shape.metres_per_unit.x() *= random.uniform(0.96, 1.04);
    if (random.below(6) == 0)
        shape.tongue_length = random.uniform(20.0, 60.0);
    return shape;
}

/// Volume and centroid, and the part of the volume on the left of the falciform ligament, which is summed over columns
/// of a grid.
struct Extent {
    double volume = 0.0;                // [m^3]
    Vector3 centroid = Vector3::Zero(); // [m]
    double left_part = 0.0;
};

Extent extent_of(const LiverShape &shape) {
    constexpr double spacing = 0.003; // [m]
    const auto [low, high] = liver_bounding_box(shape);
    const auto surface = march_tetrahedra([&](const Vector3 &p) { return liver_level(p, shape); }, low, high, spacing);
    Extent extent{.volume = enclosed_volume(surface)};
    for (const auto &[a, b, c] : surface.triangles) {
        const auto &p = surface.points;
        extent.centroid += p[a].dot(p[b].cross(p[c])) / 24.0 * (p[a] + p[b] + p[c]);
    }
    extent.centroid /= extent.volume;
    const double border = left_lobe_border(shape);
    int inside = 0, left = 0;
    for (double x = low.x(); x < high.x(); x += spacing)
        for (double y = low.y(); y < high.y(); y += spacing)
            for (double z = low.z(); z < high.z(); z += spacing)
                if (liver_level({x, y, z}, shape) < 0.0) {
                    ++inside;
                    left += x > border ? 1 : 0;
                }
    extent.left_part = static_cast<double>(left) / inside;
    return extent;
}

/// Every direction alike: a point of the ball, by rejection.
Vector3 draw_direction(RandomNumbers &random) {
    while (true) {
        Vector3 point;
        for (int c = 0; c < 3; ++c)
            point[c] = random.uniform(-1.0, 1.0);
        if (point.norm() <= 1.0 && point.norm() > 0.1)
            return point.normalized();
    }
}

Lesion draw_lesion(RandomNumbers &random) {
    const double u = random.uniform();
    const double across = 0.011 + 0.039 * u * u; // [m]
    Lesion lesion;
    lesion.semi_axes = 0.5 * across * Vector3(1.0, random.uniform(0.8, 1.0), 0.0);
    lesion.semi_axes.z() = lesion.semi_axes.y() * random.uniform(0.85, 1.0);
    const Vector3 a = draw_direction(random);
    Vector3 b = a;
    while (a.cross(b).norm() < 0.1)
        b = draw_direction(random);
    b = (b - b.dot(a) * a).normalized();
    lesion.axes = {a, b, a.cross(b)};
    return lesion;
}

/// Whether a lesion lies deep enough below the capsule and apart from others.
bool has_room(const Lesion &lesion, const std::vector<Lesion> &others, const LiverShape &shape) {
    constexpr double below_capsule = 0.009; // [m]
    constexpr double apart = 0.014;         // [m]
    constexpr int frequency = 3;
    static const auto directions = geodesic_sphere(frequency).points;
    for (const auto &other : others)
        if ((lesion.center - other.center).norm() < lesion.semi_axes.x() + other.semi_axes.x() + apart)
            return false;
    return std::ranges::all_of(directions, [&](const Vector3 &direction) {
        Vector3 point = lesion.center;
        for (int d = 0; d < 3; ++d)
            point += direction[d] * lesion.semi_axes[d] * lesion.axes[d];
        return liver_level(point, shape) < -below_capsule;
    });
}

/// A lesion that finds no place is made smaller, until it does.
std::vector<Lesion> draw_lesions(RandomNumbers &random, const LiverShape &shape) {
    constexpr int most = 8;
    constexpr int tries = 500;
    constexpr double smallest = 0.0052; // half its length [m]
    std::vector<Lesion> drawn(random.below(most + 1));
    for (auto &lesion : drawn)
        lesion = draw_lesion(random);
    const auto by_size = [](const Lesion &lesion) { return -lesion.semi_axes.prod(); };
    std::ranges::stable_sort(drawn, {}, by_size);
    const auto [low, high] = liver_bounding_box(shape);
    std::vector<Lesion> placed;
    for (auto &lesion : drawn)
        for (int attempt = 1; attempt > 0; ++attempt) {
            for (int c = 0; c < 3; ++c)
                lesion.center[c] = random.uniform(low[c], high[c]);
            if (has_room(lesion, placed, shape)) {
                placed.push_back(lesion);
                break;
            }
            if (attempt % tries == 0 && lesion.semi_axes.x() > smallest)
                lesion.semi_axes *= 0.9;
        }
    std::ranges::stable_sort(placed, {}, by_size);
    return placed;
}

} // namespace

LiverVariant draw_liver(int number) {
    if (number < 1)
        throw support::InputError(fmt::format(
            "there is no variant {} of the liver; give a number from 1, or 0 for the one that ships", number));
    RandomNumbers random(static_cast<std::uint64_t>(number));
    LiverVariant variant;
    variant.number = number;
    std::tie(variant.body_surface, variant.volume) = draw_person(random);
    auto &shape = variant.shape;
    shape = draw_shape(random);
    const LiverShape shipped;
    const auto relative = shape.metres_per_unit.cwiseQuotient(shipped.metres_per_unit);
    const auto extent = extent_of(shape);
    variant.front_to_back = relative.y() / cube_root(relative.prod());
    variant.has_riedel_lobe = shape.tongue_length > 0.0;
    variant.left_part = extent.left_part;
    shape.centroid += extent.centroid.cwiseQuotient(shape.metres_per_unit);
    shape.metres_per_unit *= cube_root(variant.volume / extent.volume);
    variant.lesions = draw_lesions(random, shape);
    return variant;
}

std::string to_text(const LiverVariant &variant) {
    const auto across = [](const Lesion &lesion) { return 2e3 * lesion.semi_axes.maxCoeff(); };
    std::string lesions = "no lesion";
    if (variant.lesions.size() == 1)
        lesions = fmt::format("1 lesion of {:.0f} mm", across(variant.lesions.front()));
    else if (!variant.lesions.empty())
        lesions = fmt::format("{} lesions of {:.0f} to {:.0f} mm", variant.lesions.size(),
                              across(std::ranges::min(variant.lesions, {}, across)),
                              across(std::ranges::max(variant.lesions, {}, across)));
    return fmt::format(
        "variant {}: {:.2f} L (body surface {:.2f} m^2), {:.0f} % of it in the left lobe, {:.2f} as thick "
        "from front to back as the liver that ships, {}, {}",
        variant.number, 1e3 * variant.volume, variant.body_surface, 100.0 * variant.left_part, variant.front_to_back,
        variant.has_riedel_lobe ? "Riedel's lobe" : "no Riedel's lobe", lesions);
}

} // namespace livermark::meshes
