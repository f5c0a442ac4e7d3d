#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <utility>

#include "msm/kernels/layout/parting/parting.hpp"

namespace livermark::msm {

namespace {

/// Fans of some tetrahedra, with the numbers of these.
std::vector<Fan> fans_of(const StepParts &parts, const std::vector<int> &tetrahedra) {
    std::vector<std::array<int, 4>> nodes, volumes;
    for (const int t : tetrahedra) {
        nodes.push_back(parts.tetrahedra[t]);
        if (!parts.corner_volume.empty())
            volumes.push_back(parts.corner_volume[t]);
    }
    auto fans = cut_into_fans(nodes, volumes);
    for (auto &fan : fans)
        for (int &t : fan.tetrahedra)
            t = tetrahedra[t];
    return fans;
}

/// The stars of parts that have changed, from those that they had before; removed tetrahedra are left out.
std::vector<Star> changed_stars(const StepParts &parts, const PartingChanges &changes, const SlicedPlan &plan) {
    const auto first_new = static_cast<int>(plan.star_of_part.size());
    struct Links {
        std::array<int, 2> axis{};
        std::vector<Link> links;
    };
    std::map<int, Links> of_part;
    for (const int before : changes.edge_parts) {
        if (before >= first_new || plan.star_of_part[before] == padding)
            continue;
        for (const auto &corner : plan.stars[plan.star_of_part[before]].rim) {
            const int t = corner.tetrahedron;
            if (t < 0 || !parts.is_there(t))
                continue;
            for (std::size_t edge = 0; edge < 6; ++edge) {
                const int part = parts.edge_part[t][edge];
                if ((part < first_new ? part : changes.parent_edge_part[part - first_new]) != before)
                    continue;
                const auto [axis, link] = edge_link(parts.tetrahedra[t], t, edge);
                auto &of = of_part[part];
                of.axis = axis;
                of.links.push_back(link);
            }
        }
    }
    std::vector<Star> stars;
    for (auto &[part, of] : of_part)
        stars.push_back(star_of(part, of.axis, std::move(of.links)));
    return stars;
}

/// In place of a star one without volume, all of whose nodes are the start of its axis.
template <class T> void take_star_out(int lane, SlicedPlan &plan, SlicedBody<T> &body) {
    const int slice = lane / slice_size;
    const std::size_t first = first_star_corner(body, slice) + lane % slice_size;
    const auto length = static_cast<std::size_t>(body.star_start[slice + 1] - body.star_start[slice]);
    for (std::size_t k = 1; k < length + 2; ++k) {
        body.star_corner[first + k * slice_size] = body.star_corner[first];
        body.star_slot[first + k * slice_size] = body.star_slot[first];
    }
    for (std::size_t k = 0; k < length; ++k)
        body.star_tetrahedron[(static_cast<std::size_t>(body.star_start[slice]) + k) * slice_size + lane % slice_size] =
            T(0);
    for (auto *values : {&body.star_modulus, &body.star_inverse_volume, &body.star_stiffness})
        (*values)[lane] = T(0);
    plan.rim_size[lane] = 1;
    plan.star_of_part[plan.stars[lane].part] = padding;
}

/// Stars side by side, as star_lines() puts them, all in the first of some chunks.
/// @param piece  told where stars begin
template <class T> StarLines lines_of_stars(std::vector<Star> stars, SlicedBody<T> &piece) {
    StarLines lines;
    lines.stars = in_lanes(std::move(stars), piece);
    lines.stars.resize(static_cast<std::size_t>(padded(static_cast<int>(lines.stars.size()))));
    for (const auto &star : lines.stars)
        lines.rims.push_back(star.rim);
    piece.star_start.assign(1, 0);
    for (std::size_t first = 0; first < lines.stars.size(); first += slice_size) {
        const auto rims = std::span(lines.rims).subspan(first, slice_size);
        const std::size_t length = std::ranges::max_element(rims, {}, &Rim::size)->size();
        piece.longest_star = std::max(piece.longest_star, length);
        piece.star_start.push_back(piece.star_start.back() + static_cast<int>(length));
        append_nodes(std::span(lines.stars).subspan(first, slice_size), length, rims, lines.node);
    }
    piece.chunk_stars.assign(piece.chunk_fans.size(), static_cast<int>(lines.stars.size()) / slice_size);
    piece.chunk_stars.front() = 0;
    lines.chunk_before.assign(piece.chunk_fans.size(), 0);
    return lines;
}

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

template <class T>
void append_stars(const StepParts &parts, StarLines lines, const SlicedBody<T> &piece, int places_before,
                  SlicedPlan &plan, SlicedBody<T> &body) {
    const std::size_t first = plan.stars.size();
    for (const int node : lines.node)
        body.star_corner.push_back(node == padding ? 0 : 4 * body.row_of_node[node]);
    append_moved(piece.star_slot, 4 * places_before, body.star_slot);
    append_running(piece.star_start, body.star_start);
    append_running(piece.chunk_stars, body.chunk_stars);
    body.longest_star = std::max(body.longest_star, piece.longest_star);
    body.star_tetrahedron.resize(static_cast<std::size_t>(body.star_start.back()) * slice_size, T(0));
    for (auto *values : {&body.star_modulus, &body.star_inverse_volume, &body.star_stiffness})
        values->resize(first + lines.stars.size(), T(0));
    plan.star_of_part.resize(parts.edge_modulus.size(), padding);
    for (std::size_t k = 0; k < lines.stars.size(); ++k) {
        plan.rim_size.push_back(static_cast<int>(lines.rims[k].size()));
        if (lines.stars[k].rim.empty())
            continue;
        plan.star_of_part[lines.stars[k].part] = static_cast<int>(first + k);
        put_star(parts, plan.rounded_rest, lines.stars[k], lines.rims[k], first + k, body);
    }
    std::ranges::move(lines.stars, std::back_inserter(plan.stars));
}

} // namespace

template <class T>
void add_chunk(const StepParts &parts, const PartingChanges &changes, std::span<const int> row_of_volume,
               SlicedPlan &plan, SlicedBody<T> &body, ForceSums<T> &sums) {
    SlicedBody<T> piece; // the new chunk alone
    piece.row_of_node = body.row_of_node;
    piece.first_copy = body.first_copy;
    const auto lines = lines_of(fan_order(fans_of(parts, changes.tetrahedra), piece), piece);
    StarLines stars;
    if (body.is_around_edges()) {
        stars = lines_of_stars(changed_stars(parts, changes, plan), piece);
        const auto num_before = static_cast<int>(plan.star_of_part.size());
        for (const int part : changes.edge_parts)
            if (part < num_before && plan.star_of_part[part] != padding)
                take_star_out(plan.star_of_part[part], plan, body);
    }
    const auto places = force_places(lines, stars, piece);
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
    if (body.is_around_edges())
        append_stars(parts, std::move(stars), piece, places_before, plan, body);
}

template void add_chunk(const StepParts &, const PartingChanges &, std::span<const int>, SlicedPlan &,
                        SlicedBody<float> &, ForceSums<float> &);
template void add_chunk(const StepParts &, const PartingChanges &, std::span<const int>, SlicedPlan &,
                        SlicedBody<double> &, ForceSums<double> &);

} // namespace livermark::msm
