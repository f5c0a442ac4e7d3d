#include "meshes/cutting/parting.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::meshes {

namespace {

using core::Vector3;

Vector3 middle_of(const core::TetraMesh &mesh, std::size_t t) {
    const auto &[a, b, c, d] = mesh.tetrahedra[t];
    return 0.25 * (mesh.points[a] + mesh.points[b] + mesh.points[c] + mesh.points[d]);
}

/// Asks for every face inside of a mesh, once, and marks it from both sides.
template <class Ask> Faces faces_where(const core::TetraMesh &mesh, const Ask &ask) {
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    Faces faces(mesh.tetrahedra.size(), {false, false, false, false});
    for (std::size_t t = 0; t < faces.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            if (const int other = neighbours[t][k]; other > static_cast<int>(t) && ask(t, k, std::size_t(other))) {
                faces[t][k] = true;
                const auto back = std::ranges::find(neighbours[other], static_cast<int>(t));
                faces[other][back - neighbours[other].begin()] = true;
            }
    return faces;
}

/// A tetrahedron most of whose faces are parted goes to the other side: then the others of its faces are.
void smooth(Faces &faces, const std::vector<std::array<int, 4>> &neighbours) {
    for (bool has_changed = true; has_changed;) { // each change leaves fewer parted faces
        has_changed = false;
        for (std::size_t t = 0; t < faces.size(); ++t) {
            int num_inside = 0, num_parted = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                num_inside += neighbours[t][k] >= 0;
                num_parted += faces[t][k];
            }
            if (2 * num_parted <= num_inside)
                continue;
            has_changed = true;
            for (std::size_t k = 0; k < 4; ++k)
                if (const int other = neighbours[t][k]; other >= 0) {
                    const auto back = std::ranges::find(neighbours[other], static_cast<int>(t));
                    faces[t][k] = !faces[t][k];
                    faces[other][back - neighbours[other].begin()] = faces[t][k];
                }
        }
    }
}

/// The tetrahedra around a node, by what hangs together by faces at it. The first group has the first tetrahedron.
/// @param star   the tetrahedra at the node
/// @param joins  (tetrahedron, face) -> whether the face, which has another tetrahedron of the star behind it, joins
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

/// Gives the tetrahedra around a node that other faces do not join to the first one a node of their own.
void double_node(int node, std::span<const int> star, const core::TetraMesh &mesh, const Faces &faces,
                 const std::vector<std::array<int, 4>> &neighbours, PartedMesh &parted) {
    const auto groups =
        groups_at_node(node, star, mesh.tetrahedra, neighbours, [&](int t, std::size_t k) { return !faces[t][k]; });
    for (std::size_t group = 1; group < groups.size(); ++group) {
        const int copy = static_cast<int>(parted.points.size());
        parted.points.push_back(mesh.points[node]);
        parted.parent_node.push_back(node);
        for (const int t : groups[group])
            std::ranges::replace(parted.tetrahedra[t], node, copy);
    }
}

PartedMesh part_once(const core::TetraMesh &mesh, const Faces &faces,
                     const std::vector<std::array<int, 4>> &neighbours) {
    PartedMesh parted{mesh.points, mesh.tetrahedra, {}, 0};
    for (int node = 0; node < mesh.num_nodes(); ++node)
        parted.parent_node.push_back(node);
    std::vector<bool> is_at_cut(mesh.points.size(), false);
    for (std::size_t t = 0; t < faces.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            if (faces[t][k])
                for (const int corner : core::tetrahedron_faces[k])
                    is_at_cut[mesh.tetrahedra[t][corner]] = true;
    const auto stars = core::tetrahedra_at_nodes(mesh);
    for (int node = 0; node < mesh.num_nodes(); ++node)
        if (is_at_cut[node])
            double_node(node, stars[node], mesh, faces, neighbours, parted);
    return parted;
}

} // namespace

Faces faces_across(const BladeCut &blade, const core::TetraMesh &mesh) {
    // A centroid on the blade is on one side of it, for all faces of its tetrahedron.
    auto faces = faces_where(mesh, [&](std::size_t t, std::size_t, std::size_t other) {
        const Vector3 one = middle_of(mesh, t), next = middle_of(mesh, other);
        return crossing_of(blade, one, next) && is_above(blade, one) != is_above(blade, next);
    });
    smooth(faces, core::face_neighbours(mesh.tetrahedra));
    return faces;
}

Faces faces_on(const BladeCut &blade, const core::TetraMesh &mesh, const std::vector<bool> &is_on_cut) {
    return faces_where(mesh, [&](std::size_t t, std::size_t k, std::size_t other) {
        return std::ranges::all_of(core::tetrahedron_faces[k],
                                   [&](int corner) { return is_on_cut[mesh.tetrahedra[t][corner]]; }) &&
               is_above(blade, middle_of(mesh, t)) != is_above(blade, middle_of(mesh, other));
    });
}

PartedMesh part_along(const core::TetraMesh &mesh, Faces faces) {
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    while (true) {
        auto parted = part_once(mesh, faces, neighbours);
        const auto after = core::face_neighbours(parted.tetrahedra);
        Faces is_wound(faces.size(), {false, false, false, false});
        for (std::size_t t = 0; t < faces.size(); ++t)
            for (std::size_t k = 0; k < 4; ++k) {
                is_wound[t][k] = after[t][k] < 0 && neighbours[t][k] >= 0;
                parted.num_faces += is_wound[t][k] && neighbours[t][k] > static_cast<int>(t);
            }
        std::vector<bool> is_pinched(mesh.points.size(), false);
        std::vector<int> all(faces.size());
        for (std::size_t t = 0; t < all.size(); ++t)
            all[t] = static_cast<int>(t);
        const auto pinched = pinched_nodes(all, parted.tetrahedra, after, is_wound);
        if (pinched.empty())
            return parted;
        for (const int node : pinched)
            is_pinched[parted.parent_node[node]] = true;
        bool has_changed = false;
        for (std::size_t t = 0; t < faces.size(); ++t)
            for (std::size_t k = 0; k < 4; ++k)
                if (faces[t][k] && std::ranges::any_of(core::tetrahedron_faces[k], [&](int corner) {
                        return is_pinched[mesh.tetrahedra[t][corner]];
                    })) {
                    faces[t][k] = false;
                    has_changed = true;
                }
        if (!has_changed) // the body itself was no manifold there
            return parted;
    }
}

namespace {

struct Visit {
    int tetrahedron;
    int parent;
    std::size_t next_face = 0;
};

} // namespace

/// Tetrahedra without which a piece would fall into parts of which two have more than one tetrahedron.
/// (J. Hopcroft and R. Tarjan 1973, Algorithm 447: efficient algorithms for graph manipulation, Comm. ACM 16(6))
/// @param piece       tetrahedra that hang together by faces
/// @param neighbours  (M, 4) by face, -1 for none
/// @param alive       (M) those that are still there
/// @return numbers of tetrahedra
std::vector<int> articulations(std::span<const int> piece, const std::vector<std::array<int, 4>> &neighbours,
                               const std::vector<bool> &alive) {
    const std::size_t num_all = neighbours.size();
    std::vector<int> order(num_all, -1), lowest(num_all, 0), size_below(num_all, 1);
    std::vector<int> cut_off(num_all, 0);     // tetrahedra in parts below that only this one joins
    std::vector<int> large_parts(num_all, 0); // how many of these parts have more than one
    if (piece.empty())
        return {};
    int count = 0;
    std::vector<Visit> path{{piece.front(), -1}};
    order[piece.front()] = lowest[piece.front()] = count++;
    while (!path.empty()) {
        auto &visit = path.back();
        const int t = visit.tetrahedron;
        if (visit.next_face < 4) {
            const int other = neighbours[t][visit.next_face++];
            if (other < 0 || !alive[other] || other == visit.parent)
                continue;
            if (order[other] >= 0) {
                lowest[t] = std::min(lowest[t], order[other]);
                continue;
            }
            order[other] = lowest[other] = count++;
            path.push_back({other, t}); // `visit` is no longer valid
            continue;
        }
        const int parent = visit.parent;
        path.pop_back();
        if (parent < 0)
            continue;
        lowest[parent] = std::min(lowest[parent], lowest[t]);
        size_below[parent] += size_below[t];
        if (lowest[t] >= order[parent]) {
            cut_off[parent] += size_below[t];
            large_parts[parent] += size_below[t] > 1;
        }
    }
    std::vector<int> found;
    for (const int t : piece) {
        const bool has_large_rest = count - 1 - cut_off[t] > 1;
        if (large_parts[t] + (has_large_rest ? 1 : 0) > 1)
            found.push_back(t);
    }
    return found;
}

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

    /// Parts that hang together by faces; crumbs go.
    void find_pieces() {
        auto &pieces = result_.pieces;
        pieces = parts_that_touch(alive_, [&](int t, const auto &visit) {
            for (std::size_t k = 0; k < 4; ++k)
                if (is_joined(t, k))
                    visit(neighbours_[t][k]);
        });
        for (auto &piece : pieces)
            std::ranges::sort(piece);
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

    /// Tetrahedra that have to go at a pinched node: the smaller parts that an edge or the node alone joins to the
    /// rest, or all.
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
