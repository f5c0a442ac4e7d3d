#include "meshes/segmentation/program/image_slices.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "meshes/segmentation/images/label_roles.hpp"
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

/// Names of what a voxel may be in pictures; the index is what is written.
constexpr std::array part_names{"outside", "liver", "lesion", "vessel", "other"};

int part_of(const LabelPart &part) {
    using core::SegmentRole;
    switch (part.role) {
    case SegmentRole::liver:
        return 1;
    case SegmentRole::lesion:
    case SegmentRole::cyst:
        return 2;
    case SegmentRole::vessel:
        return part.region.empty() ? 4 : 3;
    default:
        return 4;
    }
}

/// Voxels from the first to the last along each axis.
struct VoxelBox {
    std::array<int, 3> first, last;
};

/// Calls visit(voxel, index) for each voxel of a box, with the first axis fastest.
template <class Visit> void for_each_voxel(const ImageGrid &grid, const VoxelBox &box, const Visit &visit) {
    std::array<int, 3> voxel{};
    for (voxel[2] = box.first[2]; voxel[2] <= box.last[2]; ++voxel[2])
        for (voxel[1] = box.first[1]; voxel[1] <= box.last[1]; ++voxel[1]) {
            const auto row = static_cast<std::size_t>(voxel[2]) * static_cast<std::size_t>(grid.size[1]) +
                             static_cast<std::size_t>(voxel[1]);
            for (voxel[0] = box.first[0]; voxel[0] <= box.last[0]; ++voxel[0])
                visit(voxel, row * static_cast<std::size_t>(grid.size[0]) + static_cast<std::size_t>(voxel[0]));
        }
}

/// The voxels of the liver and what is in it, with some around them.
VoxelBox box_around_body(const LabelImage &image, const std::vector<int> &part_of_label) {
    constexpr double around = 0.01; // [m]
    const auto &size = image.grid.size;
    VoxelBox box{size, {-1, -1, -1}};
    for_each_voxel(image.grid, {{0, 0, 0}, {size[0] - 1, size[1] - 1, size[2] - 1}},
                   [&](const std::array<int, 3> &voxel, std::size_t index) {
                       if (const int part = part_of_label[image.label[index]]; part == 0 || part == 4)
                           return;
                       for (std::size_t a = 0; a < 3; ++a) {
                           box.first.at(a) = std::min(box.first.at(a), voxel.at(a));
                           box.last.at(a) = std::max(box.last.at(a), voxel.at(a));
                       }
                   });
    for (int a = 0; a < 3; ++a) {
        const int more = static_cast<int>(std::ceil(around / image.grid.spacing[a]));
        box.first[a] = std::max(box.first[a] - more, 0);
        box.last[a] = std::min(box.last[a] + more, size[a] - 1);
    }
    return box;
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

int write_voxels(const VoxelCommand &command) {
    constexpr double most_voxels = 1 << 26; // of a byte each in the page
    constexpr std::size_t most_runs = 4'000'000;
    const auto image = read_label_image(command.labels);
    LabelChoice choice{command.liver, command.tumours};
    for (const auto &role : command.roles)
        choice.roles.push_back(chosen_role(role));
    std::vector<std::string> remarks; // said when the body was made
    std::vector<int> part_of_label(65536, 0);
    for (const auto &[label, part] : parts_of_labels(image, choice, remarks))
        part_of_label[static_cast<std::size_t>(label)] = part_of(part);
    const auto &grid = image.grid;
    const auto box = box_around_body(image, part_of_label);
    std::array<int, 3> size{};
    core::Vector3 origin = grid.origin;
    std::vector<std::string> steps;
    double num_voxels = 1.0;
    for (int a = 0; a < 3; ++a) {
        const core::Vector3 step = grid.spacing[a] * grid.direction.col(a);
        size[a] = box.last[a] - box.first[a] + 1;
        origin += box.first[a] * step;
        steps.push_back(numbers(step));
        num_voxels *= size[a];
    }
    std::vector<std::size_t> runs;
    const auto add = [&](const std::array<int, 3> &, std::size_t index) {
        const auto part = static_cast<std::size_t>(part_of_label[image.label[index]]);
        if (runs.empty() || runs[runs.size() - 2] != part)
            runs.insert(runs.end(), {part, 0});
        ++runs.back();
    };
    if (num_voxels <= most_voxels)
        for_each_voxel(grid, box, add);
    if (num_voxels > most_voxels || runs.size() > 2 * most_runs)
        throw support::InputError("{}: the body fills {} x {} x {} voxels of this image, more than the page shows; "
                                  "livermark mesh --picture draws three slices of it",
                                  command.labels, size[0], size[1], size[2]);
    support::write_whole(command.output,
                         fmt::format(R"({{"size": [{}], "origin": {}, "steps": [{}], "parts": ["{}"], "runs": [{}]}})"
                                     "\n",
                                     fmt::join(size, ", "), numbers(origin), fmt::join(steps, ", "),
                                     fmt::join(part_names, "\", \""), fmt::join(runs, ",")));
    return 0;
}

} // namespace livermark::segmentation
