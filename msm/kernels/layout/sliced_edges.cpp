#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

/// Edges near each other among which those are sorted together that have as many tetrahedra.
constexpr std::size_t edge_window = 512;

/// Index of the row of long_row() numbers that a thing has which stands in a lane of a slice.
template <class T> int index_of_row(const SlicedBody<T> &body, int place) {
    const int lane = place % slice_size;
    return long_row(body.measure) * (place - lane + row_of_lane(lane));
}

/// Tetrahedra around the edges from `first` on, as indices of their rows.
template <class T>
std::vector<std::vector<int>> members_of_edges(const SlicedPlan &plan, std::span<const int> edges,
                                               const SlicedBody<T> &body) {
    std::vector<std::vector<int>> lists;
    for (const int edge : edges) {
        auto &list = lists.emplace_back();
        for (const int t : plan.edge_members.of(edge))
            list.push_back(index_of_row(body, plan.tetrahedron_place[t]));
    }
    return lists;
}

/// Gives edges the next lanes.
template <class T>
void append_edges(const StepParts &parts, std::span<const int> edges, SlicedPlan &plan, SlicedBody<T> &body) {
    const std::size_t num_lanes =
        body.edge_modulus.size() + static_cast<std::size_t>(padded(static_cast<int>(edges.size())));
    auto lane = static_cast<int>(body.edge_modulus.size());
    plan.edge_lane.resize(parts.edge_modulus.size(), padding);
    append_lists(members_of_edges(plan, edges, body), filler_of_edges(body), body.edge_start, body.edge_member);
    for (auto *values : {&body.edge_modulus, &body.inverse_edge_volume})
        values->resize(num_lanes, T(0));
    for (const int edge : edges) {
        plan.edge_lane[edge] = lane++;
        put_edge(parts, edge, plan, body);
    }
}

/// Index of the row of the edge between two nodes of a tetrahedron.
template <class T>
int row_of_edge(const StepParts &parts, const SlicedPlan &plan, const SlicedBody<T> &body, int tetrahedron,
                const std::array<int, 2> &ends) {
    const auto &nodes = parts.tetrahedra[tetrahedron];
    const auto is_edge = [&](const std::array<int, 2> &local) {
        return std::minmax({nodes[local[0]], nodes[local[1]]}) == std::minmax({ends[0], ends[1]});
    };
    const auto found = std::ranges::find_if(core::tetrahedron_edges, is_edge) - core::tetrahedron_edges.begin();
    return index_of_row(body, plan.edge_lane[parts.edge_part[tetrahedron][found]]);
}

/// Puts down the edges of the fans of slices that have none as yet: see SlicedBody::fan_edge. Tetrahedra that follow
/// each other in a fan are of one material at their common nodes, and so are both of the edges to a node of the rim.
template <class T> void put_edges_of_fans(const StepParts &parts, const SlicedPlan &plan, SlicedBody<T> &body) {
    const std::size_t num_slices = body.fan_start.size() - 1;
    const auto first_line = [&](std::size_t slice) {
        return 3 * (static_cast<std::size_t>(body.fan_start[slice]) + slice) * slice_size;
    };
    std::size_t slice = 0;
    while (first_line(slice) < body.fan_edge.size())
        ++slice;
    body.fan_edge.resize(first_line(num_slices), 0);
    for (; slice < num_slices; ++slice) {
        const auto length = static_cast<std::size_t>(body.fan_start[slice + 1] - body.fan_start[slice]);
        for (std::size_t lane = 0; lane < slice_size; ++lane) {
            const auto &[axis, rim, tetrahedra] = plan.fans[slice * slice_size + lane];
            if (tetrahedra.empty())
                continue;
            for (std::size_t k = 0; k <= length; ++k) {
                const std::size_t node = std::min(k, tetrahedra.size());
                const int t = tetrahedra[node == 0 ? 0 : node - 1];
                const auto edge = [&](int a, int b) { return row_of_edge(parts, plan, body, t, {a, b}); };
                auto *at = body.fan_edge.data() + first_line(slice) + 3 * k * slice_size + lane;
                at[0] = node == 0 ? edge(axis[0], axis[1]) : edge(rim[node - 1], rim[node]);
                at[slice_size] = edge(axis[0], rim[node]);
                at[2 * slice_size] = edge(axis[1], rim[node]);
            }
        }
    }
}

} // namespace

template <class T> void put_edge(const StepParts &parts, int edge, const SlicedPlan &plan, SlicedBody<T> &body) {
    double volume = 0.0;
    for (const int t : plan.edge_members.of(edge))
        if (parts.is_there(t))
            volume += plan.rest_volume[t];
    const int lane = plan.edge_lane[edge];
    body.edge_modulus[lane] = static_cast<T>(parts.edge_modulus[edge] / 6.0);
    body.inverse_edge_volume[lane] = static_cast<T>(volume > 0.0 ? 1.0 / volume : 0.0);
}

template <class T> void slice_edges(const StepParts &parts, SlicedPlan &plan, SlicedBody<T> &body) {
    if (parts.edge_modulus.empty())
        return;
    plan.edge_members = NumberLists(parts.edge_part, parts.edge_modulus.size());
    std::vector<int> edges(parts.edge_modulus.size()), first_place;
    std::iota(edges.begin(), edges.end(), 0);
    for (const int edge : edges) {
        int first = std::numeric_limits<int>::max();
        for (const int t : plan.edge_members.of(edge))
            first = std::min(first, plan.tetrahedron_place[t]);
        first_place.push_back(first);
    }
    std::ranges::stable_sort(edges, {}, [&](int edge) { return first_place[edge]; });
    sort_in_windows(edges, edge_window,
                    [&](int a, int b) { return plan.edge_members.of(a).size() > plan.edge_members.of(b).size(); });
    body.edge_start.assign(1, 0);
    append_edges(parts, edges, plan, body);
    put_edges_of_fans(parts, plan, body);
}

template <class T>
void part_edges(const StepParts &parts, const PartingChanges &changes, int filler_before, SlicedPlan &plan,
                SlicedBody<T> &body) {
    const int filler = filler_of_edges(body);
    for (auto &member : body.edge_member)
        if (member == filler_before)
            member = filler;
    const auto first_new = static_cast<int>(plan.edge_lane.size());
    plan.edge_members.resize(parts.edge_modulus.size());
    NewLists new_lists;
    for (const int t : changes.tetrahedra)
        for (const int edge : parts.edge_part[t])
            if (edge >= first_new)
                new_lists.add(edge, t);
    new_lists.put_into(plan.edge_members);
    std::vector<int> added;
    for (const int edge : changes.edge_parts) {
        if (edge >= first_new) {
            added.push_back(edge);
            continue;
        }
        leave_owners(edge, parts.edge_part, plan.edge_members);
        const auto members = std::move(members_of_edges(plan, std::array{edge}, body).front());
        const int lane = plan.edge_lane[edge], slice = lane / slice_size;
        std::size_t next = 0;
        for (int line = body.edge_start[slice]; line < body.edge_start[slice + 1]; ++line, ++next)
            body.edge_member[line * slice_size + lane % slice_size] = next < members.size() ? members[next] : filler;
        put_edge(parts, edge, plan, body);
    }
    append_edges(parts, added, plan, body);
    put_edges_of_fans(parts, plan, body);
}

template void put_edge(const StepParts &, int, const SlicedPlan &, SlicedBody<float> &);
template void put_edge(const StepParts &, int, const SlicedPlan &, SlicedBody<double> &);
template void slice_edges(const StepParts &, SlicedPlan &, SlicedBody<float> &);
template void slice_edges(const StepParts &, SlicedPlan &, SlicedBody<double> &);
template void part_edges(const StepParts &, const PartingChanges &, int, SlicedPlan &, SlicedBody<float> &);
template void part_edges(const StepParts &, const PartingChanges &, int, SlicedPlan &, SlicedBody<double> &);

} // namespace livermark::msm
