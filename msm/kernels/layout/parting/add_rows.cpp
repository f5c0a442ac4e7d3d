#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "msm/kernels/layout/parting/parting.hpp"

namespace livermark::msm {

namespace {

/// New nodes two by two, those first that a spring joins; padding for nobody.
std::vector<std::array<int, 2>> lanes_of_new_nodes(const StepParts &parts, const PartingChanges &changes,
                                                   int first_new) {
    std::vector<int> mate(changes.parent_node.size(), padding);
    for (std::size_t s = static_cast<std::size_t>(changes.first_new_spring); s < parts.edges.size(); ++s) {
        const auto [i, j] = parts.edges[s];
        if (std::min(i, j) < first_new)
            continue;
        int &of_i = mate[i - first_new], &of_j = mate[j - first_new];
        if (of_i == padding && of_j == padding) {
            of_i = j;
            of_j = i;
        }
    }
    std::vector<std::array<int, 2>> lanes;
    std::array<int, 2> alone{padding, padding};
    for (int k = 0; k < static_cast<int>(mate.size()); ++k) {
        const int node = first_new + k;
        if (mate[k] > node)
            lanes.push_back({node, mate[k]});
        if (mate[k] != padding)
            continue;
        (alone[0] == padding ? alone[0] : alone[1]) = node;
        if (alone[1] != padding)
            lanes.push_back(std::exchange(alone, {padding, padding}));
    }
    if (alone[0] != padding)
        lanes.push_back(alone);
    return lanes;
}

/// First rows of lanes without nodes, from the last pairs of slices.
std::vector<int> free_lanes(const std::vector<int> &node_of_row) {
    std::vector<int> lanes;
    for (auto pair = static_cast<int>(node_of_row.size()) - pair_size; pair >= 0; pair -= pair_size) {
        const auto before = static_cast<std::ptrdiff_t>(lanes.size());
        for (int row = pair; row < pair + slice_size; ++row)
            if (node_of_row[row] == padding && node_of_row[row + slice_size] == padding)
                lanes.push_back(row);
        if (std::ssize(lanes) == before)
            break;
    }
    return lanes;
}

/// Gives new control volumes rows: the first at a node its own, the others copies.
/// @param map  told where copies are now
template <class T>
std::vector<int> rows_of_new_volumes(const StepParts &parts, const SlicedPlan &plan, RowMap &map, SlicedBody<T> &body) {
    struct Copy {
        int node_row, before, volume; ///< number before and new volume, padding where it is none
    };
    std::vector<Copy> copies;
    for (std::size_t c = 0; c < body.copied_row.size(); ++c)
        copies.push_back({body.copied_row[c], static_cast<int>(c), padding});
    const auto first_new = static_cast<int>(plan.number_of_volume.size());
    std::vector<int> rows;
    std::vector<int> taken; // rows
    for (int c = first_new; c < static_cast<int>(parts.centre.size()); ++c) {
        const int row = body.row_of_node[parts.centre[c]];
        rows.push_back(row);
        if (std::ranges::find(taken, row) == taken.end())
            taken.push_back(row);
        else
            copies.push_back({row, padding, c - first_new});
    }
    std::ranges::stable_sort(copies, {}, &Copy::node_row);
    body.copied_row.clear();
    body.copy_start.assign(static_cast<std::size_t>(body.num_slices) + 1, 0);
    map.copy.resize(copies.size());
    std::size_t num_before = 0;
    for (const auto &[node_row, before, volume] : copies) {
        const auto now = static_cast<int>(body.copied_row.size());
        body.copied_row.push_back(node_row);
        ++body.copy_start[node_row / slice_size + 1];
        if (before != padding) {
            map.copy[before] = now;
            ++num_before;
        } else {
            rows[volume] = body.first_copy + now;
        }
    }
    map.copy.resize(num_before);
    std::partial_sum(body.copy_start.begin(), body.copy_start.end(), body.copy_start.begin());
    return rows;
}

template <class T> void move_rows(const RowMap &map, SlicedBody<T> &body) {
    if (map.is_identity())
        return;
    // Stars have no copies.
    for (auto *indices : {&body.neighbour, &body.corner, &body.mean_node})
        for (auto &index : *indices)
            if (index >= 4 * map.first_copy_before)
                index = 4 * map.of(index / 4);
    for (int &row : body.volume_row)
        row = map.of(row);
}

} // namespace

template <class T>
NewRows add_rows(const StepParts &parts, const PartingChanges &changes, SlicedPlan &plan, SlicedBody<T> &body) {
    NewRows result;
    auto &map = result.map;
    map.first_copy_before = body.first_copy;
    map.num_rows_before = body.num_rows;
    const auto lanes = lanes_of_new_nodes(parts, changes, static_cast<int>(body.row_of_node.size()));
    auto places = free_lanes(plan.node_of_row);
    while (places.size() < lanes.size()) {
        for (int lane = 0; lane < slice_size; ++lane)
            places.push_back(body.first_copy + lane);
        body.first_copy += pair_size;
    }
    body.num_slices = body.first_copy / slice_size;
    plan.node_of_row.resize(static_cast<std::size_t>(body.first_copy), padding);
    body.row_of_node.resize(body.row_of_node.size() + changes.parent_node.size());
    for (std::size_t l = 0; l < lanes.size(); ++l)
        for (const int side : {0, 1})
            if (const int node = lanes[l][side]; node != padding) {
                body.row_of_node[node] = places[l] + side * slice_size;
                plan.node_of_row[body.row_of_node[node]] = node;
            }
    if (!parts.centre.empty())
        result.of_volume = rows_of_new_volumes(parts, plan, map, body);
    body.num_rows = padded(body.first_copy + static_cast<int>(body.copied_row.size()));
    map.first_copy = body.first_copy;
    map.num_rows = body.num_rows;
    // Copies may have changed places although there are no more rows.
    for (std::size_t c = 0; c < map.copy.size(); ++c)
        if (map.copy[c] != static_cast<int>(c))
            map.are_copies_moved = true;
    move_rows(map, body);
    if (!body.rest_rows.empty())
        body.rest_rows.resize(4 * static_cast<std::size_t>(body.num_rows), T(0));
    return result;
}

template NewRows add_rows(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<float> &);
template NewRows add_rows(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<double> &);

} // namespace livermark::msm
