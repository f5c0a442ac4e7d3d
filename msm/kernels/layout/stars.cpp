#include "msm/kernels/layout/stars.hpp"

#include <algorithm>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/kernels/layout/fans.hpp"

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

} // namespace livermark::msm
