#include "segmentation/images/label_fields.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace livermark::segmentation {

namespace {

using core::Vector3;

/// Indices along the three axes, the last not included.
struct Block {
    std::array<int, 3> begin = {0, 0, 0};
    std::array<int, 3> end = {0, 0, 0};

    int length(int axis) const { return end[axis] - begin[axis]; }
};

struct FieldGrid {
    std::array<int, 3> size;
    double spacing;
    Vector3 low;
};

/// Width of the Gaussian [m]. Along every axis that of the thickest voxels, because it is the steps between slices that
/// have to go, and they lie across the slices' plane as well where the surface is slanted.
double smoothing_width(const ImageGrid &grid, double spacing) {
    return std::max(0.7 * grid.spacing.maxCoeff(), 0.6 * spacing);
}

/// The voxels that a region's lie among; nothing is between begin and end of a region that has none.
std::vector<Block> bounding_blocks(const Segmentation &segmentation) {
    const auto &size = segmentation.grid.size;
    std::vector<Block> blocks(segmentation.region_names.size(), Block{size, {0, 0, 0}});
    std::size_t voxel = 0;
    for (int k = 0; k < size[2]; ++k)
        for (int j = 0; j < size[1]; ++j)
            for (int i = 0; i < size[0]; ++i)
                if (const int region = segmentation.region[voxel++]; region != 0) {
                    const std::array place{i, j, k};
                    auto &block = blocks[region - 1];
                    for (int d = 0; d < 3; ++d) {
                        block.begin[d] = std::min(block.begin[d], place[d]);
                        block.end[d] = std::max(block.end[d], place[d] + 1);
                    }
                }
    return blocks;
}

/// Room for the body and all of its blurred border, whether the image has it or not.
FieldGrid field_grid(const ImageGrid &image, const std::vector<Block> &blocks, double spacing) {
    const double margin = 4.0 * smoothing_width(image, spacing) + 2.0 * spacing;
    FieldGrid grid{{0, 0, 0}, spacing, {0.0, 0.0, 0.0}};
    for (int d = 0; d < 3; ++d) {
        int begin = image.size[d];
        int end = 0;
        for (const auto &block : blocks) {
            begin = std::min(begin, block.begin[d]);
            end = std::max(end, block.end[d]);
        }
        const double extent = std::max(0, end - begin) * image.spacing[d] + 2.0 * margin;
        grid.low[d] = (begin - 0.5) * image.spacing[d] - margin;
        grid.size[d] = 1 + static_cast<int>(std::ceil(extent / spacing));
    }
    return grid;
}

/// The part of the grid that the blurred voxels of a block reach.
Block reach(const ImageGrid &image, const FieldGrid &grid, const Block &voxels) {
    const double far = 4.0 * smoothing_width(image, grid.spacing);
    Block samples;
    for (int d = 0; d < 3; ++d) {
        const double low = (voxels.begin[d] - 0.5) * image.spacing[d] - far - grid.low[d];
        const double high = (voxels.end[d] - 0.5) * image.spacing[d] + far - grid.low[d];
        samples.begin[d] = std::clamp(static_cast<int>(std::ceil(low / grid.spacing)), 0, grid.size[d]);
        samples.end[d] = std::clamp(static_cast<int>(std::floor(high / grid.spacing)) + 1, 0, grid.size[d]);
    }
    return samples;
}

/// Convolution along one axis, from voxels to samples: the integral of the Gaussian over each voxel, so that no
/// interpolation of the image comes in.
/// @param values  block of voxels along the axis; lengths of the axes in `length`, which changes with them
std::vector<float> convolve(const std::vector<float> &values, std::array<int, 3> &length, int axis,
                            const ImageGrid &image, const FieldGrid &grid, const Block &voxels, const Block &samples) {
    const double width = smoothing_width(image, grid.spacing);
    const std::size_t inner = axis == 0 ? 1 : (axis == 1 ? length[0] : std::size_t(length[0]) * length[1]);
    const std::size_t num_in = length[axis];
    const std::size_t num_out = samples.length(axis);
    const std::size_t outer = values.size() / (inner * num_in);
    std::vector<float> result(inner * num_out * outer, 0.0F);
    for (std::size_t out = 0; out < num_out; ++out) {
        const double place = grid.low[axis] + grid.spacing * (samples.begin[axis] + static_cast<double>(out));
        const auto below = [&](double border) {
            return 0.5 * std::erf((border - place) / (std::numbers::sqrt2 * width));
        };
        for (std::size_t in = 0; in < num_in; ++in) {
            const double center = image.spacing[axis] * (voxels.begin[axis] + static_cast<double>(in));
            const auto weight = static_cast<float>(below(center + 0.5 * image.spacing[axis]) -
                                                   below(center - 0.5 * image.spacing[axis]));
            if (weight < 1e-6F)
                continue;
            for (std::size_t o = 0; o < outer; ++o) {
                const float *from = &values[(o * num_in + in) * inner];
                float *to = &result[(o * num_out + out) * inner];
                for (std::size_t i = 0; i < inner; ++i)
                    to[i] += weight * from[i];
            }
        }
    }
    length[axis] = static_cast<int>(num_out);
    return result;
}

std::vector<float> region_field(const Segmentation &segmentation, std::size_t region, const FieldGrid &grid,
                                const Block &voxels) {
    const auto &image = segmentation.grid;
    std::vector<float> field(std::size_t(grid.size[0]) * grid.size[1] * grid.size[2], 0.0F);
    if (voxels.length(0) <= 0)
        return field;
    std::vector<float> values;
    for (int k = voxels.begin[2]; k < voxels.end[2]; ++k)
        for (int j = voxels.begin[1]; j < voxels.end[1]; ++j)
            for (int i = voxels.begin[0]; i < voxels.end[0]; ++i) {
                const std::size_t voxel = i + std::size_t(image.size[0]) * (j + std::size_t(image.size[1]) * k);
                values.push_back(segmentation.region[voxel] == region + 1 ? 1.0F : 0.0F);
            }
    const Block samples = reach(image, grid, voxels);
    std::array<int, 3> length{voxels.length(0), voxels.length(1), voxels.length(2)};
    for (int axis = 0; axis < 3; ++axis)
        values = convolve(values, length, axis, image, grid, voxels, samples);

    std::size_t next = 0;
    for (int k = samples.begin[2]; k < samples.end[2]; ++k)
        for (int j = samples.begin[1]; j < samples.end[1]; ++j)
            for (int i = samples.begin[0]; i < samples.end[0]; ++i)
                field[i + std::size_t(grid.size[0]) * (j + std::size_t(grid.size[1]) * k)] = values[next++];
    return field;
}

} // namespace

LabelFields label_fields(const Segmentation &segmentation, double spacing) {
    const auto blocks = bounding_blocks(segmentation);
    const FieldGrid grid = field_grid(segmentation.grid, blocks, spacing);
    LabelFields fields{grid.size, grid.spacing, grid.low, {}, region_volumes(segmentation)};
    for (std::size_t region = 0; region < blocks.size(); ++region)
        fields.inside.push_back(region_field(segmentation, region, grid, blocks[region]));
    return fields;
}

} // namespace livermark::segmentation
