#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "msm/kernels/layout/slicing.hpp"

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
        int &mate_of_i = mate[i - first_new], &mate_of_j = mate[j - first_new];
        if (mate_of_i == padding && mate_of_j == padding) {
            mate_of_i = j;
            mate_of_j = i;
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
        result.volume_row = rows_of_new_volumes(parts, plan, map, body);
    body.num_rows = padded(body.first_copy + static_cast<int>(body.copied_row.size()));
    map.first_copy = body.first_copy;
    map.num_rows = body.num_rows;
    // Copies may have changed places although there are no more rows.
    for (std::size_t c = 0; c < map.copy.size(); ++c)
        if (map.copy[c] != static_cast<int>(c))
            map.are_copies_moved = true;
    move_rows(map, body);
    return result;
}

template NewRows add_rows(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<float> &);
template NewRows add_rows(const StepParts &, const PartingChanges &, SlicedPlan &, SlicedBody<double> &);

namespace {

/// Meaning of the numbers in SlicedBody::member.
template <class T> struct MemberKind {
    bool are_places = false; ///< of tetrahedra on the lines, and not corners of fans
    int scale = 1;

    MemberKind(const StepParts &parts, const SlicedBody<T> &body) {
        const bool is_coupled = !parts.coupled_modulus.empty();
        are_places = is_coupled && !parts.has_means_of_tensors();
        if (are_places)
            scale = 8;
        else if (is_coupled && body.mean_gradient.empty())
            scale = 4;
    }

    /// Number where nothing is.
    int filler(const SlicedBody<T> &body) const {
        return scale * static_cast<int>(are_places ? body.rest_volume.size() : body.corner.size());
    }
};

/// Numbers in SlicedBody::member of the tetrahedra around a node: places of these, or corners of fans.
template <class T> class Members {
  public:
    Members(const StepParts &parts, const SlicedPlan &plan, const SlicedBody<T> &body)
        : parts_(parts), plan_(plan), body_(body), kind_(parts, body) {}

    std::vector<int> of(int volume, int row) const {
        std::vector<int> members;
        for (const int t : plan_.members.of(volume))
            if (parts_.is_there(t)) {
                const int place = plan_.tetrahedron_place[t];
                members.push_back(kind_.scale * (kind_.are_places ? place : corner_at(place, row)));
            }
        std::ranges::sort(members);
        members.erase(std::unique(members.begin(), members.end()), members.end());
        return members;
    }

    int filler() const { return kind_.filler(body_); }

  private:
    /// The corner of a tetrahedron in its fan that is in a row.
    int corner_at(int place, int row) const {
        const auto line = static_cast<std::size_t>(place) / slice_size,
                   lane = static_cast<std::size_t>(place) % slice_size;
        const auto slice = static_cast<std::size_t>(plan_.fan_slice[line]);
        const std::size_t start = static_cast<std::size_t>(body_.fan_start[slice]) + 3 * slice,
                          from = line + 3 * slice + 2;
        for (const std::size_t corner : {start, start + 1, from})
            if (const std::size_t at = corner * slice_size + lane; body_.corner[at] == 4 * row)
                return static_cast<int>(at);
        return static_cast<int>((from + 1) * slice_size + lane);
    }

    const StepParts &parts_;
    const SlicedPlan &plan_;
    const SlicedBody<T> &body_;
    MemberKind<T> kind_;
};

/// Makes of a control volume one that does nothing.
template <class T> void take_volume_out(int number, int filler, SlicedBody<T> &body) {
    const auto slice = static_cast<std::size_t>(number) / slice_size,
               lane = static_cast<std::size_t>(number) % slice_size;
    body.volume_row[static_cast<std::size_t>(number)] = body.num_rows;
    for (auto line = static_cast<std::size_t>(body.volume_start[slice]);
         line < static_cast<std::size_t>(body.volume_start[slice + 1]); ++line)
        body.member[line * slice_size + lane] = filler;
    for (auto *values : {&body.volume_stiffness, &body.coupled_modulus, &body.inverse_volume})
        if (!values->empty())
            (*values)[static_cast<std::size_t>(number)] = T(0);
    if (body.mean_start.empty())
        return;
    for (auto line = static_cast<std::size_t>(body.mean_start[slice]);
         line < static_cast<std::size_t>(body.mean_start[slice + 1]); ++line) {
        if (!body.mean_weight.empty())
            body.mean_weight[line * slice_size + lane] = T(0);
        if (!body.mean_gradient.empty())
            for (std::size_t k = 0; k < 4; ++k)
                body.mean_gradient[(4 * line + k) * slice_size + lane] = T(0);
    }
}

/// The places where changed control volumes put forces on their neighbours, and those where they did.
template <class T>
void move_pulls(const StepParts &parts, const PartingChanges &changes, const std::vector<MeanGradient> &gradients,
                const SlicedPlan &plan, const SlicedBody<T> &body, ForceSums<T> &sums) {
    const int first_in_middle = body.first_pull + static_cast<int>(body.mean_node.size());
    for (std::size_t k = 0; k < changes.volumes.size(); ++k) {
        const int volume = changes.volumes[k], number = plan.number_of_volume[volume], lane = number % slice_size;
        int line = body.mean_start[number / slice_size];
        sums.add(body.row_of_node[parts.centre[volume]], 4 * (first_in_middle + number));
        for (const auto &neighbour : gradients[k])
            sums.add(body.row_of_node[neighbour.node], 4 * (body.first_pull + line++ * slice_size + lane));
    }
}

template <class T> void append_volumes(std::size_t count, SlicedBody<T> &body) {
    for (auto *values : {&body.volume_stiffness, &body.coupled_modulus, &body.inverse_volume})
        if (!values->empty())
            values->resize(count, T(0));
    body.volume_row.resize(count, body.num_rows);
}

} // namespace

template <class T> int filler_of_members(const StepParts &parts, const SlicedBody<T> &body) {
    return MemberKind<T>(parts, body).filler(body);
}

template <class T>
void add_volumes(const StepParts &parts, const PartingChanges &changes, std::span<const int> row_of_volume,
                 int filler_before, SlicedPlan &plan, SlicedBody<T> &body, ForceSums<T> &sums) {
    const Members<T> members(parts, plan, body);
    const auto first_new = static_cast<int>(plan.number_of_volume.size());
    const int filler = members.filler();
    for (auto &member : body.member)
        if (member == filler_before)
            member = filler;
    std::vector<int> renumbered(body.volume_row.size());
    for (std::size_t number = 0; number < renumbered.size(); ++number)
        renumbered[number] = static_cast<int>(number);
    plan.number_of_volume.resize(parts.centre.size(), padding);
    auto next = static_cast<int>(body.volume_row.size());
    std::vector<std::vector<int>> lists;
    for (const int c : changes.volumes) {
        if (const int before = plan.number_of_volume[c]; c < first_new) {
            if (!body.mean_gradient.empty()) {
                sums.leave_out_volume(before);
                sums.look_at(row_of_volume[c]);
                const int slice = before / slice_size, lane = before % slice_size;
                for (int line = body.mean_start[slice]; line < body.mean_start[slice + 1]; ++line)
                    if (const int row = body.mean_node[line * slice_size + lane] / 4; row < body.first_copy)
                        sums.look_at(row);
            }
            take_volume_out(before, filler, body);
            renumbered[before] = next;
        }
        plan.number_of_volume[c] = next++;
        lists.push_back(members.of(c, row_of_volume[c]));
    }
    append_volumes(static_cast<std::size_t>(padded(next)), body);
    for (const int c : changes.volumes)
        body.volume_row[plan.number_of_volume[c]] = row_of_volume[c];
    append_lists(std::move(lists), filler, body.volume_start, body.member);
    const bool has_gradients = !body.mean_gradient.empty();
    std::vector<MeanGradient> gradients;
    if (has_gradients) {
        std::vector<std::vector<int>> neighbours;
        for (const int c : changes.volumes) {
            auto &list = neighbours.emplace_back();
            for (const auto &neighbour : gradients.emplace_back(mean_gradient(parts, plan.rest, c, plan.members.of(c))))
                list.push_back(4 * body.row_of_node[neighbour.node]);
        }
        append_lists(std::move(neighbours), 4 * body.num_rows, body.mean_start, body.mean_node);
        body.mean_gradient.resize(4 * body.mean_node.size(), T(0));
        for (std::size_t k = 0; k < gradients.size(); ++k)
            put_mean_gradient(gradients[k], plan.number_of_volume[changes.volumes[k]], body);
        body.first_pull = padded(body.chunk_start.back() + 1);
        move_pulls(parts, changes, gradients, plan, body, sums);
    }
    if (parts.averages_volumes) {
        for (auto &number : body.mean_volume)
            number = renumbered[number];
        std::vector<std::vector<int>> neighbours;
        VolumeMeans means;
        for (const int c : changes.volumes) {
            auto &list = neighbours.emplace_back();
            for (const auto &neighbour :
                 means.emplace_back(volume_mean(parts, plan.rest_volume, c, plan.members.of(c))))
                list.push_back(plan.number_of_volume[neighbour.volume]);
        }
        append_lists(std::move(neighbours), 0, body.mean_start, body.mean_volume);
        body.mean_weight.resize(body.mean_volume.size(), T(0));
        for (std::size_t k = 0; k < means.size(); ++k)
            put_volume_mean(means[k], plan.number_of_volume[changes.volumes[k]], body);
    }
    for (const int c : changes.volumes)
        put_volume(parts, c, rest_volume(parts, plan.rest_volume, plan.members.of(c)), plan.number_of_volume[c], body);
}

template int filler_of_members(const StepParts &, const SlicedBody<float> &);
template int filler_of_members(const StepParts &, const SlicedBody<double> &);
template void add_volumes(const StepParts &, const PartingChanges &, std::span<const int>, int, SlicedPlan &,
                          SlicedBody<float> &, ForceSums<float> &);
template void add_volumes(const StepParts &, const PartingChanges &, std::span<const int>, int, SlicedPlan &,
                          SlicedBody<double> &, ForceSums<double> &);

} // namespace livermark::msm
