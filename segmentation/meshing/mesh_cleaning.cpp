#include "segmentation/meshing/mesh_cleaning.hpp"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <set>

#include "segmentation/meshing/mesh_links.hpp"

namespace livermark::segmentation {

namespace {

using Triangle = std::array<int, 3>;

double volume_of(const core::TetraMesh &mesh, const std::vector<int> &piece) {
    double volume = 0.0;
    for (const int t : piece) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        volume += core::signed_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]);
    }
    return volume;
}

/// Lists of tetrahedra that hang together across faces, where `together` says so of two regions.
template <class Together>
std::vector<std::vector<int>> connected(const core::TetraMesh &mesh, const MeshLinks &links, Together together) {
    std::vector<bool> seen(mesh.tetrahedra.size(), false);
    std::vector<std::vector<int>> pieces;
    for (int first = 0; first < mesh.num_tetrahedra(); ++first) {
        if (seen[first])
            continue;
        seen[first] = true;
        std::vector<int> piece{first};
        for (std::size_t next = 0; next < piece.size(); ++next)
            for (const int other : links.neighbour[piece[next]])
                if (other >= 0 && !seen[other] && together(mesh.region[piece[next]], mesh.region[other])) {
                    seen[other] = true;
                    piece.push_back(other);
                }
        pieces.push_back(std::move(piece));
    }
    return pieces;
}

std::map<int, int> num_pieces_of(const std::vector<LabelPiece> &wanted) {
    std::map<int, int> count;
    for (const auto &piece : wanted)
        ++count[piece.region];
    return count;
}

/// The region that shares most faces with a piece; `outside` if it has none but that.
int region_around(const core::TetraMesh &mesh, const MeshLinks &links, const std::vector<int> &piece) {
    std::map<int, int> num_faces;
    for (const int t : piece)
        for (int corner = 0; corner < 4; ++corner)
            if (const int region = region_across(mesh, links, t, corner); region != outside && region != mesh.region[t])
                ++num_faces[region];
    int best = outside;
    for (const auto &[region, faces] : num_faces)
        if (best == outside || faces > num_faces[best])
            best = region;
    return best;
}

void dissolve_islands(core::TetraMesh &mesh, const std::vector<LabelPiece> &wanted) {
    auto left = num_pieces_of(wanted);
    const auto links = mesh_links(mesh);
    for (const auto &piece : mesh_pieces(mesh))
        if (const int region = mesh.region[piece.front()]; left[region]-- <= 0) {
            const int around = region_around(mesh, links, piece);
            for (const int t : piece)
                mesh.region[t] = around;
        }
    drop_unused(mesh);

    const auto parts = connected(mesh, mesh_links(mesh), [](int, int) { return true; });
    const auto largest = std::ranges::max_element(parts, {}, [](const auto &part) { return part.size(); });
    for (auto part = parts.begin(); part != parts.end(); ++part)
        for (const int t : *part)
            if (part != largest)
                mesh.region[t] = outside;
    drop_unused(mesh);
}

/// The fans of boundary triangles at a node: triangles hang together across edges.
std::vector<std::vector<Triangle>> fans_at(int node, const std::vector<Triangle> &triangles) {
    std::vector<std::vector<Triangle>> fans;
    for (const auto &triangle : triangles) {
        std::vector<Triangle> merged{triangle};
        std::erase_if(fans, [&](const auto &fan) {
            const bool touches = std::ranges::any_of(fan, [&](const Triangle &other) {
                return std::ranges::any_of(
                    other, [&](int n) { return n != node && std::ranges::find(triangle, n) != triangle.end(); });
            });
            if (touches)
                merged.insert(merged.end(), fan.begin(), fan.end());
            return touches;
        });
        fans.push_back(std::move(merged));
    }
    return fans;
}

/// Nodes at which the boundary is not a disk.
std::vector<int> pinched_nodes(const core::TetraMesh &mesh) {
    std::vector<std::vector<Triangle>> triangles_of(mesh.points.size());
    for (const auto &triangle : core::outer_faces(mesh.tetrahedra))
        for (const int node : triangle)
            triangles_of[node].push_back(triangle);
    std::vector<int> pinched;
    for (int node = 0; node < mesh.num_nodes(); ++node) {
        const auto &triangles = triangles_of[node];
        if (triangles.empty())
            continue;
        std::map<int, int> uses; // of an edge, by its other node
        for (const auto &triangle : triangles)
            for (const int other : triangle)
                if (other != node)
                    ++uses[other];
        if (std::ranges::any_of(uses, [](const auto &use) { return use.second != 2; }) ||
            fans_at(node, triangles).size() > 1)
            pinched.push_back(node);
    }
    return pinched;
}

/// Takes away the smallest bunch of tetrahedra that hang together across faces at a pinched node; where there is one
/// bunch only, its tetrahedron with most boundary faces.
void open_pinch(core::TetraMesh &mesh, const MeshLinks &links, int node) {
    std::vector<std::vector<int>> bunches;
    std::set<int> left(links.tetrahedra_of[node].begin(), links.tetrahedra_of[node].end());
    while (!left.empty()) {
        std::vector<int> bunch{*left.begin()};
        left.erase(left.begin());
        for (std::size_t next = 0; next < bunch.size(); ++next)
            for (const int other : links.neighbour[bunch[next]])
                if (left.erase(other) > 0)
                    bunch.push_back(other);
        bunches.push_back(std::move(bunch));
    }
    auto smallest = *std::ranges::min_element(bunches, {}, [](const auto &bunch) { return bunch.size(); });
    if (bunches.size() == 1)
        smallest = {
            *std::ranges::max_element(smallest, {}, [&](int t) { return std::ranges::count(links.neighbour[t], -1); })};
    for (const int t : smallest)
        mesh.region[t] = outside;
}

} // namespace

std::vector<std::vector<int>> mesh_pieces(const core::TetraMesh &mesh) {
    auto pieces = connected(mesh, mesh_links(mesh), [](int a, int b) { return a == b; });
    std::ranges::stable_sort(pieces, std::greater(), [&](const auto &piece) { return volume_of(mesh, piece); });
    return pieces;
}

int num_wrong_pieces(const core::TetraMesh &mesh, const std::vector<LabelPiece> &wanted) {
    auto count = num_pieces_of(wanted);
    for (const auto &piece : mesh_pieces(mesh))
        --count[mesh.region[piece.front()]];
    int wrong = 0;
    for (const auto &[region, difference] : count)
        wrong += std::abs(difference);
    return wrong;
}

int num_pinches(const core::TetraMesh &mesh) {
    return static_cast<int>(pinched_nodes(mesh).size());
}

int num_shells(const core::TetraMesh &mesh) {
    std::vector<int> parent(mesh.points.size());
    for (int node = 0; node < mesh.num_nodes(); ++node)
        parent[node] = node;
    const auto root_of = [&](int node) {
        while (parent[node] != node)
            node = parent[node] = parent[parent[node]];
        return node;
    };
    std::set<int> nodes;
    for (const auto &triangle : core::outer_faces(mesh.tetrahedra))
        for (const int node : triangle) {
            nodes.insert(node);
            parent[root_of(node)] = root_of(triangle[0]);
        }
    std::set<int> roots;
    for (const int node : nodes)
        roots.insert(root_of(node));
    return static_cast<int>(roots.size());
}

void clean(core::TetraMesh &mesh, const std::vector<LabelPiece> &wanted) {
    constexpr int max_rounds = 10;
    for (int round = 0; round < max_rounds; ++round) {
        dissolve_islands(mesh, wanted);
        const auto pinched = pinched_nodes(mesh);
        if (pinched.empty())
            break;
        const auto links = mesh_links(mesh);
        for (const int node : pinched)
            open_pinch(mesh, links, node);
        drop_unused(mesh);
    }
}

} // namespace livermark::segmentation
