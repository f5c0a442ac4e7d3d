#include "meshes/segmentation/images/stiffness_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <optional>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;

/// Part of a tetrahedron, of the body, and of the weights of eight voxels, of which something has to be known.
constexpr double least_part = 0.5;
constexpr int most_divisions = 10;

/// Modulus at a place [Pa]; nothing where most of what is around it is a hole or outside of the image.
std::optional<double> modulus_at(const StiffnessMap &map, const Vector3 &world) {
    const auto &grid = map.grid;
    const Vector3 place = (grid.direction.transpose() * (world - grid.origin)).cwiseQuotient(grid.spacing);
    const Vector3 low = place.array().floor();
    const Vector3 part = place - low;
    double sum = 0.0, weights = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        std::array<int, 3> voxel{};
        double weight = 1.0;
        bool is_inside = true;
        for (int d = 0; d < 3; ++d) {
            const int up = corner >> d & 1;
            const double at = low[d] + up;
            weight *= up == 1 ? part[d] : 1.0 - part[d];
            is_inside = is_inside && at >= 0.0 && at <= grid.size.at(d) - 1.0;
            voxel.at(d) = is_inside ? static_cast<int>(at) : 0;
        }
        if (!is_inside || weight == 0.0)
            continue;
        const auto number = voxel[0] + static_cast<std::size_t>(grid.size[0]) *
                                           (voxel[1] + static_cast<std::size_t>(grid.size[1]) * voxel[2]);
        if (const double value = map.modulus[number]; !std::isnan(value)) {
            sum += weight * value;
            weights += weight;
        }
    }
    if (weights < least_part)
        return std::nullopt;
    return sum / weights;
}

/// Mean over a tetrahedron [Pa], NaN where less than half of it is known.
double mean_over(const StiffnessMap &map, const std::array<Vector3, 4> &corners) {
    double longest = 0.0;
    for (const auto &[i, j] : core::tetrahedron_edges)
        longest = std::max(longest, (corners.at(i) - corners.at(j)).norm());
    const int divisions =
        std::clamp(static_cast<int>(std::ceil(longest / map.grid.spacing.minCoeff())), 2, most_divisions);
    double sum = 0.0;
    int num_known = 0, num_points = 0;
    for (int i = 0; i < divisions; ++i)
        for (int j = 0; i + j < divisions; ++j)
            for (int k = 0; i + j + k < divisions; ++k) {
                const int l = divisions - 1 - i - j - k;
                const Vector3 place = ((i + 0.25) * corners[0] + (j + 0.25) * corners[1] + (k + 0.25) * corners[2] +
                                       (l + 0.25) * corners[3]) /
                                      divisions;
                ++num_points;
                if (const auto modulus = modulus_at(map, place)) {
                    sum += *modulus;
                    ++num_known;
                }
            }
    return num_known >= least_part * num_points ? sum / num_known : std::numeric_limits<double>::quiet_NaN();
}

std::string box_text(const Vector3 &low, const Vector3 &high) {
    return fmt::format("x {:.0f} to {:.0f}, y {:.0f} to {:.0f}, z {:.0f} to {:.0f} mm", 1e3 * low.x(), 1e3 * high.x(),
                       1e3 * low.y(), 1e3 * high.y(), 1e3 * low.z(), 1e3 * high.z());
}

/// Box around an image in the world.
std::string box_text(const ImageGrid &grid) {
    Eigen::AlignedBox3d box;
    for (int corner = 0; corner < 8; ++corner) {
        Vector3 place = grid.origin;
        for (int d = 0; d < 3; ++d)
            if ((corner >> d & 1) == 1)
                place += (grid.size.at(d) - 1) * grid.spacing[d] * grid.direction.col(d);
        box.extend(place);
    }
    return box_text(box.min(), box.max());
}

/// Median modulus of a map of soft tissue [Pa].
constexpr double softest = 200.0, stiffest = 200e3;

} // namespace

StiffnessMap read_stiffness_map(const std::filesystem::path &file, const StiffnessValues &values) {
    auto read = read_scalar_image(file);
    StiffnessMap map{.name = read.name,
                     .grid = read.grid,
                     .modulus = std::move(read.value),
                     .is_shear = values.is_shear,
                     .remarks = read.remarks};
    std::vector<float> known;
    for (auto &value : map.modulus) {
        const bool is_hole = !std::isfinite(value) || value <= 0.0F;
        value = is_hole ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(values.pascals * value);
        if (!is_hole)
            known.push_back(value);
    }
    if (known.empty())
        throw support::InputError("{}: no voxel has a positive value; give an image of the shear or Young's modulus",
                                  read.name);
    const auto middle = known.begin() + std::ssize(known) / 2;
    std::ranges::nth_element(known, middle);
    if (!(*middle >= softest && *middle <= stiffest))
        throw support::InputError("{}: half of its values are below {:.3g} Pa, where a modulus of soft tissue is {:g} "
                                  "to {:g} Pa; say with --unit whether they are in Pa or kPa",
                                  read.name, *middle, softest, stiffest);
    return map;
}

MappedModulus mapped_modulus(const StiffnessMap &map, const core::Body &body) {
    const auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    MappedModulus mapped{{}, map.remarks};
    double known = 0.0, whole = 0.0, sum = 0.0;
    double least = std::numeric_limits<double>::infinity(), largest = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        const double young_over_modulus =
            map.is_shear ? 2.0 * (1.0 + body.materials[mesh.region[t]].poisson_ratio) : 1.0;
        const double modulus =
            young_over_modulus * mean_over(map, {mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]});
        mapped.young_modulus.push_back(modulus);
        whole += volumes[t];
        if (std::isnan(modulus))
            continue;
        known += volumes[t];
        sum += volumes[t] * modulus;
        least = std::min(least, modulus);
        largest = std::max(largest, modulus);
    }
    if (known < least_part * whole) {
        const auto box = core::bounding_box(mesh.points);
        throw support::InputError(
            "{}: it has values in {:.0f} % of the body, and at least {:.0f} % are needed; the map "
            "lies at {}, the body at {}; give the map of this patient, in the same coordinates",
            map.name, 100.0 * known / whole, 100.0 * least_part, box_text(map.grid), box_text(box.min(), box.max()));
    }
    mapped.remarks.push_back(fmt::format("Young's modulus of {} is {:.0f} Pa in the mean, {:.0f} to {:.0f} Pa",
                                         map.name, sum / known, least, largest));
    if (known < whole)
        mapped.remarks.push_back(
            fmt::format("{:.2g} % of the body has no value in it, and gets the modulus of its region",
                        100.0 * (1.0 - known / whole)));
    return mapped;
}

} // namespace livermark::segmentation
