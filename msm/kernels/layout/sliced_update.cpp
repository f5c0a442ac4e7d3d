#include <algorithm>
#include <array>
#include <utility>

#include "msm/kernels/layout/mean_gradients.hpp"
#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

/// The stars of a body with the lines of their slices as they become, from those that are there.
template <class T> class StarUpdate {
  public:
    StarUpdate(const StepParts &parts, SlicedPlan &plan, SlicedBody<T> &body)
        : parts_(parts), plan_(plan), body_(body) {}

    void run(const std::vector<int> &edge_parts) {
        std::vector<std::pair<int, std::vector<Star::Corner>>> rims; // by lane
        for (const int part : edge_parts) {
            const int lane = plan_.star_of_part[part];
            rims.emplace_back(lane, rim_without(plan_.stars[lane], parts_.is_removed, parts_.has_gradient_means));
            plan_.rim_size[lane] = static_cast<int>(rims.back().second.size());
        }
        find_slots(rims);
        lengthen_slices();
        for (std::size_t r = 0; r < rims.size(); ++r) {
            put_corners(rims[r].first, rims[r].second, slots_[r]);
            put_star(parts_, plan_.rounded_rest, plan_.stars[rims[r].first], rims[r].second, rims[r].first, body_);
        }
    }

  private:
    std::size_t length(const std::vector<int> &start, std::size_t slice) const {
        return start[slice + 1] - start[slice];
    }

    /// Of a node of a lane as its lines are now, four times its place for forces.
    int slot_of(int lane, int corner) const {
        const std::size_t slice = lane / slice_size;
        std::size_t at = (body_.star_start[slice] + 2 * slice) * slice_size + lane % slice_size;
        while (body_.star_corner[at] != corner)
            at += slice_size;
        return body_.star_slot[at];
    }

    void find_slots(const std::vector<std::pair<int, std::vector<Star::Corner>>> &rims) {
        for (const auto &[lane, rim] : rims) {
            auto &slots = slots_.emplace_back();
            for (const auto &corner : rim)
                slots.push_back(slot_of(lane, 4 * body_.row_of_node[corner.node]));
        }
    }

    /// Gives each slice as many lines as its longest star has; the others begin with their first node again.
    void lengthen_slices() {
        std::vector<int> start{0};
        for (std::size_t first = 0; first < plan_.rim_size.size(); first += slice_size)
            start.push_back(
                start.back() +
                *std::max_element(plan_.rim_size.begin() + static_cast<std::ptrdiff_t>(first),
                                  plan_.rim_size.begin() + static_cast<std::ptrdiff_t>(first + slice_size)));
        if (start == body_.star_start)
            return;
        const auto num_slices = start.size() - 1;
        const std::size_t num_lines = start.back();
        Aligned<std::int32_t> corner((num_lines + 2 * num_slices) * slice_size), slot(corner.size());
        Aligned<T> tetrahedron(num_lines * slice_size, T(0));
        body_.longest_star = 0;
        for (std::size_t slice = 0; slice < num_slices; ++slice) {
            const std::size_t was = length(body_.star_start, slice), is = length(start, slice);
            body_.longest_star = std::max(body_.longest_star, is);
            const std::size_t from = (body_.star_start[slice] + 2 * slice) * slice_size,
                              to = (start[slice] + 2 * slice) * slice_size;
            // What is more at the front is the first node again: so lines from behind, and then that.
            const auto move = [&](const auto &source, std::size_t source_at, auto &target, std::size_t target_at,
                                  bool repeats) {
                for (std::size_t k = 0; k < is; ++k) {
                    const bool is_new = k + was < is;
                    const std::size_t line = is_new ? 0 : k + was - is;
                    if (!is_new || repeats)
                        std::copy_n(source.begin() + static_cast<std::ptrdiff_t>(source_at + line * slice_size),
                                    slice_size,
                                    target.begin() + static_cast<std::ptrdiff_t>(target_at + k * slice_size));
                }
            };
            for (auto [source, target] : {std::pair(&body_.star_corner, &corner), std::pair(&body_.star_slot, &slot)}) {
                std::copy_n(source->begin() + static_cast<std::ptrdiff_t>(from), 2 * slice_size,
                            target->begin() + static_cast<std::ptrdiff_t>(to));
                move(*source, from + 2 * slice_size, *target, to + 2 * slice_size, true);
            }
            move(body_.star_tetrahedron, body_.star_start[slice] * slice_size, tetrahedron, start[slice] * slice_size,
                 false);
        }
        body_.star_start = std::move(start);
        body_.star_corner = std::move(corner);
        body_.star_slot = std::move(slot);
        body_.star_tetrahedron = std::move(tetrahedron);
    }

    void put_corners(int lane, const std::vector<Star::Corner> &rim, const std::vector<int> &slots) {
        const std::size_t slice = lane / slice_size, is = length(body_.star_start, slice), more = is - rim.size();
        std::size_t at = (body_.star_start[slice] + 2 * slice + 2) * slice_size + lane % slice_size;
        for (std::size_t k = 0; k < is; ++k, at += slice_size) {
            const std::size_t of_rim = k < more ? 0 : k - more;
            body_.star_corner[at] = 4 * body_.row_of_node[rim[of_rim].node];
            body_.star_slot[at] = slots[of_rim];
        }
    }

    const StepParts &parts_;
    SlicedPlan &plan_;
    SlicedBody<T> &body_;
    std::vector<std::vector<int>> slots_;
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
                put_spring(parts, s, place, body);
    for (const int c : changes.volumes) {
        const int number = plan.number_of_volume[c];
        const auto members = plan.members.of(c);
        put_volume(parts, c, rest_volume(parts, plan.rest, members), number, body);
        if (parts.has_mean_volumes)
            put_volume_mean(volume_mean(parts, plan.rest, c, members), number, body);
        if (!body.mean_gradient.empty())
            put_mean_gradient(mean_gradient(parts, plan.rest, c, members), number, body);
    }
    if (!changes.edge_parts.empty())
        StarUpdate<T>(parts, plan, body).run(changes.edge_parts);
}

template void update_sliced_body(const StepParts &, const CutChanges &, SlicedPlan &, SlicedBody<float> &);
template void update_sliced_body(const StepParts &, const CutChanges &, SlicedPlan &, SlicedBody<double> &);

} // namespace livermark::msm
