#include "meshes/segmentation/meshing/mesh_operations.hpp"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "meshes/cutting/parting.hpp"
#include "meshes/generators/surface_mesh.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;

Vector3 place_of(const LabelFields &fields, std::size_t sample) {
    const std::size_t row = fields.size[0];
    const std::size_t column = fields.size[1];
    const std::array<std::size_t, 3> index{sample % row, sample / row % column, sample / row / column};
    return fields.low + fields.spacing * Vector3(static_cast<double>(index[0]), static_cast<double>(index[1]),
                                                 static_cast<double>(index[2]));
}

/// Distances in the index to the six samples around one; the grid is wider than the body, so all of them are there.
std::array<std::ptrdiff_t, 6> neighbour_offsets(const LabelFields &fields) {
    const std::ptrdiff_t row = fields.size[0];
    const std::ptrdiff_t slice = row * fields.size[1];
    return {-1, 1, -row, row, -slice, slice};
}

/// All samples of the piece that holds one of them.
std::vector<std::size_t> flood(const LabelDomain &domain, std::size_t start, std::vector<bool> &seen) {
    const auto offsets = neighbour_offsets(domain.fields);
    std::vector<std::size_t> piece{start};
    seen[start] = true;
    for (std::size_t next = 0; next < piece.size(); ++next)
        for (const auto offset : offsets)
            if (const std::size_t other = piece[next] + offset;
                !seen[other] && domain.label[other] == domain.label[start]) {
                seen[other] = true;
                piece.push_back(other);
            }
    return piece;
}

/// The last sample that a front from the border reaches.
std::size_t deepest_sample(const LabelDomain &domain, const std::vector<std::size_t> &piece,
                           std::vector<bool> &reached) {
    const auto offsets = neighbour_offsets(domain.fields);
    const int label = domain.label[piece.front()];
    std::vector<std::size_t> front;
    for (const auto sample : piece)
        if (std::ranges::any_of(offsets, [&](auto offset) { return domain.label[sample + offset] != label; })) {
            front.push_back(sample);
            reached[sample] = true;
        }
    for (std::size_t next = 0; next < front.size(); ++next)
        for (const auto offset : offsets)
            if (const std::size_t other = front[next] + offset; !reached[other] && domain.label[other] == label) {
                reached[other] = true;
                front.push_back(other);
            }
    return front.back();
}

std::optional<BorderPoint> first_border(const LabelDomain &domain, const Vector3 &start, const Vector3 &direction) {
    const int from = label_at(domain, start);
    const double step = 0.5 * domain.fields.spacing;
    const int max_steps = 2 * (domain.fields.size[0] + domain.fields.size[1] + domain.fields.size[2]);
    for (int i = 1; i <= max_steps; ++i) {
        Vector3 there = start + i * step * direction;
        int to = label_at(domain, there);
        if (to == from)
            continue;
        Vector3 here = there - step * direction;
        for (int halving = 0; halving < 20; ++halving) {
            const Vector3 middle = 0.5 * (here + there);
            if (const int label = label_at(domain, middle); label == from) {
                here = middle;
            } else {
                there = middle;
                to = label;
            }
        }
        return BorderPoint{there, from, to};
    }
    return std::nullopt;
}

} // namespace

std::vector<LabelPiece> find_pieces(const LabelDomain &domain, double smallest) {
    const double sample_volume = domain.fields.spacing * domain.fields.spacing * domain.fields.spacing;
    std::vector<bool> seen(domain.label.size(), false);
    std::vector<bool> reached(domain.label.size(), false);
    std::vector<LabelPiece> pieces;
    for (std::size_t sample = 0; sample < domain.label.size(); ++sample) {
        if (domain.label[sample] == outside || seen[sample])
            continue;
        const auto piece = flood(domain, sample, seen);
        pieces.push_back({domain.label[sample], sample_volume * static_cast<double>(piece.size()),
                          place_of(domain.fields, deepest_sample(domain, piece, reached))});
    }
    std::ranges::stable_sort(pieces, [](const auto &a, const auto &b) {
        return a.region != b.region ? a.region < b.region : a.volume > b.volume;
    });
    std::vector<LabelPiece> kept;
    for (const auto &piece : pieces)
        if (piece.volume >= smallest || kept.empty() || kept.back().region != piece.region)
            kept.push_back(piece);
    return kept;
}

std::vector<BorderPoint> border_points(const LabelDomain &domain, const std::vector<LabelPiece> &pieces, double edge) {
    std::vector<BorderPoint> points;
    for (const auto &piece : pieces) {
        const auto rays = [&](const std::vector<Vector3> &directions) {
            std::vector<BorderPoint> found;
            for (const auto &direction : directions)
                if (const auto point = first_border(domain, piece.deepest, direction))
                    found.push_back(*point);
            return found;
        };
        std::vector<Vector3> directions;
        for (int d = 0; d < 3; ++d)
            for (const double sign : {-1.0, 1.0})
                directions.push_back(sign * Vector3::Unit(d));
        auto found = rays(directions);
        double depth = edge;
        for (const auto &point : found)
            depth = std::min(depth, (point.place - piece.deepest).norm());
        // Six directions make an octahedron, which is what a piece of about one edge can be at best.
        if (depth > 0.75 * edge)
            found = rays(meshes::geodesic_sphere(depth > 2.0 * edge ? 2 : 1).points);
        const double apart = std::min(0.6 * edge, 0.9 * depth);
        for (const auto &point : found)
            if (std::ranges::none_of(points,
                                     [&](const auto &other) { return (other.place - point.place).norm() < apart; }))
                points.push_back(point);
    }
    return points;
}

namespace {

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
    return meshes::parts_that_touch(std::vector(mesh.tetrahedra.size(), true), [&](int t, const auto &visit) {
        for (const int other : links.neighbour[t])
            if (other >= 0 && together(mesh.region[t], mesh.region[other]))
                visit(other);
    });
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

/// The tetrahedra of each part of a region that hangs together across faces, largest part first.
std::vector<std::vector<int>> mesh_pieces(const core::TetraMesh &mesh) {
    auto pieces = connected(mesh, mesh_links(mesh), [](int a, int b) { return a == b; });
    std::ranges::stable_sort(pieces, std::greater(), [&](const auto &piece) { return volume_of(mesh, piece); });
    return pieces;
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

/// Nodes at which the boundary is not a disk.
std::vector<int> pinched_nodes(const core::TetraMesh &mesh) {
    std::vector<int> all(mesh.tetrahedra.size());
    std::iota(all.begin(), all.end(), 0);
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    meshes::Faces is_outer(all.size());
    for (std::size_t t = 0; t < all.size(); ++t)
        std::ranges::transform(neighbours[t], is_outer[t].begin(), [](int other) { return other < 0; });
    return meshes::pinched_nodes(all, mesh.tetrahedra, neighbours, is_outer);
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
