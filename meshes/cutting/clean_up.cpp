#include "meshes/cutting/clean_up.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "core/mesh/neighbours.hpp"
#include "meshes/cutting/articulations.hpp"

namespace livermark::meshes {

namespace {

/// Smaller pieces are crumbs [of the volume of all].
constexpr double crumb = 0.01;

bool has_corner(const std::array<int, 4> &tetrahedron, int node) {
    return std::ranges::find(tetrahedron, node) != tetrahedron.end();
}

class CleanUp {
  public:
    CleanUp(const core::TetraMesh &mesh, std::vector<bool> alive, const std::vector<std::array<int, 4>> &neighbours,
            const Faces &was_outer)
        : mesh_(mesh), alive_(std::move(alive)), neighbours_(neighbours), was_outer_(was_outer),
          volumes_(core::tetrahedron_volumes(mesh)), stars_(core::tetrahedra_at_nodes(mesh)) {
        smallest_piece_ = crumb * std::accumulate(volumes_.begin(), volumes_.end(), 0.0);
    }

    CleanMesh run() {
        do
            find_pieces();
        while (remove_spikes() || remove_bridges() || remove_hinges());
        find_wound();
        return std::move(result_);
    }

  private:
    bool is_joined(int t, std::size_t k) const { return neighbours_[t][k] >= 0 && alive_[neighbours_[t][k]]; }
    bool is_wound(int t, std::size_t k) const { return !is_joined(t, k) && !was_outer_[t][k]; }

    int num_wound(int t) const {
        int count = 0;
        for (std::size_t k = 0; k < 4; ++k)
            count += is_wound(t, k);
        return count;
    }

    double volume_of(std::span<const int> tetrahedra) const {
        double volume = 0.0;
        for (const int t : tetrahedra)
            volume += volumes_[t];
        return volume;
    }

    /// What hangs together by faces; crumbs go.
    void find_pieces() {
        auto &pieces = result_.pieces;
        pieces.clear();
        std::vector<bool> is_seen(alive_.size(), false);
        for (std::size_t first = 0; first < alive_.size(); ++first) {
            if (!alive_[first] || is_seen[first])
                continue;
            std::vector<int> piece{static_cast<int>(first)};
            is_seen[first] = true;
            for (std::size_t at = 0; at < piece.size(); ++at)
                for (std::size_t k = 0; k < 4; ++k)
                    if (const int t = piece[at]; is_joined(t, k) && !is_seen[neighbours_[t][k]]) {
                        is_seen[neighbours_[t][k]] = true;
                        piece.push_back(neighbours_[t][k]);
                    }
            std::ranges::sort(piece);
            pieces.push_back(std::move(piece));
        }
        std::ranges::stable_sort(pieces, std::ranges::greater(), [&](const auto &piece) { return volume_of(piece); });
        while (pieces.size() > 1 && volume_of(pieces.back()) < smallest_piece_) {
            for (const int t : pieces.back())
                alive_[t] = false;
            ++result_.num_crumbs;
            pieces.pop_back();
        }
    }

    bool remove_spikes() {
        bool has_changed = false;
        for (std::size_t t = 0; t < alive_.size(); ++t) {
            if (!alive_[t] || num_wound(static_cast<int>(t)) < 2)
                continue;
            int num_joined = 0;
            for (std::size_t k = 0; k < 4; ++k)
                num_joined += is_joined(static_cast<int>(t), k);
            if (num_joined > 1)
                continue;
            alive_[t] = false;
            ++result_.num_spikes;
            has_changed = true;
        }
        return has_changed;
    }

    bool remove_bridges() {
        bool has_changed = false;
        for (const auto &piece : result_.pieces)
            for (const int t : articulations(piece, neighbours_, alive_))
                if (num_wound(t) > 0) {
                    alive_[t] = false;
                    ++result_.num_bridges;
                    has_changed = true;
                    break; // what the others join is another question then
                }
        return has_changed;
    }

    bool remove_hinges() {
        find_wound();
        bool has_changed = false;
        std::vector<bool> has_lost(mesh_.points.size(), false); // is looked at again later
        for (const auto &piece : result_.pieces)
            for (const int node : pinched_nodes(piece, mesh_.tetrahedra, neighbours_, result_.is_wound)) {
                if (has_lost[node])
                    continue;
                for (const int t : hanging_at(node, piece)) {
                    alive_[t] = false;
                    for (const int corner : mesh_.tetrahedra[t])
                        has_lost[corner] = true;
                }
                ++result_.num_hinges;
                has_changed = true;
            }
        return has_changed;
    }

    std::vector<int> star_in(const std::vector<int> &piece, int node) const {
        std::vector<int> star;
        std::ranges::copy_if(stars_[node], std::back_inserter(star),
                             [&](int t) { return alive_[t] && std::ranges::binary_search(piece, t); });
        return star;
    }

    /// All but the largest of some groups.
    std::vector<int> smaller_of(const std::vector<std::vector<int>> &groups) const {
        const auto largest = std::ranges::max_element(groups, {}, [&](const auto &group) { return volume_of(group); });
        std::vector<int> others;
        for (auto group = groups.begin(); group != groups.end(); ++group)
            if (group != largest)
                others.insert(others.end(), group->begin(), group->end());
        return others;
    }

    /// What has to go at a pinched node: the smaller parts that an edge or the node alone joins to the rest, or all.
    std::vector<int> hanging_at(int node, const std::vector<int> &piece) const {
        auto star = star_in(piece, node);
        if (star.empty())
            return star;
        const auto joins = [&](int t, std::size_t k) { return is_joined(t, k); };
        if (const auto groups = groups_at_node(node, star, mesh_.tetrahedra, neighbours_, joins); groups.size() > 1)
            return smaller_of(groups);
        std::vector<int> others;
        for (const int t : star)
            others.insert(others.end(), mesh_.tetrahedra[t].begin(), mesh_.tetrahedra[t].end());
        std::ranges::sort(others);
        others.erase(std::unique(others.begin(), others.end()), others.end());
        for (const int other : others) {
            if (other == node)
                continue;
            std::vector<int> around;
            std::ranges::copy_if(star, std::back_inserter(around),
                                 [&](int t) { return has_corner(mesh_.tetrahedra[t], other); });
            const auto at_edge = [&](int t, std::size_t k) {
                return is_joined(t, k) && has_corner(mesh_.tetrahedra[neighbours_[t][k]], other);
            };
            if (const auto fans = groups_at_node(node, around, mesh_.tetrahedra, neighbours_, at_edge); fans.size() > 1)
                return smaller_of(fans);
        }
        return star;
    }

    void find_wound() {
        result_.is_wound.assign(alive_.size(), {false, false, false, false});
        for (const auto &piece : result_.pieces)
            for (const int t : piece)
                for (std::size_t k = 0; k < 4; ++k)
                    result_.is_wound[t][k] = is_wound(t, k);
    }

    const core::TetraMesh &mesh_;
    std::vector<bool> alive_;
    const std::vector<std::array<int, 4>> &neighbours_;
    const Faces &was_outer_;
    std::vector<double> volumes_;
    std::vector<std::vector<int>> stars_;
    double smallest_piece_ = 0.0;
    CleanMesh result_;
};

} // namespace

CleanMesh clean_up(const core::TetraMesh &mesh, std::vector<bool> alive,
                   const std::vector<std::array<int, 4>> &neighbours, const Faces &was_outer) {
    return CleanUp(mesh, std::move(alive), neighbours, was_outer).run();
}

std::vector<std::vector<int>> groups_at_node(int node, std::span<const int> star,
                                             std::span<const std::array<int, 4>> tetrahedra,
                                             const std::vector<std::array<int, 4>> &neighbours,
                                             const std::function<bool(int, std::size_t)> &joins) {
    std::vector<std::vector<int>> groups;
    std::vector<int> left(star.begin(), star.end());
    while (!left.empty()) {
        std::vector<int> group{left.front()};
        left.erase(left.begin());
        for (std::size_t at = 0; at < group.size(); ++at)
            for (std::size_t k = 0; k < 4; ++k) {
                const int t = group[at], other = neighbours[t][k];
                if (tetrahedra[t][k] == node || other < 0) // face k is opposite of corner k
                    continue;
                if (const auto found = std::ranges::find(left, other); found != left.end() && joins(t, k)) {
                    group.push_back(other);
                    left.erase(found);
                }
            }
        groups.push_back(std::move(group));
    }
    return groups;
}

std::vector<int> pinched_nodes(std::span<const int> inside, std::span<const std::array<int, 4>> tetrahedra,
                               const std::vector<std::array<int, 4>> &neighbours, const Faces &is_wound) {
    std::vector<bool> is_inside(tetrahedra.size(), false);
    for (const int t : inside)
        is_inside[t] = true;
    std::map<int, std::vector<std::array<int, 2>>> rims; // of nodes in the wound: the other two nodes of each triangle
    for (const int t : inside)
        for (std::size_t k = 0; k < 4; ++k)
            if (is_wound[t][k])
                for (const int corner : core::tetrahedron_faces[k])
                    rims[tetrahedra[t][corner]];
    for (const int t : inside)
        for (std::size_t k = 0; k < 4; ++k) {
            if (neighbours[t][k] >= 0 && is_inside[neighbours[t][k]])
                continue;
            const auto &face = core::tetrahedron_faces[k];
            for (std::size_t c = 0; c < 3; ++c)
                if (const auto rim = rims.find(tetrahedra[t][face[c]]); rim != rims.end())
                    rim->second.push_back({tetrahedra[t][face[(c + 1) % 3]], tetrahedra[t][face[(c + 2) % 3]]});
        }
    // Triangles of outward orientation make one ring if each goes on where one ends, and all come in turn.
    std::vector<int> pinched;
    for (const auto &[node, sides] : rims) {
        std::map<int, int> next;
        bool is_ring = true;
        for (const auto &[from, to] : sides)
            is_ring = next.emplace(from, to).second && is_ring;
        std::size_t length = 0;
        for (int at = sides.front()[0]; is_ring;) {
            const auto side = next.find(at);
            is_ring = side != next.end() && length < sides.size();
            if (!is_ring)
                break;
            ++length;
            at = side->second;
            if (at == sides.front()[0])
                break;
        }
        if (!is_ring || length != sides.size())
            pinched.push_back(node);
    }
    return pinched;
}

} // namespace livermark::meshes
