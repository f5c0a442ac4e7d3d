#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

/// Even permutations of the corners that begin with each of the edges, in the order of core::tetrahedron_edges.
constexpr std::array<std::array<int, 4>, 6> even{
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};

using Edge = std::array<int, 2>;

/// A tetrahedron as one of those around an edge: (edge, from, to) is an even permutation of its corners.
struct Link {
    int tetrahedron, from, to;
};
struct EdgeLink {
    Edge edge; ///< lower node number first
    Link link;
};

/// The tetrahedra around all edges, those of one edge behind each other.
std::vector<EdgeLink> edge_links(const std::vector<std::array<int, 4>> &tetrahedra) {
    std::vector<EdgeLink> links;
    links.reserve(even.size() * tetrahedra.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (const auto &[i, j, a, b] : even) {
            const auto &nodes = tetrahedra[t];
            const auto number = static_cast<int>(t);
            // The other direction of the edge goes around the other way.
            links.push_back(nodes[i] < nodes[j] ? EdgeLink{{nodes[i], nodes[j]}, {number, nodes[a], nodes[b]}}
                                                : EdgeLink{{nodes[j], nodes[i]}, {number, nodes[b], nodes[a]}});
        }
    std::ranges::stable_sort(links, {}, &EdgeLink::edge);
    return links;
}

class Cutter {
  public:
    Cutter(const std::vector<std::array<int, 4>> &tetrahedra, const std::vector<std::array<int, 4>> &corner_volume)
        : tetrahedra_(tetrahedra), corner_volume_(corner_volume), is_taken_(tetrahedra.size(), 0),
          links_(edge_links(tetrahedra)) {}

    std::vector<Fan> cut() {
        std::vector<std::pair<std::size_t, std::size_t>> edges;
        std::size_t longest = 0;
        for (std::size_t first = 0, end = 0; first < links_.size(); first = end) {
            while (end < links_.size() && links_[end].edge == links_[first].edge)
                ++end;
            edges.emplace_back(first, end);
            longest = std::max(longest, end - first);
        }
        std::vector<Fan> fans;
        for (std::size_t length = longest; length > 0; --length)
            for (const auto &[first, end] : edges)
                while (end - first >= length) {
                    auto fan = longest_fan(first, end);
                    if (fan.tetrahedra.size() < length)
                        break;
                    for (const int t : fan.tetrahedra)
                        is_taken_[t] = 1;
                    fans.push_back(std::move(fan));
                }
        return fans;
    }

  private:
    int volume_of(int tetrahedron, int node) const {
        if (corner_volume_.empty())
            return 0;
        const auto &corners = tetrahedra_[tetrahedron];
        return corner_volume_[tetrahedron][std::ranges::find(corners, node) - corners.begin()];
    }

    bool may_follow(const Link &last, const Link &next, const Edge &edge) const {
        if (is_taken_[next.tetrahedron] != 0 || next.from != last.to)
            return false;
        return std::ranges::all_of(std::array{edge[0], edge[1], last.to}, [&](int node) {
            return volume_of(last.tetrahedron, node) == volume_of(next.tetrahedron, node);
        });
    }

    /// The longest that free tetrahedra around an edge make.
    Fan longest_fan(std::size_t first, std::size_t end) const {
        Fan best;
        for (std::size_t start = first; start < end; ++start) {
            if (is_taken_[links_[start].link.tetrahedron] != 0)
                continue;
            Fan fan{links_[start].edge, {links_[start].link.from}, {}};
            for (std::size_t at = start; at < end;) {
                const auto &link = links_[at].link;
                fan.rim.push_back(link.to);
                fan.tetrahedra.push_back(link.tetrahedron);
                at = first;
                while (at < end && !(may_follow(link, links_[at].link, fan.axis) &&
                                     links_[at].link.tetrahedron != fan.tetrahedra.front()))
                    ++at;
            }
            if (fan.tetrahedra.size() > best.tetrahedra.size())
                best = std::move(fan);
        }
        return best;
    }

    const std::vector<std::array<int, 4>> &tetrahedra_;
    const std::vector<std::array<int, 4>> &corner_volume_;
    std::vector<char> is_taken_;
    std::vector<EdgeLink> links_;
};

} // namespace

std::vector<Fan> cut_into_fans(const std::vector<std::array<int, 4>> &tetrahedra,
                               const std::vector<std::array<int, 4>> &corner_volume) {
    return Cutter(tetrahedra, corner_volume).cut();
}

namespace {

/// Control volumes: large enough to find some of as many corners, small enough to stay near; of as many neighbours and
/// corners there are fewer.
constexpr std::size_t volume_window = 256, volume_window_with_neighbours = 1024;

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

/// Tetrahedra in the control volume of each row.
std::vector<std::vector<int>> tetrahedra_of_rows(const StepParts &parts, const std::vector<int> &row_of_volume,
                                                 const Lines &lines, int num_rows) {
    std::vector<std::vector<int>> row_lists(num_rows);
    for (std::size_t at = 0; at < lines.tetrahedron.size(); ++at)
        if (lines.tetrahedron[at] != padding)
            for (const int c : parts.corner_volume[lines.tetrahedron[at]])
                row_lists[row_of_volume[c]].push_back(static_cast<int>(at));
    return row_lists;
}

/// Corners of fans at each row, which have the sums over the tetrahedra there: less than half as many.
template <class T> std::vector<std::vector<int>> corners_of_rows(const Lines &lines, const SlicedBody<T> &body) {
    std::vector<std::vector<int>> row_lists(body.num_rows);
    for (std::size_t slice = 0; slice + 1 < body.fan_start.size(); ++slice) {
        const std::size_t first = first_corner(body, slice);
        for (auto at = first; at < first_corner(body, slice + 1); ++at) {
            const bool is_filled_up = at >= first + 3 * slice_size && lines.node[at] == lines.node[at - slice_size];
            if (lines.node[at] != padding && !is_filled_up)
                row_lists[body.corner[at] / 4].push_back(static_cast<int>(at));
        }
    }
    return row_lists;
}

/// @param num_neighbours  shape (C) of each control volume, which take longer than its members; empty if nobody asks
/// @return shape (C) which control volume of the sliced body it is
template <class T>
std::vector<int> slice_volumes(const StepParts &parts, const std::vector<int> &row_of_volume,
                               const std::vector<std::size_t> &num_neighbours, const Lines &lines,
                               SlicedBody<T> &body) {
    const bool is_coupled = !parts.coupled_modulus.empty() && !parts.has_means_of_tensors();
    const auto row_lists =
        is_coupled ? tetrahedra_of_rows(parts, row_of_volume, lines, body.num_rows) : corners_of_rows(lines, body);
    std::vector<int> volumes(row_of_volume.size());
    std::iota(volumes.begin(), volumes.end(), 0);
    std::ranges::sort(volumes, {}, [&](int c) { return row_of_volume[c]; });
    const auto length = [&](int c) {
        return std::pair(num_neighbours.empty() ? 0 : num_neighbours[c], row_lists[row_of_volume[c]].size());
    };
    sort_in_windows(volumes, num_neighbours.empty() ? volume_window : volume_window_with_neighbours,
                    [&](int a, int b) { return length(a) > length(b); });
    std::vector<int> number(volumes.size());
    std::vector<std::vector<int>> members;
    for (const int c : volumes) {
        number[c] = static_cast<int>(members.size());
        members.push_back(row_lists[row_of_volume[c]]);
        body.volume_row.push_back(row_of_volume[c]);
    }
    body.volume_row.resize(padded(static_cast<int>(volumes.size())), body.num_rows);
    body.volume_start.assign(1, 0);
    append_lists(members, static_cast<int>(is_coupled ? lines.tetrahedron.size() : lines.node.size()),
                 body.volume_start, body.member);
    if (!parts.volume_stiffness.empty())
        body.volume_stiffness.assign(body.volume_row.size(), T(0));
    for (std::size_t c = 0; c < parts.volume_stiffness.size(); ++c)
        body.volume_stiffness[number[c]] = static_cast<T>(0.25 * parts.volume_stiffness[c]);
    return number; // springs that are coupled put other numbers down, see put_volume()
}

/// Sizes of lists, one for each control volume.
template <class Lists> std::vector<std::size_t> sizes(const Lists &lists) {
    std::vector<std::size_t> size;
    for (const auto &list : lists)
        size.push_back(list.size());
    return size;
}

} // namespace

template <class T> std::vector<Fan> fan_order(std::vector<Fan> fans, SlicedBody<T> &body) {
    const auto rows = [&](const Fan &fan) -> std::pair<int, int> {
        return std::minmax({body.row_of_node[fan.axis[0]], body.row_of_node[fan.axis[1]]});
    };
    std::ranges::stable_sort(fans, {}, rows);
    std::vector<Fan> ordered;
    body.chunk_fans.assign(1, 0);
    for (std::size_t first = 0; first < fans.size(); first += chunk_size) {
        const auto begin = fans.begin() + static_cast<std::ptrdiff_t>(first);
        const auto end = fans.begin() + static_cast<std::ptrdiff_t>(std::min(first + chunk_size, fans.size()));
        std::stable_sort(begin, end,
                         [](const Fan &a, const Fan &b) { return a.tetrahedra.size() > b.tetrahedra.size(); });
        std::move(begin, end, std::back_inserter(ordered));
        ordered.resize(padded(static_cast<int>(ordered.size())));
        body.chunk_fans.push_back(static_cast<int>(ordered.size()) / slice_size);
    }
    return ordered;
}

template <class T> Lines lines_of(const std::vector<Fan> &fans, SlicedBody<T> &body) {
    Lines lines;
    body.fan_start.assign(1, 0);
    for (std::size_t first = 0; first < fans.size(); first += slice_size) {
        const std::size_t length = fans[first].tetrahedra.size(); // the longest of the slice comes first
        const std::size_t first_tetrahedron = lines.tetrahedron.size(), first_node = lines.node.size();
        lines.tetrahedron.resize(first_tetrahedron + length * slice_size, padding);
        lines.node.resize(first_node + (length + 3) * slice_size, padding);
        lines.owner.resize(lines.node.size(), padding);
        body.fan_start.push_back(body.fan_start.back() + static_cast<int>(length));
        for (std::size_t lane = 0; lane < slice_size; ++lane) {
            const auto &[axis, rim, tetrahedra] = fans[first + lane];
            if (tetrahedra.empty())
                continue;
            for (std::size_t k = 0; k < tetrahedra.size(); ++k)
                lines.tetrahedron[first_tetrahedron + k * slice_size + lane] = tetrahedra[k];
            for (std::size_t k = 0; k < length + 3; ++k) {
                const std::size_t at = first_node + k * slice_size + lane;
                lines.node[at] = k < 2 ? axis[k] : rim[std::min(k - 2, rim.size() - 1)];
                lines.owner[at] = k < 3 ? tetrahedra.front() : tetrahedra[std::min(k - 3, tetrahedra.size() - 1)];
            }
        }
    }
    return lines;
}

template <class T> std::vector<std::vector<int>> force_places(const Lines &lines, SlicedBody<T> &body) {
    std::vector<std::vector<int>> places(body.first_copy);
    body.force_slot.assign(lines.node.size(), 0);
    body.chunk_start.assign(1, 0);
    int num_places = 0;
    const auto place_of = [&](int node) {
        const int first = 4 * body.chunk_start.back(); // a fan of nothing adds nothing
        if (node == padding)
            return first;
        auto &node_places = places[body.row_of_node[node]];
        if (node_places.empty() || node_places.back() < first)
            node_places.push_back(4 * num_places++);
        return node_places.back();
    };
    for (std::size_t chunk = 0; chunk + 1 < body.chunk_fans.size(); ++chunk) {
        const std::size_t end = first_corner(body, body.chunk_fans[chunk + 1]);
        for (auto at = first_corner(body, body.chunk_fans[chunk]); at < end; ++at)
            body.force_slot[at] = place_of(lines.node[at]);
        body.chunk_start.push_back(num_places);
    }
    return places;
}

template <class T> void take_out(std::size_t place, SlicedBody<T> &body) {
    for (auto *values : {&body.rest_volume, &body.volume_share, &body.tetrahedron_stiffness, &body.least_volume,
                         &body.watched_volume, &body.guard_stiffness, &body.inner_modulus, &body.volume_modulus})
        if (!values->empty())
            (*values)[place] = T(0);
}

template <class T>
void slice_tetrahedra(const StepParts &parts, const std::vector<core::Vector3> &positions, SlicedBody<T> &body,
                      SlicedPlan &plan) {
    const auto row_of_volume = volume_rows(parts, body);
    plan.fans = fan_order(cut_into_fans(parts.tetrahedra, parts.corner_volume), body);
    const auto lines = lines_of(plan.fans, body);

    plan.rest = to_unknowns(positions);
    plan.rest_volume = rest_volumes(parts, plan.rest);
    body.rest_volume = on_lines<T>(plan.rest_volume, lines);
    body.volume_share = on_lines<T>(std::vector<double>(plan.rest_volume.size(), 1.0), lines);
    body.tetrahedron_stiffness = on_lines<T>(parts.tetrahedron_stiffness, lines);
    body.least_volume = on_lines<T>(parts.least_volume, lines);
    body.watched_volume = on_lines<T>(parts.watched_volume, lines);
    body.guard_stiffness = on_lines<T>(parts.guard_stiffness, lines);

    body.corner.assign(lines.node.size(), 0);
    for (std::size_t at = 0; at < lines.node.size(); ++at) {
        if (lines.node[at] == padding)
            continue;
        int row = body.row_of_node[lines.node[at]];
        if (!parts.centre.empty()) {
            const auto &corners = parts.tetrahedra[lines.owner[at]];
            const auto corner = std::ranges::find(corners, lines.node[at]) - corners.begin();
            row = row_of_volume[parts.corner_volume[lines.owner[at]][corner]];
        }
        body.corner[at] = 4 * row;
    }
    auto places = force_places(lines, body);
    slice_shapes(parts, plan.rest, lines, body);
    if (!parts.centre.empty()) {
        const auto gradients = mean_gradients(parts, positions);
        const auto means = volume_means(parts, positions);
        const auto number_of_volume =
            slice_volumes(parts, row_of_volume, gradients.empty() ? sizes(means) : sizes(gradients), lines, body);
        slice_volume_means(means, number_of_volume, body);
        slice_nodal_springs(parts, positions, number_of_volume, gradients, lines, places, body);
        plan.number_of_volume = number_of_volume;
        plan.members = volume_members(parts);
    }
    plan.tetrahedron_place.resize(parts.tetrahedra.size());
    for (std::size_t slice = 0; slice + 1 < body.fan_start.size(); ++slice)
        plan.fan_slice.resize(static_cast<std::size_t>(body.fan_start[slice + 1]), static_cast<int>(slice));
    for (std::size_t at = 0; at < lines.tetrahedron.size(); ++at)
        if (const int t = lines.tetrahedron[at]; t != padding) {
            plan.tetrahedron_place[t] = static_cast<int>(at);
            if (!parts.is_there(t))
                take_out(at, body);
        }
    slice_edges(parts, plan, body);
    body.sum_start.assign(1, 0);
    append_lists(std::move(places), 4 * body.chunk_start.back(), body.sum_start, body.sum);
}

template std::vector<Fan> fan_order(std::vector<Fan>, SlicedBody<float> &);
template Lines lines_of(const std::vector<Fan> &, SlicedBody<float> &);
template std::vector<std::vector<int>> force_places(const Lines &, SlicedBody<float> &);
template std::vector<Fan> fan_order(std::vector<Fan>, SlicedBody<double> &);
template Lines lines_of(const std::vector<Fan> &, SlicedBody<double> &);
template std::vector<std::vector<int>> force_places(const Lines &, SlicedBody<double> &);
template void take_out(std::size_t, SlicedBody<float> &);
template void take_out(std::size_t, SlicedBody<double> &);
template void slice_tetrahedra(const StepParts &, const std::vector<core::Vector3> &, SlicedBody<float> &,
                               SlicedPlan &);
template void slice_tetrahedra(const StepParts &, const std::vector<core::Vector3> &, SlicedBody<double> &,
                               SlicedPlan &);

} // namespace livermark::msm
