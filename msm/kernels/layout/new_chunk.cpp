#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <map>
#include <utility>

#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

template <class T> void ForceSums<T>::finish(SlicedBody<T> &body) const {
    const int end_of_chunks = body.chunk_start.back();
    const auto num_pulls = static_cast<int>(body.mean_node.size());
    const int pulls_by = 4 * (body.first_pull - first_pull_), middles_by = pulls_by + 4 * (num_pulls - num_pulls_);
    const auto moved = [&](std::int32_t place) -> std::int32_t {
        if (place < 4 * end_of_chunks_)
            return place;
        if (place == 4 * end_of_chunks_)
            return 4 * end_of_chunks; // filling
        return place + (place < 4 * (first_pull_ + num_pulls_) ? pulls_by : middles_by);
    };
    std::vector<char> is_left_out; // of the places of control volumes before
    if (num_pulls_ > 0) {
        is_left_out.assign(static_cast<std::size_t>(num_pulls_) + body.volume_row.size(), 0);
        for (const int number : left_out_) {
            const int slice = number / slice_size, lane = number % slice_size;
            for (int line = body.mean_start[slice]; line < body.mean_start[slice + 1]; ++line)
                is_left_out[line * slice_size + lane] = 1;
            is_left_out[num_pulls_ + number] = 1;
        }
    }
    const auto stays = [&](std::int32_t place) {
        return place != 4 * end_of_chunks_ &&
               (is_left_out.empty() || place < 4 * first_pull_ || is_left_out[place / 4 - first_pull_] == 0);
    };
    auto added = added_;
    std::ranges::sort(added, {}, &std::pair<int, int>::first);
    std::vector<char> is_touched(static_cast<std::size_t>(body.num_slices), 0);
    for (const auto &[row, place] : added)
        is_touched[row / slice_size] = 1;
    for (const int row : looked_at_)
        is_touched[row / slice_size] = 1;
    std::vector<int> start{0};
    start.reserve(static_cast<std::size_t>(body.num_slices) + 1);
    Aligned<std::int32_t> sum;
    sum.reserve(body.sum.size() + slice_size * added.size() / 2);
    auto next = added.begin();
    std::array<std::vector<std::int32_t>, slice_size> lists;
    const auto num_before = static_cast<int>(body.sum_start.size()) - 1;
    for (int slice = 0; slice < body.num_slices; ++slice) {
        const bool is_old = slice < num_before;
        const auto first = is_old ? static_cast<std::size_t>(body.sum_start[slice]) * slice_size : 0;
        const auto end = is_old ? static_cast<std::size_t>(body.sum_start[slice + 1]) * slice_size : 0;
        if (is_touched[slice] == 0) {
            const std::size_t to = sum.size();
            sum.resize(to + end - first);
            std::transform(body.sum.begin() + static_cast<std::ptrdiff_t>(first),
                           body.sum.begin() + static_cast<std::ptrdiff_t>(end),
                           sum.begin() + static_cast<std::ptrdiff_t>(to), moved);
            start.push_back(static_cast<int>(sum.size()) / slice_size);
            continue;
        }
        std::size_t longest = 0;
        for (std::size_t lane = 0; lane < slice_size; ++lane) {
            auto &list = lists[lane];
            list.clear();
            for (std::size_t at = first + lane; at < end; at += slice_size)
                if (stays(body.sum[at]))
                    list.push_back(moved(body.sum[at]));
            for (const int row = slice * slice_size + static_cast<int>(lane); next != added.end() && next->first == row;
                 ++next)
                list.push_back(next->second);
            longest = std::max(longest, list.size());
        }
        const std::size_t at = sum.size();
        sum.resize(at + longest * slice_size, 4 * end_of_chunks);
        for (std::size_t lane = 0; lane < slice_size; ++lane)
            for (std::size_t k = 0; k < lists[lane].size(); ++k)
                sum[at + k * slice_size + lane] = lists[lane][k];
        start.push_back(static_cast<int>(sum.size()) / slice_size);
    }
    body.sum = std::move(sum);
    body.sum_start = std::move(start);
}

template class ForceSums<float>;
template class ForceSums<double>;

namespace {

/// Fans of the tetrahedra whose nodes have changed: those in which they were, cut where they are no longer together.
class ChangedFans {
  public:
    ChangedFans(const StepParts &parts, const PartingChanges &changes, const SlicedPlan &plan, int num_nodes)
        : parts_(parts), changes_(changes), plan_(plan),
          first_new_(num_nodes - static_cast<int>(changes.parent_node.size())) {}

    std::vector<Fan> find() const {
        std::vector<std::array<int, 3>> places; // fan, number in the fan, tetrahedron
        for (const int t : changes_.tetrahedra) {
            const int place = plan_.tetrahedron_place[t], slice = plan_.fan_slice[place / slice_size];
            const int fan = slice * slice_size + place % slice_size;
            const auto &all = plan_.fans[fan].tetrahedra;
            places.push_back({fan, static_cast<int>(std::ranges::find(all, t) - all.begin()), t});
        }
        std::ranges::sort(places);
        std::vector<Fan> fans;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const auto [number, k, t] = places[i];
            const auto corners = corners_of(plan_.fans[number], k, t);
            const auto &nodes = parts_.tetrahedra[t];
            const std::array axis{nodes[corners[0]], nodes[corners[1]]};
            const bool follows = i > 0 && places[i - 1][0] == number && places[i - 1][1] + 1 == k &&
                                 fans.back().axis == axis && fans.back().rim.back() == nodes[corners[2]] &&
                                 have_same_volumes(places[i - 1][2], t, {axis[0], axis[1], nodes[corners[2]]});
            if (!follows)
                fans.push_back({axis, {nodes[corners[2]]}, {}});
            fans.back().rim.push_back(nodes[corners[3]]);
            fans.back().tetrahedra.push_back(t);
        }
        return fans;
    }

  private:
    int before(int node) const { return node < first_new_ ? node : changes_.parent_node[node - first_new_]; }

    /// Which corners of a tetrahedron are the axis, and the rim before and behind it.
    std::array<std::ptrdiff_t, 4> corners_of(const Fan &fan, int k, int tetrahedron) const {
        const auto &nodes = parts_.tetrahedra[tetrahedron];
        const auto corner = [&](int node) {
            return std::ranges::find(nodes, node, [&](int now) { return before(now); }) - nodes.begin();
        };
        return {corner(fan.axis[0]), corner(fan.axis[1]), corner(fan.rim[k]), corner(fan.rim[k + 1])};
    }

    bool have_same_volumes(int a, int b, const std::array<int, 3> &nodes) const {
        const auto volume = [&](int t, int node) {
            const auto &corners = parts_.tetrahedra[t];
            return parts_.corner_volume[t][std::ranges::find(corners, node) - corners.begin()];
        };
        return parts_.corner_volume.empty() ||
               std::ranges::all_of(nodes, [&](int node) { return volume(a, node) == volume(b, node); });
    }

    const StepParts &parts_;
    const PartingChanges &changes_;
    const SlicedPlan &plan_;
    int first_new_;
};

/// Appends running numbers, behind the last one that is there.
void append_running(const std::vector<int> &more, std::vector<int> &start) {
    const int last = start.back();
    for (std::size_t i = 1; i < more.size(); ++i)
        start.push_back(last + more[i]);
}

template <class Values> void append(const Values &more, Values &values) {
    values.insert(values.end(), more.begin(), more.end());
}
template <class Values> void append_moved(const Values &more, int by, Values &values) {
    for (const auto index : more)
        values.push_back(index + by);
}

/// Puts the tetrahedra of new fans on lines behind the others, with what was known of them.
template <class T> void append_tetrahedra(const Lines &lines, SlicedPlan &plan, SlicedBody<T> &body) {
    const std::size_t first = body.rest_volume.size();
    for (auto *values : {&body.rest_volume, &body.volume_share, &body.tetrahedron_stiffness, &body.least_volume,
                         &body.watched_volume, &body.guard_stiffness, &body.inner_modulus, &body.volume_modulus}) {
        if (values->empty())
            continue;
        values->resize(first + lines.tetrahedron.size(), T(0));
        for (std::size_t k = 0; k < lines.tetrahedron.size(); ++k)
            if (const int t = lines.tetrahedron[k]; t != padding)
                (*values)[first + k] = (*values)[static_cast<std::size_t>(plan.tetrahedron_place[t])];
    }
    for (std::size_t k = 0; k < lines.tetrahedron.size(); ++k)
        if (const int t = lines.tetrahedron[k]; t != padding) {
            take_out(static_cast<std::size_t>(plan.tetrahedron_place[t]), body);
            plan.tetrahedron_place[t] = static_cast<int>(first + k);
        }
}

} // namespace

template <class T>
void add_chunk(const StepParts &parts, const PartingChanges &changes, std::span<const int> row_of_volume,
               SlicedPlan &plan, SlicedBody<T> &body, ForceSums<T> &sums) {
    SlicedBody<T> piece; // the new chunk alone
    piece.row_of_node = body.row_of_node;
    piece.first_copy = body.first_copy;
    const ChangedFans changed(parts, changes, plan, static_cast<int>(body.row_of_node.size()));
    auto fans = fan_order(changed.find(), piece);
    const auto lines = lines_of(fans, piece);
    std::ranges::move(fans, std::back_inserter(plan.fans));
    const auto places = force_places(lines, piece);
    const int places_before = body.chunk_start.back();
    for (std::size_t row = 0; row < places.size(); ++row)
        for (const int place : places[row])
            sums.add(static_cast<int>(row), place + 4 * places_before);
    slice_shapes(parts, plan.rest, lines, piece);
    if (!body.rest_gradient.empty())
        append(piece.rest_gradient, body.rest_gradient);
    if (!body.rest_length.empty())
        append(piece.rest_length, body.rest_length);
    append_tetrahedra(lines, plan, body);
    for (std::size_t k = 0; k < lines.node.size(); ++k) {
        const int node = lines.node[k];
        int row = node == padding ? 0 : body.row_of_node[node];
        if (node != padding && !parts.centre.empty()) {
            const auto &corners = parts.tetrahedra[lines.owner[k]];
            const auto corner = std::ranges::find(corners, node) - corners.begin();
            row = row_of_volume[parts.corner_volume[lines.owner[k]][corner]];
        }
        body.corner.push_back(4 * row);
    }
    append_moved(piece.force_slot, 4 * places_before, body.force_slot);
    const auto slices_before = static_cast<int>(body.fan_start.size()) - 1;
    for (std::size_t slice = 0; slice + 1 < piece.fan_start.size(); ++slice)
        plan.fan_slice.resize(plan.fan_slice.size() +
                                  static_cast<std::size_t>(piece.fan_start[slice + 1] - piece.fan_start[slice]),
                              slices_before + static_cast<int>(slice));
    append_running(piece.fan_start, body.fan_start);
    append_running(piece.chunk_fans, body.chunk_fans);
    append_running(piece.chunk_start, body.chunk_start);
}

template void add_chunk(const StepParts &, const PartingChanges &, std::span<const int>, SlicedPlan &,
                        SlicedBody<float> &, ForceSums<float> &);
template void add_chunk(const StepParts &, const PartingChanges &, std::span<const int>, SlicedPlan &,
                        SlicedBody<double> &, ForceSums<double> &);

} // namespace livermark::msm
