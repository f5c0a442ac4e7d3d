#include "msm/kernels/sliced_body.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "msm/elastic_body.hpp"
#include "msm/kernels/node_order.hpp"
#include "msm/tetrahedron_volume.hpp"

namespace livermark::msm {

namespace {

/// A place without a tetrahedron.
constexpr int none = -1;

constexpr int padded(int count) {
    return (count + slice_size - 1) / slice_size * slice_size;
}

/// Where the longest list of each slice ends, counted in rows of 16.
std::vector<int> starts(const std::vector<int> &length_of_row) {
    std::vector<int> start{0};
    for (std::size_t first = 0; first < length_of_row.size(); first += slice_size) {
        const auto begin = length_of_row.begin() + static_cast<std::ptrdiff_t>(first);
        start.push_back(start.back() + *std::max_element(begin, begin + slice_size));
    }
    return start;
}

/// Place of the next entry of a row, of which it has `used` already.
std::size_t place(const std::vector<int> &start, int row, int &used) {
    const auto line = static_cast<std::size_t>(start[row / slice_size] + used++);
    return line * slice_size + row % slice_size;
}

template <class T> void slice_springs(const StepParts &parts, SlicedBody<T> &body) {
    std::vector<int> degree(body.first_copy, 0);
    for (const auto &edge : parts.edges)
        for (const int node : edge)
            ++degree[body.row_of_node[node]];
    body.spring_start = starts(degree);
    const std::size_t size = static_cast<std::size_t>(body.spring_start.back()) * slice_size;
    body.neighbour.assign(size, 0);
    body.stiffness.assign(size, T(0));
    body.pull.assign(size, T(0));
    std::vector<int> used(degree.size(), 0);
    for (std::size_t s = 0; s < parts.edges.size(); ++s)
        for (int end = 0; end < 2; ++end) {
            const int row = body.row_of_node[parts.edges[s][end]];
            const auto at = place(body.spring_start, row, used[row]);
            body.neighbour[at] = 4 * body.row_of_node[parts.edges[s][1 - end]];
            body.stiffness[at] = static_cast<T>(parts.stiffness[s]);
            body.pull[at] = static_cast<T>(parts.stiffness[s] * parts.rest_length[s]);
        }
}

/// Gives each control volume a row. @return shape (C)
template <class T> std::vector<int> volume_rows(const StepParts &parts, SlicedBody<T> &body) {
    std::vector<int> row(parts.centre.size());
    std::vector<char> is_taken(body.first_copy, 0);
    std::vector<std::pair<int, std::size_t>> others; // by the row of the node, so that a slice has its copies together
    for (std::size_t c = 0; c < row.size(); ++c) {
        row[c] = body.row_of_node[parts.centre[c]];
        if (is_taken[row[c]])
            others.emplace_back(row[c], c);
        is_taken[row[c]] = 1;
    }
    std::ranges::sort(others);
    body.copy_start.assign(body.num_slices + 1, 0);
    for (const auto &[node_row, c] : others) {
        row[c] = body.first_copy + static_cast<int>(body.copied_row.size());
        body.copied_row.push_back(node_row);
        ++body.copy_start[node_row / slice_size + 1];
    }
    std::partial_sum(body.copy_start.begin(), body.copy_start.end(), body.copy_start.begin());
    body.num_rows = padded(body.first_copy + static_cast<int>(others.size()));
    return row;
}

template <class T>
void slice_volumes(const StepParts &parts, const std::vector<int> &row_of_volume, const std::vector<int> &tetrahedra,
                   SlicedBody<T> &body) {
    std::vector<int> count(body.num_rows, 0);
    for (const auto &volumes : parts.corner_volume)
        for (const int c : volumes)
            ++count[row_of_volume[c]];
    body.volume_start = starts(count);
    body.member.assign(static_cast<std::size_t>(body.volume_start.back()) * slice_size, body.num_groups * slice_size);
    body.volume_stiffness.assign(body.num_rows, T(0));
    for (std::size_t c = 0; c < row_of_volume.size(); ++c)
        body.volume_stiffness[row_of_volume[c]] = static_cast<T>(0.25 * parts.volume_stiffness[c]);
    std::vector<int> used(body.num_rows, 0);
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        if (tetrahedra[t] != none)
            for (const int c : parts.corner_volume[tetrahedra[t]]) {
                const int row = row_of_volume[c];
                body.member[place(body.volume_start, row, used[row])] = static_cast<std::int32_t>(t);
            }
}

/// The tetrahedra in the order of their nodes, cut into chunks. Within a chunk those next to each other go to different
/// groups: lanes that add to the same node would have to wait for each other.
/// @return shape (groups * 16), none where a group is filled up
template <class T> std::vector<int> tetrahedron_order(const StepParts &parts, const SlicedBody<T> &body) {
    std::vector<std::array<int, 4>> rows(parts.tetrahedra.size());
    for (std::size_t t = 0; t < rows.size(); ++t) {
        std::ranges::transform(parts.tetrahedra[t], rows[t].begin(), [&](int node) { return body.row_of_node[node]; });
        std::ranges::sort(rows[t]);
    }
    std::vector<int> order(rows.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int t) { return rows[t]; });

    const int num_places = padded(static_cast<int>(order.size()));
    order.resize(num_places, none);
    std::vector<int> dealt(num_places);
    for (int first = 0; first < num_places; first += chunk_size * slice_size) {
        const int num_groups = std::min(chunk_size, (num_places - first) / slice_size);
        for (int i = 0; i < num_groups * slice_size; ++i)
            dealt[first + i % num_groups * slice_size + i / num_groups] = order[first + i];
    }
    return dealt;
}

/// Values of tetrahedra in groups, filled up with zeros.
template <class T> Aligned<T> grouped(const std::vector<double> &values, const std::vector<int> &order) {
    Aligned<T> result(values.empty() ? 0 : order.size(), T(0));
    for (std::size_t place = 0; place < result.size(); ++place)
        if (order[place] != none)
            result[place] = static_cast<T>(values[order[place]]);
    return result;
}

std::size_t corner_place(std::size_t t, int corner) {
    return ((t / slice_size) * 4 + corner) * slice_size + t % slice_size;
}

/// Gives each node that a chunk touches a place to add forces to, and each node the list of its places.
template <class T> void slice_sums(const StepParts &parts, const std::vector<int> &order, SlicedBody<T> &body) {
    std::vector<std::vector<int>> places(body.first_copy);
    body.force_slot.assign(4 * order.size(), 0);
    body.chunk_start.assign(1, 0);
    int num_places = 0;
    for (std::size_t first = 0; first < order.size(); first += chunk_size * slice_size) {
        const std::size_t end = std::min(first + chunk_size * slice_size, order.size());
        for (std::size_t t = first; t < end; ++t)
            for (int a = 0; a < 4; ++a) {
                auto &slot = body.force_slot[corner_place(t, a)];
                slot = 4 * body.chunk_start.back(); // what fills up a group adds nothing
                if (order[t] == none)
                    continue;
                auto &of_node = places[body.row_of_node[parts.tetrahedra[order[t]][a]]];
                if (of_node.empty() || of_node.back() < body.chunk_start.back())
                    of_node.push_back(num_places++);
                slot = 4 * of_node.back();
            }
        body.chunk_start.push_back(num_places);
    }
    std::vector<int> count;
    for (const auto &of_node : places)
        count.push_back(static_cast<int>(of_node.size()));
    body.sum_start = starts(count);
    body.sum.assign(static_cast<std::size_t>(body.sum_start.back()) * slice_size, 4 * num_places);
    for (int row = 0; row < body.first_copy; ++row)
        for (int used = 0; used < count[row];) {
            const int slot = 4 * places[row][used];
            body.sum[place(body.sum_start, row, used)] = slot;
        }
}

template <class T>
void slice_tetrahedra(const StepParts &parts, const std::vector<core::Vector3> &positions, SlicedBody<T> &body) {
    const auto row_of_volume = volume_rows(parts, body);
    const auto order = tetrahedron_order(parts, body);
    body.num_groups = static_cast<int>(order.size()) / slice_size;

    const auto x = to_unknowns(positions);
    std::vector<double> rest_volume;
    for (const auto &corners : parts.tetrahedra)
        rest_volume.push_back(volume_gradient(x, corners).volume);
    body.rest_volume = grouped<T>(rest_volume, order);
    body.tetrahedron_stiffness = grouped<T>(parts.tetrahedron_stiffness, order);
    body.least_volume = grouped<T>(parts.least_volume, order);
    body.guard_stiffness = grouped<T>(parts.guard_stiffness, order);

    const std::size_t size = 4 * order.size();
    body.corner.assign(size, 0);
    for (std::size_t t = 0; t < order.size(); ++t)
        for (int a = 0; a < 4 && order[t] != none; ++a)
            body.corner[corner_place(t, a)] =
                4 * (parts.centre.empty() ? body.row_of_node[parts.tetrahedra[order[t]][a]]
                                          : row_of_volume[parts.corner_volume[order[t]][a]]);
    slice_sums(parts, order, body);
    if (!parts.centre.empty())
        slice_volumes(parts, row_of_volume, order, body);
}

} // namespace

template <class T> SlicedBody<T> sliced_body(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    SlicedBody<T> body;
    const int num_nodes = static_cast<int>(positions.size());
    const auto order = order_by_degree(parts.edges, num_nodes);
    body.row_of_node.resize(num_nodes);
    for (int row = 0; row < num_nodes; ++row)
        body.row_of_node[order[row]] = row;
    body.first_copy = body.num_rows = padded(num_nodes);
    body.num_slices = body.first_copy / slice_size;
    slice_springs(parts, body);
    slice_tetrahedra(parts, positions, body);
    return body;
}

template SlicedBody<float> sliced_body(const StepParts &, const std::vector<core::Vector3> &);
template SlicedBody<double> sliced_body(const StepParts &, const std::vector<core::Vector3> &);

} // namespace livermark::msm
