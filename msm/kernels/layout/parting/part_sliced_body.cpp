#include <algorithm>

#include "msm/kernels/layout/parting/parting.hpp"

namespace livermark::msm {

namespace {

void add_places_of_parents(const std::vector<int> &parents, Eigen::VectorXd &x) {
    if (x.size() == 0)
        return;
    const Eigen::Index first = x.size();
    x.conservativeResize(first + 3 * std::ssize(parents));
    for (std::size_t k = 0; k < parents.size(); ++k)
        x.segment<3>(first + 3 * static_cast<Eigen::Index>(k)) =
            core::Vector3(x.segment<3>(3 * Eigen::Index{parents[k]}));
}

/// New nodes are where their parents are.
template <class T> void add_positions(const PartingChanges &changes, SlicedPlan &plan, SlicedBody<T> &body) {
    const std::size_t first_new = body.row_of_node.size() - changes.parent_node.size();
    add_places_of_parents(changes.parent_node, plan.rest);
    add_places_of_parents(changes.parent_node, plan.rounded_rest);
    if (body.rest_rows.empty())
        return;
    for (std::size_t k = 0; k < changes.parent_node.size(); ++k) {
        const auto row = [&](std::size_t node) {
            return body.rest_rows.begin() + 4 * std::ptrdiff_t{body.row_of_node[node]};
        };
        std::copy_n(row(static_cast<std::size_t>(changes.parent_node[k])), 4, row(first_new + k));
    }
}

void part_members(const StepParts &parts, const PartingChanges &changes, NumberLists &members) {
    const auto first_new = static_cast<int>(members.size());
    members.resize(parts.centre.size());
    NewLists of_new;
    for (const int t : changes.tetrahedra)
        for (const int c : parts.corner_volume[t])
            if (c >= first_new)
                of_new.add(c, t);
    of_new.put_into(members);
    for (const int c : changes.volumes)
        if (c < first_new)
            leave_owners(c, parts.corner_volume, members);
}

} // namespace

template <class T>
RowMap part_sliced_body(const StepParts &parts, const PartingChanges &changes, SlicedPlan &plan, SlicedBody<T> &body) {
    ForceSums<T> sums(body);
    const int filler = filler_of_members(parts, body);
    const auto rows = add_rows(parts, changes, plan, body);
    if (!parts.tetrahedra.empty()) {
        add_positions(changes, plan, body);
        std::vector<int> row_of_volume;
        for (const int number : plan.number_of_volume)
            row_of_volume.push_back(body.volume_row[number]);
        row_of_volume.insert(row_of_volume.end(), rows.of_volume.begin(), rows.of_volume.end());
        add_chunk(parts, changes, row_of_volume, plan, body, sums);
        if (!parts.centre.empty()) {
            part_members(parts, changes, plan.members);
            add_volumes(parts, changes, row_of_volume, filler, plan, body, sums);
        }
        sums.finish(body);
    }
    part_springs(parts, changes, plan, body);
    return rows.map;
}

template RowMap part_sliced_body(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<float> &);
template RowMap part_sliced_body(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<double> &);

} // namespace livermark::msm
