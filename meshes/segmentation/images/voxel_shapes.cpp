#include "meshes/segmentation/images/voxel_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <itkImage.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>

namespace livermark::segmentation {

namespace {

/// A part of a grid, which may reach over its ends.
struct VoxelBox {
    std::array<int, 3> begin = {0, 0, 0};
    std::array<int, 3> size = {0, 0, 0};

    std::size_t num_voxels() const {
        return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
               static_cast<std::size_t>(size[2]);
    }
};

/// The box around a set with some room [m]; of size 0 around none.
VoxelBox box_around(const ImageGrid &grid, const VoxelSet &set, double room) {
    std::array<int, 3> low = grid.size, high = {-1, -1, -1};
    std::size_t voxel = 0;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i)
                if (set[voxel++] != 0)
                    for (std::size_t d = 0; d < 3; ++d) {
                        low.at(d) = std::min(low.at(d), std::array{i, j, k}.at(d));
                        high.at(d) = std::max(high.at(d), std::array{i, j, k}.at(d));
                    }
    VoxelBox box;
    if (high[0] < 0)
        return box;
    for (std::size_t d = 0; d < 3; ++d) {
        const int further = 1 + static_cast<int>(std::ceil(room / grid.spacing[static_cast<Eigen::Index>(d)]));
        box.begin.at(d) = low.at(d) - further;
        box.size.at(d) = high.at(d) - low.at(d) + 1 + 2 * further;
    }
    return box;
}

/// Calls visit(voxel of the box, voxel of the grid) where both have one.
template <class Visit> void for_each_shared(const ImageGrid &grid, const VoxelBox &box, const Visit &visit) {
    std::size_t in_box = 0;
    for (int k = 0; k < box.size[2]; ++k)
        for (int j = 0; j < box.size[1]; ++j)
            for (int i = 0; i < box.size[0]; ++i, ++in_box) {
                const std::array place{box.begin[0] + i, box.begin[1] + j, box.begin[2] + k};
                bool is_in_grid = true;
                for (std::size_t d = 0; d < 3; ++d)
                    is_in_grid = is_in_grid && place.at(d) >= 0 && place.at(d) < grid.size.at(d);
                if (is_in_grid)
                    visit(in_box, static_cast<std::size_t>(place[0]) + static_cast<std::size_t>(grid.size[0]) *
                                                                           (static_cast<std::size_t>(place[1]) +
                                                                            static_cast<std::size_t>(grid.size[1]) *
                                                                                static_cast<std::size_t>(place[2])));
            }
}

/// Whether each voxel of a box is nearer than a radius to one of a set, centre to centre.
VoxelSet nearer_than(const ImageGrid &grid, const VoxelBox &box, const VoxelSet &set, double radius) {
    using Mask = itk::Image<std::uint8_t, 3>;
    using Squares = itk::Image<float, 3>;
    VoxelSet near(set.size(), 0);
    if (std::ranges::find(set, 1) == set.end())
        return near;
    auto mask = Mask::New();
    Mask::SizeType size;
    Mask::SpacingType spacing;
    for (unsigned d = 0; d < 3; ++d) {
        size[d] = static_cast<itk::SizeValueType>(box.size.at(d));
        spacing[d] = grid.spacing[d];
    }
    mask->SetRegions(size);
    mask->SetSpacing(spacing);
    mask->Allocate();
    std::ranges::copy(set, mask->GetBufferPointer());
    auto squares = itk::SignedMaurerDistanceMapImageFilter<Mask, Squares>::New();
    squares->SetInput(mask);
    squares->SquaredDistanceOn();
    squares->UseImageSpacingOn();
    squares->InsideIsPositiveOff();
    squares->Update();
    const float *const square = squares->GetOutput()->GetBufferPointer(); // not above 0 in the set
    for (std::size_t v = 0; v < near.size(); ++v)
        near[v] = static_cast<double>(square[v]) < radius * radius * (1.0 - 1e-6) ? 1 : 0;
    return near;
}

VoxelSet complement(VoxelSet set) {
    for (auto &voxel : set)
        voxel = voxel == 0 ? 1 : 0;
    return set;
}

VoxelSet cut_out(const ImageGrid &grid, const VoxelBox &box, const VoxelSet &set) {
    VoxelSet part(box.num_voxels(), 0);
    for_each_shared(grid, box, [&](std::size_t in_box, std::size_t in_grid) { part[in_box] = set[in_grid]; });
    return part;
}

} // namespace

VoxelSet closed_by_ball(const ImageGrid &grid, const VoxelSet &set, double radius) {
    const auto box = box_around(grid, set, radius);
    VoxelSet result = set;
    if (box.num_voxels() == 0 || !(radius > 0.0))
        return result;
    const auto reached = complement(nearer_than(grid, box, cut_out(grid, box, set), radius));
    const auto outside_of_it = nearer_than(grid, box, reached, radius);
    for_each_shared(grid, box, [&](std::size_t in_box, std::size_t in_grid) {
        if (outside_of_it[in_box] == 0)
            result[in_grid] = 1;
    });
    return result;
}

VoxelSet opened_by_ball(const ImageGrid &grid, const VoxelSet &set, double radius) {
    const auto box = box_around(grid, set, 0.0);
    if (box.num_voxels() == 0 || !(radius > 0.0))
        return set;
    const auto centres = complement(nearer_than(grid, box, complement(cut_out(grid, box, set)), radius));
    const auto covered = nearer_than(grid, box, centres, radius);
    VoxelSet result(set.size(), 0);
    for_each_shared(grid, box, [&](std::size_t in_box, std::size_t in_grid) {
        result[in_grid] = set[in_grid] != 0 && covered[in_box] != 0 ? 1 : 0;
    });
    return result;
}

} // namespace livermark::segmentation
