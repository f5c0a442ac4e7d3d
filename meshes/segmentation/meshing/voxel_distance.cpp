#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <set>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/segmentation/images/segmentation.hpp"
#include "meshes/segmentation/meshing/patient_body.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;

/// Distances from the faces between the voxels of a body and all else.
class VoxelSurface {
  public:
    explicit VoxelSurface(const Segmentation &segmentation) : grid_(segmentation.grid), region_(segmentation.region) {}

    /// The distance of a place in the image [m], searched in growing cubes of voxels around it.
    double distance(const Vector3 &place) const {
        std::array<int, 3> centre{};
        for (Eigen::Index d = 0; d < 3; ++d)
            centre.at(static_cast<std::size_t>(d)) = static_cast<int>(std::lround(place[d] / grid_.spacing[d]));
        const double finest = grid_.spacing.minCoeff();
        const int most = *std::ranges::max_element(grid_.size);
        double square = HUGE_VAL;
        for (int reach = 2;; reach *= 2) {
            square = nearest_within(place, centre, reach * finest);
            // A face of a voxel that is not in the cube is farther than this.
            if (const double sure = (reach - 1) * finest; square <= sure * sure || reach > 2 * most)
                return std::sqrt(square);
        }
    }

  private:
    bool is_inside(const std::array<int, 3> &at) const {
        for (std::size_t d = 0; d < 3; ++d)
            if (at.at(d) < 0 || at.at(d) >= grid_.size.at(d))
                return false;
        const auto row = static_cast<std::size_t>(grid_.size[0]), slice = row * static_cast<std::size_t>(grid_.size[1]);
        return region_[static_cast<std::size_t>(at[0]) + row * static_cast<std::size_t>(at[1]) +
                       slice * static_cast<std::size_t>(at[2])] != 0;
    }

    double nearest_within(const Vector3 &place, const std::array<int, 3> &centre, double length) const {
        std::array<int, 3> reach{};
        for (std::size_t d = 0; d < 3; ++d)
            reach.at(d) = static_cast<int>(std::ceil(length / grid_.spacing[static_cast<Eigen::Index>(d)]));
        double square = HUGE_VAL;
        for (int k = centre[2] - reach[2]; k <= centre[2] + reach[2]; ++k)
            for (int j = centre[1] - reach[1]; j <= centre[1] + reach[1]; ++j)
                for (int i = centre[0] - reach[0]; i <= centre[0] + reach[0]; ++i)
                    square = std::min(square, nearest_face(place, {i, j, k}));
        return square;
    }

    /// The squared distance of the faces towards the end of each axis.
    double nearest_face(const Vector3 &place, const std::array<int, 3> &at) const {
        double square = HUGE_VAL;
        const bool is_in = is_inside(at);
        for (std::size_t across = 0; across < 3; ++across) {
            auto next = at;
            ++next.at(across);
            if (is_inside(next) == is_in)
                continue;
            double sum = 0.0;
            for (std::size_t d = 0; d < 3; ++d) {
                const double spacing = grid_.spacing[static_cast<Eigen::Index>(d)];
                const double off =
                    std::abs(place[static_cast<Eigen::Index>(d)] - spacing * (at.at(d) + (d == across ? 0.5 : 0.0)));
                const double beyond = d == across ? off : std::max(0.0, off - 0.5 * spacing);
                sum += beyond * beyond;
            }
            square = std::min(square, sum);
        }
        return square;
    }

    const ImageGrid &grid_;
    const std::vector<std::uint8_t> &region_;
};

} // namespace

SurfaceDistance distance_from_voxels(const core::TetraMesh &mesh, const Segmentation &segmentation) {
    const VoxelSurface surface(segmentation);
    const auto &grid = segmentation.grid;
    std::vector<double> distances;
    const auto add = [&](const Vector3 &world) {
        distances.push_back(surface.distance(grid.direction.transpose() * (world - grid.origin)));
    };
    std::set<int> nodes;
    const auto point = [&](int node) { return mesh.points[static_cast<std::size_t>(node)]; };
    for (const auto &[a, b, c] : mesh.boundary_triangles) {
        add((point(a) + point(b) + point(c)) / 3.0);
        nodes.insert({a, b, c});
    }
    for (const int node : nodes)
        add(point(node));
    if (distances.empty())
        return {};
    std::ranges::sort(distances);
    const auto percentile = [&](double share) {
        return distances[static_cast<std::size_t>(share * static_cast<double>(distances.size() - 1))];
    };
    return {percentile(0.5), percentile(0.95), distances.back()};
}

std::string to_text(const SurfaceDistance &distance) {
    return fmt::format("surface to voxels {:.2f} mm median, {:.2f} mm 95 %, {:.2f} mm worst\n", 1e3 * distance.median,
                       1e3 * distance.percentile_95, 1e3 * distance.worst);
}

} // namespace livermark::segmentation
