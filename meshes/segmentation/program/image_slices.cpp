#include "meshes/segmentation/program/image_slices.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

namespace {

std::string numbers(const core::Vector3 &v) {
    return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", v.x(), v.y(), v.z());
}

/// The voxel that is nearest to a place in the world.
std::array<int, 3> voxel_at(const ImageGrid &grid, const core::Vector3 &place) {
    const core::Vector3 along = grid.direction.transpose() * (place - grid.origin);
    std::array<int, 3> voxel{};
    for (int a = 0; a < 3; ++a)
        voxel[a] = static_cast<int>(
            std::clamp(std::round(along[a] / grid.spacing[a]), 0.0, static_cast<double>(grid.size[a] - 1)));
    return voxel;
}

/// JSON of the plane of voxels through one, across an axis of the image.
std::string plane_across(int axis, const std::array<int, 3> &through, const LabelImage &image) {
    const auto &grid = image.grid;
    const int right = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
    const auto step = [&](int a) -> core::Vector3 { return grid.spacing[a] * grid.direction.col(a); };
    const core::Vector3 origin = grid.origin + through[axis] * step(axis);
    std::vector<int> label;
    label.reserve(static_cast<std::size_t>(grid.size[right]) * static_cast<std::size_t>(grid.size[up]));
    auto voxel = through;
    for (voxel[up] = 0; voxel[up] < grid.size[up]; ++voxel[up])
        for (voxel[right] = 0; voxel[right] < grid.size[right]; ++voxel[right]) {
            const auto row = static_cast<std::size_t>(voxel[2]) * static_cast<std::size_t>(grid.size[1]) +
                             static_cast<std::size_t>(voxel[1]);
            label.push_back(
                image.label[row * static_cast<std::size_t>(grid.size[0]) + static_cast<std::size_t>(voxel[0])]);
        }
    return fmt::format(R"({{"size": [{}, {}], "origin": {}, "right": {}, "up": {}, "label": [{}]}})", grid.size[right],
                       grid.size[up], numbers(origin), numbers(step(right)), numbers(step(up)), fmt::join(label, ","));
}

} // namespace

int write_slices(const SliceCommand &command) {
    const auto image = read_label_image(command.labels);
    const auto through = voxel_at(image.grid, {command.at.at(0), command.at.at(1), command.at.at(2)});
    std::vector<std::string> planes;
    for (int axis = 0; axis < 3; ++axis)
        planes.push_back(plane_across(axis, through, image));
    support::write_whole(command.output, fmt::format("{{\"planes\": [{}]}}\n", fmt::join(planes, ",\n")));
    return 0;
}

} // namespace livermark::segmentation
