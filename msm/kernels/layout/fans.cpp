#include "msm/kernels/layout/fans.hpp"

#include <algorithm>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::msm {

namespace {

/// Even permutations of the corners that begin with each of the edges, in the order of core::tetrahedron_edges.
constexpr std::array<std::array<int, 4>, 6> even{
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};

using Edge = std::array<int, 2>;

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

EdgeLink edge_link(const std::array<int, 4> &nodes, int tetrahedron, std::size_t edge) {
    const auto &[i, j, a, b] = even[edge];
    // The other direction of the edge goes around the other way.
    if (nodes[i] < nodes[j])
        return {{nodes[i], nodes[j]}, {tetrahedron, nodes[a], nodes[b]}};
    return {{nodes[j], nodes[i]}, {tetrahedron, nodes[b], nodes[a]}};
}

std::vector<EdgeLink> edge_links(const std::vector<std::array<int, 4>> &tetrahedra) {
    std::vector<EdgeLink> links;
    links.reserve(6 * tetrahedra.size());
    for (std::size_t t = 0; t < tetrahedra.size(); ++t)
        for (std::size_t edge = 0; edge < even.size(); ++edge)
            links.push_back(edge_link(tetrahedra[t], static_cast<int>(t), edge));
    std::ranges::stable_sort(links, {}, &EdgeLink::edge);
    return links;
}

std::vector<Fan> cut_into_fans(const std::vector<std::array<int, 4>> &tetrahedra,
                               const std::vector<std::array<int, 4>> &corner_volume) {
    return Cutter(tetrahedra, corner_volume).cut();
}

} // namespace livermark::msm
