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

namespace {

/// The stars of a body with the lines of their slices as they become, from those that are there.
template <class T> class StarUpdate {
  public:
    StarUpdate(const StepParts &parts, SlicedPlan &plan, SlicedBody<T> &body)
        : parts_(parts), plan_(plan), body_(body) {}

    void run(const std::vector<int> &edge_parts) {
        if (parts_.measure != StrainMeasure::deformation_gradient) { // all nodes stay where they are on the lines
            for (const int part : edge_parts) {
                const int lane = plan_.star_of_part[part];
                put_star(parts_, plan_.rounded_rest, plan_.stars[lane], plan_.stars[lane].rim, lane, body_);
            }
            return;
        }
        std::vector<LaneRim> rims;
        rims.reserve(edge_parts.size());
        for (const int part : edge_parts) {
            const int lane = plan_.star_of_part[part];
            rims.push_back({lane, rim_without(plan_.stars[lane], parts_.is_removed, true), {}});
            plan_.rim_size[lane] = static_cast<int>(rims.back().corners.size());
            find_slots(rims.back());
        }
        lengthen_slices();
        for (const auto &rim : rims) {
            put_corners(rim);
            put_star(parts_, plan_.rounded_rest, plan_.stars[rim.lane], rim.corners, rim.lane, body_);
        }
    }

  private:
    struct LaneRim {
        int lane;
        std::vector<Star::Corner> corners;
        std::vector<int> slots; ///< of these, four times their places for forces
    };

    std::size_t length(const std::vector<int> &start, std::size_t slice) const {
        return start[slice + 1] - start[slice];
    }

    /// Four times the place for forces of a node of a lane, as its lines are now.
    int slot_of(int lane, int corner) const {
        const std::size_t slice = lane / slice_size;
        std::size_t at = (body_.star_start[slice] + 2 * slice) * slice_size + lane % slice_size;
        while (body_.star_corner[at] != corner)
            at += slice_size;
        return body_.star_slot[at];
    }

    /// Before lines move.
    void find_slots(LaneRim &rim) const {
        rim.slots.reserve(rim.corners.size());
        for (const auto &corner : rim.corners)
            rim.slots.push_back(slot_of(rim.lane, 4 * body_.row_of_node[corner.node]));
    }

    /// Gives each slice as many lines as its longest star has; the others begin with their first node again.
    void lengthen_slices() {
        std::vector<int> start{0};
        start.reserve(body_.star_start.size());
        for (std::size_t first = 0; first < plan_.rim_size.size(); first += slice_size)
            start.push_back(
                start.back() +
                *std::max_element(plan_.rim_size.begin() + static_cast<std::ptrdiff_t>(first),
                                  plan_.rim_size.begin() + static_cast<std::ptrdiff_t>(first + slice_size)));
        if (start == body_.star_start)
            return;
        Aligned<std::int32_t> corner, slot;
        Aligned<T> tetrahedron;
        const std::size_t num_slices = start.size() - 1, num_lines = static_cast<std::size_t>(start.back());
        corner.reserve((num_lines + 2 * num_slices) * slice_size);
        slot.reserve((num_lines + 2 * num_slices) * slice_size);
        tetrahedron.reserve(num_lines * slice_size);
        body_.longest_star = 0;
        for (std::size_t slice = 0; slice < num_slices;) {
            const std::size_t is = length(start, slice);
            std::size_t next = slice; // behind those that are as long as they were
            for (; next < num_slices && length(start, next) == length(body_.star_start, next); ++next)
                body_.longest_star = std::max(body_.longest_star, length(start, next));
            if (next == slice) {
                body_.longest_star = std::max(body_.longest_star, is);
                append_slice(body_.star_corner, slice, 2, is, corner);
                append_slice(body_.star_slot, slice, 2, is, slot);
                append_slice(body_.star_tetrahedron, slice, 0, is, tetrahedron);
                ++next;
            } else {
                append_lines(body_.star_corner, first_line(slice, 2), first_line(next, 2), corner);
                append_lines(body_.star_slot, first_line(slice, 2), first_line(next, 2), slot);
                append_lines(body_.star_tetrahedron, first_line(slice, 0), first_line(next, 0), tetrahedron);
            }
            slice = next;
        }
        body_.star_start = std::move(start);
        body_.star_corner = std::move(corner);
        body_.star_slot = std::move(slot);
        body_.star_tetrahedron = std::move(tetrahedron);
    }

    /// Length of a slice as it was.
    /// @param num_axis_lines  before the rim of each slice
    std::size_t first_line(std::size_t slice, std::size_t num_axis_lines) const {
        return static_cast<std::size_t>(body_.star_start[slice]) + num_axis_lines * slice;
    }

    template <class Values>
    static void append_lines(const Values &from, std::size_t first, std::size_t last, Values &to) {
        to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(first * slice_size),
                  from.begin() + static_cast<std::ptrdiff_t>(last * slice_size));
    }

    /// A slice that becomes longer or shorter. What is more at the front is the first node again, or no volume.
    template <class Values>
    void append_slice(const Values &from, std::size_t slice, std::size_t num_axis_lines, std::size_t is,
                      Values &to) const {
        const std::size_t was = length(body_.star_start, slice);
        const std::size_t first = first_line(slice, num_axis_lines), rim = first + num_axis_lines;
        append_lines(from, first, rim, to);
        for (std::size_t more = was; more < is; ++more)
            if (num_axis_lines > 0)
                append_lines(from, rim, rim + 1, to);
            else
                to.resize(to.size() + slice_size);
        append_lines(from, rim + (was > is ? was - is : 0), rim + was, to);
    }

    void put_corners(const LaneRim &rim) {
        const std::size_t slice = rim.lane / slice_size, is = length(body_.star_start, slice),
                          more = is - rim.corners.size();
        std::size_t at = first_line(slice, 2) * slice_size + 2 * slice_size + rim.lane % slice_size;
        for (std::size_t k = 0; k < is; ++k, at += slice_size) {
            const std::size_t rim_place = k < more ? 0 : k - more;
            body_.star_corner[at] = 4 * body_.row_of_node[rim.corners[rim_place].node];
            body_.star_slot[at] = rim.slots[rim_place];
        }
    }

    const StepParts &parts_;
    SlicedPlan &plan_;
    SlicedBody<T> &body_;
};

} // namespace

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
    if (!changes.edge_parts.empty())
        StarUpdate<T>(parts, plan, body).run(changes.edge_parts);
}

template void update_sliced_body(const StepParts &, const CutChanges &, SlicedPlan &, SlicedBody<float> &);
template void update_sliced_body(const StepParts &, const CutChanges &, SlicedPlan &, SlicedBody<double> &);

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
    const int filler = filler_of_members(parts, body);
    const auto rows = add_rows(parts, changes, plan, body);
    if (!parts.tetrahedra.empty()) {
        add_positions(changes, plan, body);
        std::vector<int> row_of_volume;
        for (const int number : plan.number_of_volume)
            row_of_volume.push_back(body.volume_row[number]);
        row_of_volume.insert(row_of_volume.end(), rows.volume_row.begin(), rows.volume_row.end());
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
