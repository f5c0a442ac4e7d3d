#include "meshes/segmentation/meshing/mesh_operations.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
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

namespace {

/// The cube of samples around a place, and how far in it lies.
struct Cell {
    std::array<std::size_t, 8> sample;
    std::array<double, 8> share;
};

bool find_cell(const LabelFields &fields, const Vector3 &place, Cell &cell) {
    std::array<std::size_t, 3> index;
    Vector3 part;
    for (int d = 0; d < 3; ++d) {
        const double position = (place[d] - fields.low[d]) / fields.spacing;
        if (!(position >= 0.0 && position < fields.size[d] - 1))
            return false;
        index[d] = static_cast<std::size_t>(position);
        part[d] = position - static_cast<double>(index[d]);
    }
    const std::size_t row = fields.size[0];
    const std::size_t slice = row * fields.size[1];
    const std::size_t first = index[0] + row * index[1] + slice * index[2];
    for (std::size_t c = 0; c < 8; ++c) {
        const bool x = (c & 1U) != 0;
        const bool y = (c & 2U) != 0;
        const bool z = (c & 4U) != 0;
        cell.sample[c] = first + (x ? 1 : 0) + (y ? row : 0) + (z ? slice : 0);
        cell.share[c] = (x ? part[0] : 1.0 - part[0]) * (y ? part[1] : 1.0 - part[1]) * (z ? part[2] : 1.0 - part[2]);
    }
    return true;
}

double interpolate(const std::vector<float> &values, const Cell &cell) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 8; ++c)
        sum += cell.share[c] * static_cast<double>(values[cell.sample[c]]);
    return sum;
}

/// The level that splits values so that `count` of them are above (or all, or none).
double split(std::vector<double> values, double count) {
    const auto above = static_cast<std::size_t>(std::clamp(std::round(count), 0.0, static_cast<double>(values.size())));
    std::ranges::sort(values, std::greater());
    if (values.empty() || above == values.size())
        return 0.0;
    return above == 0 ? values.front() : 0.5 * (values[above - 1] + values[above]);
}

/// The weighted field of the strongest region but one.
double strongest_other(const LabelDomain &domain, std::size_t sample, std::size_t region) {
    double strongest = 0.0;
    for (std::size_t r = 0; r < domain.weight.size(); ++r)
        if (r != region)
            strongest = std::max(strongest, domain.weight[r] * static_cast<double>(domain.fields.inside[r][sample]));
    return strongest;
}

void match_threshold(LabelDomain &domain) {
    double volume = 0.0;
    for (const double v : domain.fields.volume)
        volume += v;
    std::vector<double> values;
    for (const float value : domain.body)
        if (value > 0.0F)
            values.push_back(static_cast<double>(value));
    // Far from 1/2 only for a body that is thinner than its blurred border.
    domain.threshold = std::clamp(split(values, volume / std::pow(domain.fields.spacing, 3)), 0.1, 0.9);
}

/// A region wins a sample where its field over the strongest other is above 1 / weight.
void match_weight(LabelDomain &domain, std::size_t region) {
    std::vector<double> lead;
    for (std::size_t sample = 0; sample < domain.body.size(); ++sample) {
        const auto value = static_cast<double>(domain.fields.inside[region][sample]);
        if (value > 1e-3 && static_cast<double>(domain.body[sample]) > domain.threshold)
            lead.push_back(value / std::max(1e-9, strongest_other(domain, sample, region)));
    }
    const double count = domain.fields.volume[region] / std::pow(domain.fields.spacing, 3);
    domain.weight[region] = 1.0 / std::clamp(split(lead, count), 0.01, 100.0);
}

std::int16_t winner(const LabelDomain &domain, std::size_t sample) {
    if (!(static_cast<double>(domain.body[sample]) > domain.threshold))
        return outside;
    std::size_t best = 0;
    double strongest = -1.0;
    for (std::size_t r = 0; r < domain.weight.size(); ++r)
        if (const double value = domain.weight[r] * static_cast<double>(domain.fields.inside[r][sample]);
            value > strongest) {
            strongest = value;
            best = r;
        }
    return static_cast<std::int16_t>(best);
}

} // namespace

LabelDomain match_volumes(LabelFields fields) {
    LabelDomain domain;
    domain.body.assign(fields.inside.front().size(), 0.0F);
    for (const auto &inside : fields.inside)
        for (std::size_t sample = 0; sample < inside.size(); ++sample)
            domain.body[sample] += inside[sample];
    domain.weight.assign(fields.inside.size(), 1.0);
    domain.fields = std::move(fields);
    match_threshold(domain);
    // Lesions that touch take from each other, so a few rounds; the first region is what they leave.
    const int rounds = domain.weight.size() > 2 ? 3 : 1;
    for (int round = 0; round < rounds; ++round)
        for (std::size_t region = 1; region < domain.weight.size(); ++region)
            match_weight(domain, region);
    for (std::size_t sample = 0; sample < domain.body.size(); ++sample)
        domain.label.push_back(winner(domain, sample));
    return domain;
}

int label_at(const LabelDomain &domain, const Vector3 &place) {
    Cell cell;
    if (!find_cell(domain.fields, place, cell))
        return outside;
    // Where all corners agree so does what lies between them.
    const int first = domain.label[cell.sample[0]];
    if (std::ranges::all_of(cell.sample, [&](std::size_t sample) { return domain.label[sample] == first; }))
        return first;
    if (!(interpolate(domain.body, cell) > domain.threshold))
        return outside;
    // A region that wins none of the corners is left out: it could be no more than a speck between them.
    int best = outside;
    double strongest = -1.0;
    for (std::size_t c = 0; c < cell.sample.size(); ++c) {
        const int label = domain.label[cell.sample[c]];
        if (label == outside || label == best)
            continue;
        const double value = domain.weight[label] * interpolate(domain.fields.inside[label], cell);
        if (value > strongest || (value == strongest && label < best)) {
            strongest = value;
            best = label;
        }
    }
    return best;
}

Levels level_differences(const LabelDomain &domain, const Vector3 &place, const std::vector<int> &labels) {
    Levels levels = Levels::Zero(static_cast<Eigen::Index>(labels.size()) - 1);
    Cell cell;
    if (!find_cell(domain.fields, place, cell))
        return levels;
    const auto value = [&](int label) { return domain.weight[label] * interpolate(domain.fields.inside[label], cell); };
    for (Eigen::Index i = 0; i < levels.size(); ++i)
        levels[i] = labels[i] == outside ? domain.threshold - interpolate(domain.body, cell)
                                         : value(labels[i]) - value(labels[i + 1]);
    return levels;
}

LevelGradients level_gradients(const LabelDomain &domain, const Vector3 &place, const std::vector<int> &labels) {
    const double step = 0.5 * domain.fields.spacing;
    LevelGradients gradients(static_cast<Eigen::Index>(labels.size()) - 1, 3);
    for (int d = 0; d < 3; ++d) {
        const Vector3 offset = step * Vector3::Unit(d);
        gradients.col(d) =
            (level_differences(domain, place + offset, labels) - level_differences(domain, place - offset, labels)) /
            (2.0 * step);
    }
    return gradients;
}

LevelGradients independent_normals(LevelGradients gradients) {
    constexpr double grazing = 0.15; // sine of the angle between two surfaces
    for (Eigen::Index i = 0; i < gradients.rows(); ++i) {
        const double length = gradients.row(i).norm();
        for (Eigen::Index j = 0; j < i; ++j)
            if (const double square = gradients.row(j).squaredNorm(); square > 0.0)
                gradients.row(i) -= gradients.row(i).dot(gradients.row(j)) / square * gradients.row(j);
        if (gradients.row(i).norm() <= grazing * length)
            gradients.row(i).setZero();
    }
    return gradients;
}

Vector3 project_to_levels(const LabelDomain &domain, Vector3 place, const std::vector<int> &labels,
                          const Levels &values) {
    constexpr int max_steps = 5;
    const double close_enough = 1e-3 * domain.fields.spacing;
    const double longest = 2.0 * domain.fields.spacing; // where the field is flat a step would leave for nowhere
    for (int i = 0; i < max_steps; ++i) {
        const LevelGradients gradients = level_gradients(domain, place, labels);
        const LevelGradients normals = independent_normals(gradients);
        const Levels miss = values - level_differences(domain, place, labels);
        Vector3 step = Vector3::Zero();
        for (Eigen::Index row = 0; row < normals.rows(); ++row)
            if (const double square = normals.row(row).squaredNorm(); square > 0.0)
                step += (miss[row] - gradients.row(row).dot(step)) / square * normals.row(row).transpose();
        if (const double length = step.norm(); length > longest)
            step *= longest / length;
        place += step;
        if (step.norm() < close_enough)
            break;
    }
    return place;
}

} // namespace livermark::segmentation
