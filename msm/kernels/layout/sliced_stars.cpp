#include <algorithm>
#include <iterator>
#include <map>
#include <span>
#include <tuple>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

namespace {

using Edge = std::array<int, 2>;

/// Which part is around an edge of a tetrahedron.
int part_of(const StepParts &parts, int tetrahedron, const Edge &edge) {
    const auto &nodes = parts.tetrahedra[tetrahedron];
    const auto is_edge = [&](const std::array<int, 2> &local) {
        return std::minmax({nodes[local[0]], nodes[local[1]]}) == std::minmax({edge[0], edge[1]});
    };
    const auto found = std::ranges::find_if(core::tetrahedron_edges, is_edge);
    return parts.edge_part[tetrahedron][found - core::tetrahedron_edges.begin()];
}

/// The polygon of the tetrahedra of one part, chain after chain.
std::vector<Star::Corner> polygon(std::vector<Link> links, int start_of_axis) {
    std::vector<Star::Corner> rim;
    const auto follow = [&](std::vector<Link>::iterator at) {
        const int first = at->from;
        for (;;) {
            const int to = at->to;
            rim.push_back({at->from, at->tetrahedron});
            links.erase(at);
            at = std::ranges::find(links, to, &Link::from);
            if (at == links.end()) {
                if (to == first && links.empty() && rim.front().node == first)
                    return; // all the way around
                rim.push_back({to, -1});
                rim.push_back({start_of_axis, -1});
                return;
            }
        }
    };
    const auto begins = [&](const Link &link) { return std::ranges::find(links, link.from, &Link::to) == links.end(); };
    while (!links.empty()) {
        const auto first = std::ranges::find_if(links, begins);
        follow(first == links.end() ? links.begin() : first);
    }
    return rim;
}

} // namespace

Star star_of(int part, const std::array<int, 2> &axis, std::vector<Link> links) {
    return {axis, part, polygon(std::move(links), axis[0])};
}

std::vector<Star::Corner> rim_without(const Star &star, const std::vector<char> &is_removed, bool is_polygon) {
    const auto &rim = star.rim;
    const auto is_there = [&](std::size_t k) {
        const int t = rim[k % rim.size()].tetrahedron;
        return t >= 0 && (is_removed.empty() || is_removed[t] == 0);
    };
    std::vector<Star::Corner> result;
    if (is_removed.empty() || std::ranges::none_of(rim, [&](const Star::Corner &corner) {
            return corner.tetrahedron >= 0 && is_removed[corner.tetrahedron] != 0;
        }))
        return rim;
    result.reserve(2 * rim.size());
    if (!is_polygon) {
        for (std::size_t k = 0; k < rim.size(); ++k)
            result.push_back({rim[k].node, is_there(k) ? rim[k].tetrahedron : -1});
        return result;
    }
    std::size_t first = 0; // of a chain
    while (first < rim.size() && !(is_there(first) && !is_there(first + rim.size() - 1)))
        ++first;
    for (std::size_t k = first; first < rim.size() && k < first + rim.size(); ++k) {
        if (!is_there(k))
            continue;
        result.push_back(rim[k % rim.size()]);
        if (!is_there(k + 1)) {
            result.push_back({rim[(k + 1) % rim.size()].node, -1});
            result.push_back({star.axis[0], -1});
        }
    }
    if (result.empty())
        result.push_back({star.axis[0], -1});
    return result;
}

std::vector<Star> stars_around_edges(const StepParts &parts) {
    if (parts.edge_modulus.empty())
        return {};
    std::vector<Star> stars(parts.edge_modulus.size());
    std::vector<std::vector<Link>> links(stars.size());
    for (const auto &[edge, link] : edge_links(parts.tetrahedra)) {
        const int part = part_of(parts, link.tetrahedron, edge);
        stars[part].axis = edge;
        links[part].push_back(link);
    }
    for (std::size_t part = 0; part < stars.size(); ++part)
        stars[part] = star_of(static_cast<int>(part), std::array(stars[part].axis), std::move(links[part]));
    return stars;
}

namespace {

/// Which chunk of fans has each tetrahedron. @return shape (M)
template <class T>
std::vector<int> chunks_of_tetrahedra(const StepParts &parts, const Lines &lines, const SlicedBody<T> &body) {
    std::vector<int> chunk_of(parts.tetrahedra.size(), 0);
    for (std::size_t chunk = 0; chunk + 1 < body.chunk_fans.size(); ++chunk)
        for (int line = body.fan_start[body.chunk_fans[chunk]]; line < body.fan_start[body.chunk_fans[chunk + 1]];
             ++line)
            for (int lane = 0; lane < slice_size; ++lane)
                if (const int t = lines.tetrahedron[static_cast<std::size_t>(line) * slice_size + lane]; t != padding)
                    chunk_of[t] = static_cast<int>(chunk);
    return chunk_of;
}

/// The one that most tetrahedra of the star are in.
int chunk_of_star(const Star &star, const std::vector<int> &chunk_of_tetrahedron) {
    std::map<int, int> count;
    for (const auto &corner : star.rim)
        if (corner.tetrahedron >= 0)
            ++count[chunk_of_tetrahedron[corner.tetrahedron]];
    const auto fewer = [](const auto &a, const auto &b) { return a.second < b.second; };
    return std::ranges::max_element(count, fewer)->first;
}

/// Puts the nodes of a slice of stars behind those that are there.
/// @param length  of the longest rim
void append_nodes(std::span<const Star> stars, std::size_t length, std::span<const Rim> rims, std::vector<int> &nodes) {
    const std::size_t at = nodes.size();
    nodes.resize(at + (length + 2) * slice_size, padding);
    for (std::size_t lane = 0; lane < slice_size; ++lane) {
        if (rims[lane].empty())
            continue;
        for (std::size_t end = 0; end < 2; ++end)
            nodes[at + end * slice_size + lane] = stars[lane].axis[end];
        for (std::size_t k = 0; k < length; ++k)
            nodes[at + (2 + k) * slice_size + lane] = corner_of(rims[lane], length, k).node;
    }
}

std::vector<Rim> all_rims(const std::vector<Star> &stars, std::size_t first) {
    std::vector<Rim> rims;
    for (std::size_t lane = 0; lane < slice_size; ++lane)
        rims.push_back(stars[first + lane].rim);
    return rims;
}

} // namespace

template <class T> std::vector<Star> in_lanes(std::vector<Star> stars, const SlicedBody<T> &body) {
    std::ranges::sort(stars, {}, [&](const Star &star) {
        const auto [low, high] = std::minmax({body.row_of_node[star.axis[0]], body.row_of_node[star.axis[1]]});
        return std::tuple(-static_cast<int>(star.rim.size()), low, high, star.part);
    });
    std::vector<Star> ordered;
    for (auto first = stars.begin(); first != stars.end();) {
        const auto last =
            std::find_if(first, stars.end(), [&](const Star &star) { return star.rim.size() != first->rim.size(); });
        const auto count = static_cast<int>(last - first), num_slices = padded(count) / slice_size;
        for (int slice = 0; slice < num_slices; ++slice)
            for (int lane = 0; lane < slice_size; ++lane)
                if (const int at = lane * num_slices + slice; at < count)
                    ordered.push_back(std::move(first[at]));
        first = last;
    }
    return ordered;
}

template <class T> void put_side_by_side(StarLines &lines, SlicedBody<T> &body) {
    for (std::size_t first = 0; first < lines.stars.size(); first += slice_size) {
        const auto rims = std::span(lines.rims).subspan(first, slice_size);
        const std::size_t length = std::ranges::max_element(rims, {}, &Rim::size)->size();
        body.longest_star = std::max(body.longest_star, length);
        body.star_start.push_back(body.star_start.back() + static_cast<int>(length));
        append_nodes(std::span(lines.stars).subspan(first, slice_size), length, rims, lines.node);
    }
}

template <class T> StarLines star_lines(const StepParts &parts, const Lines &lines, SlicedBody<T> &body) {
    StarLines result;
    if (parts.edge_modulus.empty())
        return result;
    const auto chunk_of_tetrahedron = chunks_of_tetrahedra(parts, lines, body);
    std::vector<std::vector<Star>> stars_of_chunk(body.chunk_fans.size() - 1);
    for (auto &star : stars_around_edges(parts))
        stars_of_chunk[chunk_of_star(star, chunk_of_tetrahedron)].push_back(std::move(star));
    body.star_start.assign(1, 0);
    body.chunk_stars.assign(1, 0);
    result.chunk_before.assign(1, 0);
    for (auto &stars : stars_of_chunk) {
        auto ordered = in_lanes(std::move(stars), body);
        ordered.resize(padded(static_cast<int>(ordered.size())));
        for (std::size_t first = 0; first < ordered.size(); first += slice_size)
            append_nodes(std::span(ordered).subspan(first, slice_size), ordered[first].rim.size(),
                         all_rims(ordered, first), result.node_before);
        std::ranges::move(ordered, std::back_inserter(result.stars));
        body.chunk_stars.push_back(static_cast<int>(result.stars.size()) / slice_size);
        result.chunk_before.push_back(static_cast<int>(result.node_before.size()));
    }
    for (const auto &star : result.stars)
        result.rims.push_back(star.rim.empty() ? star.rim
                                               : rim_without(star, parts.is_removed,
                                                             parts.measure == StrainMeasure::deformation_gradient));
    put_side_by_side(result, body);
    return result;
}

template <class T>
void put_star(const StepParts &parts, const Eigen::VectorXd &x, const Star &star, const std::vector<Star::Corner> &rim,
              std::size_t s, SlicedBody<T> &body) {
    const std::size_t slice = s / slice_size, lane = s % slice_size;
    const auto length = static_cast<std::size_t>(body.star_start[slice + 1] - body.star_start[slice]);
    double volume = 0.0, stiffness = 0.0;
    for (std::size_t k = 0; k < length; ++k) {
        auto &inverse =
            body.star_tetrahedron[(static_cast<std::size_t>(body.star_start[slice]) + k) * slice_size + lane];
        const int t = corner_of(rim, length, k).tetrahedron;
        if (t < 0 || !parts.is_there(t)) {
            inverse = T(0);
            continue;
        }
        const auto &nodes = parts.tetrahedra[t];
        const auto [tetrahedron_volume, gradient] = volume_gradient(x, nodes);
        const auto corner = [&](int node) { return std::ranges::find(nodes, node) - nodes.begin(); };
        volume += tetrahedron_volume;
        stiffness -= parts.inner_modulus[t] / tetrahedron_volume *
                     gradient[corner(star.axis[0])].dot(gradient[corner(star.axis[1])]);
        inverse = static_cast<T>(1.0 / (6.0 * tetrahedron_volume));
    }
    body.star_modulus[s] = static_cast<T>(parts.edge_modulus[star.part] / 36.0);
    body.star_inverse_volume[s] = static_cast<T>(volume > 0.0 ? 1.0 / (6.0 * volume) : 0.0);
    body.star_stiffness[s] = static_cast<T>(stiffness);
}

template <class T> void append_stars(const StepParts &parts, StarLines lines, SlicedBody<T> &body, SlicedPlan &plan) {
    const std::size_t first = plan.stars.size();
    for (const int node : lines.node)
        body.star_corner.push_back(node == padding ? 0 : 4 * body.row_of_node[node]);
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

template <class T>
void slice_stars(const StepParts &parts, const std::vector<core::Vector3> &positions, StarLines lines,
                 SlicedBody<T> &body, SlicedPlan &plan) {
    if (parts.edge_modulus.empty())
        return;
    // As the kernels see it: where the rounding of rest differs from that of rows, a body at rest is under stress.
    auto at_rest = positions;
    body.rest_rows.assign(4 * static_cast<std::size_t>(body.num_rows), T(0));
    for (std::size_t i = 0; i < positions.size(); ++i)
        for (Eigen::Index c = 0; c < 3; ++c)
            at_rest[i][c] =
                body.rest_rows[4 * static_cast<std::size_t>(body.row_of_node[i]) + static_cast<std::size_t>(c)] =
                    static_cast<T>(positions[i][c]);
    plan.rounded_rest = to_unknowns(at_rest);
    append_stars(parts, std::move(lines), body, plan);
}

template std::vector<Star> in_lanes(std::vector<Star>, const SlicedBody<float> &);
template std::vector<Star> in_lanes(std::vector<Star>, const SlicedBody<double> &);
template void put_star(const StepParts &, const Eigen::VectorXd &, const Star &, const std::vector<Star::Corner> &,
                       std::size_t, SlicedBody<float> &);
template void put_star(const StepParts &, const Eigen::VectorXd &, const Star &, const std::vector<Star::Corner> &,
                       std::size_t, SlicedBody<double> &);
template void put_side_by_side(StarLines &, SlicedBody<float> &);
template void put_side_by_side(StarLines &, SlicedBody<double> &);
template StarLines star_lines(const StepParts &, const Lines &, SlicedBody<float> &);
template StarLines star_lines(const StepParts &, const Lines &, SlicedBody<double> &);
template void append_stars(const StepParts &, StarLines, SlicedBody<float> &, SlicedPlan &);
template void append_stars(const StepParts &, StarLines, SlicedBody<double> &, SlicedPlan &);
template void slice_stars(const StepParts &, const std::vector<core::Vector3> &, StarLines, SlicedBody<float> &,
                          SlicedPlan &);
template void slice_stars(const StepParts &, const std::vector<core::Vector3> &, StarLines, SlicedBody<double> &,
                          SlicedPlan &);

} // namespace livermark::msm
