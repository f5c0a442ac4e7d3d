#include "meshes/segmentation/images/segmentation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <random>
#include <vector>

#include "meshes/generators/liver_shape.hpp"
#include "meshes/generators/liver_vessels.hpp"

/// The phantom: the liver that ships as a label image, a scan or a map of stiffness.
namespace livermark::segmentation {

namespace {

using core::Vector3;

constexpr double margin = 0.01; // of air around the liver [m]
constexpr double liver_value = 110.0, lesion_value = 70.0, vessel_value = 170.0, fat_value = -90.0,
                 noise = 12.0; // [HU]

Eigen::Matrix3d rotation(const Vector3 &turn) {
    const double angle = turn.norm();
    return angle == 0.0 ? Eigen::Matrix3d::Identity().eval()
                        : Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

/// The smallest grid of these axes that holds the liver.
ImageGrid grid_around_liver(const PhantomOptions &options) {
    ImageGrid grid{.spacing = options.spacing, .direction = rotation(options.turn)};
    const auto [low, high] = meshes::liver_bounding_box();
    const Eigen::AlignedBox3d liver(low, high);
    Eigen::AlignedBox3d along; // the axes of the grid
    for (int corner = 0; corner < 8; ++corner) {
        const Vector3 point = liver.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
        along.extend(Vector3(grid.direction.transpose() * point));
    }
    const Vector3 first = along.min().array() - margin;
    const Vector3 last = along.max().array() + margin;
    grid.origin = grid.direction * first;
    for (int d = 0; d < 3; ++d)
        grid.size[static_cast<std::size_t>(d)] =
            1 + static_cast<int>(std::ceil((last[d] - first[d]) / grid.spacing[d]));
    return grid;
}

std::vector<meshes::Lesion> lesions(bool touching) {
    auto all = meshes::liver_lesions();
    if (touching) {
        auto &outer = all[1];
        while (meshes::liver_level(outer.center) < -0.5 * outer.semi_axes.minCoeff())
            outer.center += 1e-3 * meshes::liver_gradient(outer.center).normalized();
        auto &neighbour = all[4];
        const Vector3 apart = neighbour.center - all[0].center;
        neighbour.center =
            all[0].center + (all[0].semi_axes.mean() + 0.8 * neighbour.semi_axes.mean()) * apart.normalized();
    }
    return all;
}

bool holds(const meshes::Lesion &lesion, const Vector3 &point) {
    Vector3 scaled;
    for (int d = 0; d < 3; ++d)
        scaled[d] = lesion.axes[static_cast<std::size_t>(d)].dot(point - lesion.center) / lesion.semi_axes[d];
    return scaled.squaredNorm() < 1.0;
}

/// A straight piece of a vessel, with rounded ends.
struct Tube {
    int label;
    Vector3 begin, end; ///< of its axis [m]
    double radius;      ///< [m]
};

bool holds(const Tube &tube, const Vector3 &point) {
    const Vector3 axis = tube.end - tube.begin, to_point = point - tube.begin;
    const double along = std::clamp(to_point.dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    return (to_point - along * axis).norm() < tube.radius;
}

/// The parts of the phantom.
struct Parts {
    std::vector<meshes::Lesion> lesions;
    std::vector<Tube> tubes;
};

Parts parts_of(const PhantomOptions &options) {
    Parts parts{lesions(options.touching), {}};
    if (options.vessels)
        for (const auto &trunk : meshes::liver_vein_trunks())
            parts.tubes.push_back(
                {trunk.vein == meshes::LiverVein::hepatic ? phantom_hepatic_label : phantom_portal_label, trunk.begin,
                 trunk.end, trunk.radius});
    return parts;
}

/// @return label at a place in the world
int label_at(const Vector3 &point, const Parts &parts) {
    if (meshes::liver_level(point) >= 0.0)
        return 0;
    for (std::size_t l = 0; l < parts.lesions.size(); ++l)
        if (holds(parts.lesions[l], point))
            return phantom_first_tumour_label + static_cast<int>(l);
    for (const auto &tube : parts.tubes)
        if (holds(tube, point))
            return tube.label;
    return phantom_liver_label;
}

double grey_value_of(int label) {
    if (label == 0)
        return fat_value;
    if (label == phantom_liver_label)
        return liver_value;
    return label >= phantom_hepatic_label ? vessel_value : lesion_value;
}

/// Calls visit(voxel, its centre in the world) in the order of the data.
template <class Visit> void for_each_voxel(const ImageGrid &grid, const Visit &visit) {
    std::size_t voxel = 0;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i)
                visit(voxel++, to_world(grid, Vector3(i, j, k).cwiseProduct(grid.spacing)));
}

} // namespace

LabelImage phantom_labels(const PhantomOptions &options) {
    const auto all = parts_of(options);
    LabelImage image{.name = "phantom", .grid = grid_around_liver(options), .label = {}};
    image.label.resize(num_voxels(image.grid));
    for_each_voxel(image.grid, [&](std::size_t voxel, const Vector3 &centre) {
        image.label[voxel] = static_cast<std::uint16_t>(label_at(centre, all));
    });
    if (!options.vessels)
        return image; // numbers alone, as most programs write them
    image.label_names = {
        {phantom_liver_label, "Liver"}, {phantom_hepatic_label, "Hepatic vein"}, {phantom_portal_label, "Portal vein"}};
    for (std::size_t l = 0; l < all.lesions.size(); ++l)
        image.label_names.emplace(phantom_first_tumour_label + static_cast<int>(l), fmt::format("Tumour {}", l + 1));
    return image;
}

Scan phantom_scan(const PhantomOptions &options) {
    const auto all = parts_of(options);
    Scan scan{.grid = grid_around_liver(options), .grey_value = {}};
    scan.grey_value.resize(num_voxels(scan.grid));
    std::mt19937 random(1);
    for_each_voxel(scan.grid, [&](std::size_t voxel, const Vector3 &centre) {
        double value = 0.0;
        for (int part = 0; part < 8; ++part) { // a voxel shows the mean of what is in it
            const Vector3 place((part & 1) - 0.5, (part >> 1 & 1) - 0.5, (part >> 2) - 0.5);
            const Vector3 part_centre = centre + scan.grid.direction * (0.5 * place.cwiseProduct(scan.grid.spacing));
            value += grey_value_of(label_at(part_centre, all)) / 8.0;
        }
        // Twelve uniform numbers add up to a normal one of variance 1, the same with every standard library.
        double normal = -6.0;
        for (int part = 0; part < 12; ++part)
            normal += static_cast<double>(random()) / 4294967296.0;
        scan.grey_value[voxel] = static_cast<std::int16_t>(std::lround(value + noise * normal));
    });
    return scan;
}

Scan phantom_stiffness(const PhantomOptions &options) {
    constexpr double young_over_shear = 2.9; // at Poisson's ratio 0.45
    struct Wave {
        Vector3 along;
        double length, phase; ///< [m], [rad]
    };
    const std::array<Wave, 3> waves{
        {{{1.0, 0.3, 0.2}, 0.095, 0.3}, {{-0.2, 1.0, 0.4}, 0.075, 1.9}, {{0.3, -0.4, 1.0}, 0.060, 4.1}}};
    const auto all = parts_of(options);
    Scan scan{.grid = grid_around_liver(options), .grey_value = {}};
    scan.grey_value.resize(num_voxels(scan.grid));
    for_each_voxel(scan.grid, [&](std::size_t voxel, const Vector3 &centre) {
        const int label = label_at(centre, all);
        double exponent = 0.0;
        for (const auto &[along, length, phase] : waves)
            exponent += 0.2 * std::cos(2.0 * std::numbers::pi / length * along.normalized().dot(centre) + phase);
        const bool has_none = label == 0 || label >= phantom_hepatic_label; // blood bears no shear wave
        const double young_modulus = has_none ? 0.0 : label == phantom_liver_label ? 5e3 * std::exp(exponent) : 50e3;
        scan.grey_value[voxel] = static_cast<std::int16_t>(std::lround(young_modulus / young_over_shear));
    });
    return scan;
}

} // namespace livermark::segmentation
