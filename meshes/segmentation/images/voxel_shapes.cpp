#include "meshes/segmentation/images/voxel_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

constexpr float far_away = 1e6F; // [m^2]

/// Lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012, Theory of Computing 8(19), algorithm 1): of the
/// squared distances along the axes before this one comes that along this one too.
class DistanceAlong {
  public:
    DistanceAlong(int length, double spacing)
        : spacing_(spacing), before_(static_cast<std::size_t>(length)), vertex_(before_.size()),
          begin_(before_.size() + 1) {}

    /// @param values  first of `length` squared distances [m^2]
    /// @param stride  from one to the next
    void operator()(float *values, std::size_t stride) {
        const std::size_t length = before_.size();
        for (std::size_t q = 0; q < length; ++q)
            before_[q] = static_cast<double>(values[q * stride]);
        std::size_t last = 0;
        vertex_[0] = 0;
        begin_[0] = -std::numeric_limits<double>::infinity();
        begin_[1] = std::numeric_limits<double>::infinity();
        for (std::size_t q = 1; q < length; ++q) {
            double cross = crossing(vertex_[last], q);
            while (cross <= begin_[last])
                cross = crossing(vertex_[--last], q);
            vertex_[++last] = q;
            begin_[last] = cross;
            begin_[last + 1] = std::numeric_limits<double>::infinity();
        }
        std::size_t parabola = 0;
        for (std::size_t q = 0; q < length; ++q) {
            while (begin_[parabola + 1] < static_cast<double>(q))
                ++parabola;
            const double along = spacing_ * (static_cast<double>(q) - static_cast<double>(vertex_[parabola]));
            values[q * stride] = static_cast<float>(along * along + before_[vertex_[parabola]]);
        }
    }

  private:
    /// Place, in voxels, from which on the parabola of q is below that of p < q.
    double crossing(std::size_t p, std::size_t q) const {
        const double a = static_cast<double>(p), b = static_cast<double>(q);
        return 0.5 * ((before_[q] - before_[p]) / (spacing_ * spacing_ * (b - a)) + a + b);
    }

    double spacing_;
    std::vector<double> before_;
    std::vector<std::size_t> vertex_;
    std::vector<double> begin_;
};

/// Squared distance of each voxel of a box to the nearest one of a set, centre to centre [m^2].
std::vector<float> squared_distances(const ImageGrid &grid, const VoxelBox &box, const VoxelSet &set) {
    std::vector<float> square(box.num_voxels());
    for (std::size_t v = 0; v < square.size(); ++v)
        square[v] = set[v] != 0 ? 0.0F : far_away;
    const std::array<std::size_t, 3> size{static_cast<std::size_t>(box.size[0]), static_cast<std::size_t>(box.size[1]),
                                          static_cast<std::size_t>(box.size[2])};
    const std::array<std::size_t, 3> stride{1, size[0], size[0] * size[1]};
    for (std::size_t d = 0; d < 3; ++d) {
        DistanceAlong along(box.size.at(d), grid.spacing[static_cast<Eigen::Index>(d)]);
        const std::size_t a = d == 0 ? 1 : 0, b = d == 2 ? 1 : 2; // the other axes
        for (std::size_t j = 0; j < size.at(b); ++j)
            for (std::size_t i = 0; i < size.at(a); ++i)
                along(&square[i * stride.at(a) + j * stride.at(b)], stride.at(d));
    }
    return square;
}

/// Whether each voxel of a box is nearer than a radius to one of a set, centre to centre.
VoxelSet nearer_than(const ImageGrid &grid, const VoxelBox &box, const VoxelSet &set, double radius) {
    const auto square = squared_distances(grid, box, set);
    VoxelSet near(square.size());
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

std::vector<float> depths_in(const ImageGrid &grid, const VoxelSet &set) {
    const auto box = box_around(grid, set, 0.0);
    std::vector<float> depths(set.size(), 0.0F);
    if (box.num_voxels() == 0)
        return depths;
    const auto square = squared_distances(grid, box, complement(cut_out(grid, box, set)));
    for_each_shared(grid, box,
                    [&](std::size_t in_box, std::size_t in_grid) { depths[in_grid] = std::sqrt(square[in_box]); });
    return depths;
}

} // namespace livermark::segmentation
