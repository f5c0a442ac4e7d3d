#include "msm/kernels/layout/sliced_body.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

/// @return shape (N)
std::vector<int> rows_of_lanes(const std::vector<SpringLane> &lanes, int num_nodes) {
    std::vector<int> row(num_nodes);
    for (std::size_t l = 0; l < lanes.size(); ++l)
        for (const int side : {0, 1})
            if (const int node = lanes[l].node[side]; node != padding)
                row[node] =
                    static_cast<int>(l / slice_size) * pair_size + side * slice_size + static_cast<int>(l % slice_size);
    return row;
}

/// @return shape (N)
std::vector<int> rows_by_degree(const StepParts &parts, int num_nodes) {
    const auto order = order_by_degree(core::edge_table(parts.tetrahedra).edges, num_nodes);
    std::vector<int> row(num_nodes);
    for (int r = 0; r < num_nodes; ++r)
        row[order[r]] = r;
    return row;
}

} // namespace

template <class T>
SlicedBody<T> sliced_body(const StepParts &parts, const std::vector<core::Vector3> &positions, SlicedPlan *told) {
    SlicedBody<T> body;
    body.measure = parts.measure;
    SlicedPlan plan;
    const int num_nodes = static_cast<int>(positions.size());
    const bool has_springs = !parts.edges.empty();
    const auto lanes = has_springs ? spring_lanes(parts, num_nodes) : std::vector<SpringLane>();
    body.row_of_node = has_springs ? rows_of_lanes(lanes, num_nodes) : rows_by_degree(parts, num_nodes);
    body.first_copy = body.num_rows =
        has_springs ? padded(2 * static_cast<int>(lanes.size()), pair_size) : padded(num_nodes, pair_size);
    body.num_slices = body.first_copy / slice_size;
    slice_tetrahedra(parts, positions, body, plan); // finds out how many rows there are
    slice_springs(parts, lanes, body, plan);
    if (told) {
        plan.node_of_row.assign(static_cast<std::size_t>(body.first_copy), padding);
        for (int node = 0; node < num_nodes; ++node)
            plan.node_of_row[body.row_of_node[node]] = node;
        plan.springs_of_node = NumberLists(parts.edges, positions.size());
    }
    if (told)
        *told = std::move(plan);
    return body;
}

template SlicedBody<float> sliced_body(const StepParts &, const std::vector<core::Vector3> &, SlicedPlan *);
template SlicedBody<double> sliced_body(const StepParts &, const std::vector<core::Vector3> &, SlicedPlan *);

template <class T>
void update_sliced_body(const StepParts &parts, const CutChanges &changes, SlicedPlan &plan, SlicedBody<T> &body) {
    for (const int t : changes.tetrahedra)
        if (!plan.tetrahedron_place.empty())
            take_out(static_cast<std::size_t>(plan.tetrahedron_place[t]), body);
    for (const int s : changes.springs)
        if (!plan.springs.empty())
            for (const auto place : plan.springs[s])
                if (place != no_place)
                    put_spring(parts, s, place, body);
    for (const int c : changes.volumes) {
        const int number = plan.number_of_volume[c];
        const auto members = plan.members.of(c);
        put_volume(parts, c, rest_volume(parts, plan.rest_volume, members), number, body);
        if (parts.averages_volumes)
            put_volume_mean(volume_mean(parts, plan.rest_volume, c, members), number, body);
        if (!body.mean_gradient.empty())
            put_mean_gradient(mean_gradient(parts, plan.rest, c, members), number, body);
    }
    for (const int edge : changes.edge_parts)
        put_edge(parts, edge, plan, body);
}

template void update_sliced_body(const StepParts &, const CutChanges &, SlicedPlan &, SlicedBody<float> &);
template void update_sliced_body(const StepParts &, const CutChanges &, SlicedPlan &, SlicedBody<double> &);

namespace {

/// New nodes are where their parents are.
void add_places_of_parents(const std::vector<int> &parents, Eigen::VectorXd &x) {
    if (x.size() == 0)
        return;
    const Eigen::Index first = x.size();
    x.conservativeResize(first + 3 * std::ssize(parents));
    for (std::size_t k = 0; k < parents.size(); ++k)
        x.segment<3>(first + 3 * static_cast<Eigen::Index>(k)) =
            core::Vector3(x.segment<3>(3 * Eigen::Index{parents[k]}));
}

void part_members(const StepParts &parts, const PartingChanges &changes, NumberLists &members) {
    const auto first_new = static_cast<int>(members.size());
    members.resize(parts.centre.size());
    NewLists new_lists;
    for (const int t : changes.tetrahedra)
        for (const int c : parts.corner_volume[t])
            if (c >= first_new)
                new_lists.add(c, t);
    new_lists.put_into(members);
    for (const int c : changes.volumes)
        if (c < first_new)
            leave_owners(c, parts.corner_volume, members);
}

} // namespace

template <class T>
RowMap part_sliced_body(const StepParts &parts, const PartingChanges &changes, SlicedPlan &plan, SlicedBody<T> &body) {
    ForceSums<T> sums(body);
    const int filler = filler_of_members(parts, body), edge_filler = filler_of_edges(body);
    const auto rows = add_rows(parts, changes, plan, body);
    if (!parts.tetrahedra.empty()) {
        add_places_of_parents(changes.parent_node, plan.rest);
        std::vector<int> row_of_volume;
        for (const int number : plan.number_of_volume)
            row_of_volume.push_back(body.volume_row[number]);
        row_of_volume.insert(row_of_volume.end(), rows.volume_row.begin(), rows.volume_row.end());
        add_chunk(parts, changes, row_of_volume, plan, body, sums);
        if (!parts.centre.empty()) {
            part_members(parts, changes, plan.members);
            add_volumes(parts, changes, row_of_volume, filler, plan, body, sums);
        }
        if (!parts.edge_modulus.empty())
            part_edges(parts, changes, edge_filler, plan, body);
        sums.finish(body);
    }
    part_springs(parts, changes, plan, body);
    return rows.map;
}

template RowMap part_sliced_body(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<float> &);
template RowMap part_sliced_body(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<double> &);

} // namespace livermark::msm
