#include "app/live/find_cut.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include "app/live/parameters.hpp"
#include "app/live/way_out.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "meshes/cutting/cut.hpp"
#include "meshes/cutting/parting.hpp"

namespace livermark::live {

namespace {

using FaceKey = std::array<int, 3>;

/// Numbers of the boundary triangles of a mesh by their faces.
std::map<FaceKey, int> numbers_of_facets(const core::TetraMesh &mesh) {
    std::map<FaceKey, int> numbers;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        numbers[core::face_key(mesh.boundary_triangles[f])] = f;
    }
    return numbers;
}

} // namespace

Remains remains_of(const core::TetraMesh &whole, const std::vector<char> &is_gone, std::size_t num_facets) {
    Remains left;
    auto &mesh = left.mesh;
    mesh.points = whole.points;
    mesh.region_names = whole.region_names;
    mesh.patch_names = whole.patch_names;
    const auto wound = std::ranges::find(mesh.patch_names, core::wound_patch) - mesh.patch_names.begin();
    if (wound == std::ssize(mesh.patch_names))
        mesh.patch_names.emplace_back(core::wound_patch);
    for (std::size_t t = 0; t < whole.tetrahedra.size(); ++t)
        if (is_gone[t] == 0) {
            left.tetrahedron.push_back(static_cast<int>(t));
            mesh.tetrahedra.push_back(whole.tetrahedra[t]);
            mesh.region.push_back(whole.region[t]);
        }
    const auto number_of_facet = numbers_of_facets(whole);
    const auto neighbours = core::face_neighbours(mesh.tetrahedra);
    std::vector<char> is_left(whole.boundary_triangles.size(), 0);
    std::vector<std::array<int, 3>> in_wound;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k) {
            if (neighbours[t][k] >= 0)
                continue;
            const auto &nodes = mesh.tetrahedra[t];
            if (const auto found = number_of_facet.find(core::face_key(nodes, k)); found != number_of_facet.end()) {
                is_left[found->second] = 1;
                continue;
            }
            const auto &[a, b, c] = core::tetrahedron_faces[k];
            in_wound.push_back({nodes[a], nodes[b], nodes[c]});
        }
    for (int f = 0; f < whole.num_boundary_triangles(); ++f)
        if (is_left[f] != 0) {
            left.facet.push_back(static_cast<std::size_t>(f) < num_facets ? f : -1);
            mesh.boundary_triangles.push_back(whole.boundary_triangles[f]);
            mesh.boundary_patch.push_back(whole.boundary_patch[f]);
        }
    for (const auto &triangle : in_wound) {
        left.facet.push_back(-1);
        mesh.boundary_triangles.push_back(triangle);
        mesh.boundary_patch.push_back(static_cast<int>(wound));
    }
    return left;
}

std::vector<bool> constrained_remains(const Remains &remains, const std::vector<bool> &is_constrained) {
    std::vector<bool> constrained;
    for (const int facet : remains.facet)
        constrained.push_back(facet >= 0 && is_constrained[facet]);
    return constrained;
}

std::vector<double> remaining_factors(const Remains &remains, const core::Body &whole) {
    std::vector<double> factors;
    if (!whole.modulus_factor.empty())
        for (const int t : remains.tetrahedron)
            factors.push_back(whole.modulus_factor[t]);
    return factors;
}

double wound_area(const Remains &remains) {
    double area = 0.0;
    for (std::size_t f = 0; f < remains.facet.size(); ++f)
        if (remains.facet[f] < 0)
            area += core::area_vector(remains.mesh, static_cast<int>(f)).norm();
    return area;
}

namespace {

using Triangles = std::vector<std::array<core::Vector3, 3>>;

constexpr double millilitres_of = 1e6;
constexpr double largest_margin = 0.2; // [m]

[[noreturn]] void refuse_cut(const std::string &what, const std::string &remedy) {
    throw support::InputError(fmt::format("{}; {}", what, remedy));
}

void check_request(const CutRequest &request, const core::TetraMesh &mesh) {
    meshes::Cut cut{.tool = request.tool};
    meshes::check_cut(cut, mesh);
    if (const auto *region = std::get_if<meshes::RegionCut>(&request.tool)) {
        if (region->margin > largest_margin)
            refuse_cut(fmt::format("a margin of {:g} m", region->margin),
                       fmt::format("take one up to {:g} m", largest_margin));
        const auto &names = mesh.region_names;
        const auto number = static_cast<int>(std::ranges::find(names, region->region) - names.begin());
        if (std::ranges::find(mesh.region, number) == mesh.region.end())
            refuse_cut("nothing is left of this region", "choose another one");
    }
}

Triangles triangles_of_faces(const core::TetraMesh &mesh, const std::vector<std::array<int, 3>> &faces) {
    Triangles triangles;
    for (const auto &[a, b, c] : faces)
        triangles.push_back({mesh.points[a], mesh.points[b], mesh.points[c]});
    return triangles;
}

/// Along whole tetrahedra, as far from the region as it was asked for.
std::vector<bool> region_taken(const CutRequest &request, const core::TetraMesh &mesh,
                               const std::vector<std::array<int, 4>> &neighbours) {
    auto taken = meshes::tetrahedra_taken(request.tool, mesh);
    if (!request.keeps_margin)
        return taken;
    const double margin = std::get<meshes::RegionCut>(request.tool).margin;
    const auto level = meshes::tool_level(request.tool, mesh);
    for (std::size_t t = 0; t < taken.size(); ++t)
        if (std::ranges::any_of(mesh.tetrahedra[t], [&](int node) { return level.node_values[node] < 0.0; }))
            taken[t] = true;
    // A face may be nearer than its nodes.
    std::vector<std::array<int, 4>> inside;
    for (std::size_t t = 0; t < taken.size(); ++t)
        if (level.is_in_region[t])
            inside.push_back(mesh.tetrahedra[t]);
    const auto region = triangles_of_faces(mesh, core::outer_faces(inside));
    for (bool has_changed = true; has_changed;) {
        has_changed = false;
        for (std::size_t t = 0; t < taken.size(); ++t)
            for (std::size_t k = 0; k < 4 && !taken[t]; ++k) {
                if (neighbours[t][k] < 0 || !taken[neighbours[t][k]])
                    continue;
                const auto face = triangles_of_faces(mesh, {core::face_key(mesh.tetrahedra[t], k)});
                taken[t] = meshes::distance_between(face, region) < margin;
                has_changed = has_changed || taken[t];
            }
    }
    return taken;
}

/// The channel to the surface that a cut of a region needs, if it would leave a closed cavity; otherwise nothing.
std::vector<int> needed_way_out(const core::TetraMesh &whole, const Remains &before,
                                const std::vector<bool> &is_constrained, const CutRequest &request,
                                const std::vector<bool> &taken, const std::vector<std::array<int, 4>> &neighbours) {
    std::vector<char> is_gone(whole.tetrahedra.size(), 1);
    for (std::size_t t = 0; t < taken.size(); ++t)
        is_gone[before.tetrahedron[t]] = taken[t] ? 1 : 0;
    const auto closed = closed_cavities(remains_of(whole, is_gone, is_constrained.size()));
    const auto is_at_closed = [&](std::size_t t) {
        return taken[t] &&
               std::ranges::any_of(before.mesh.tetrahedra[t], [&](int node) { return closed.is_at[node] != 0; });
    };
    bool is_closed = false;
    for (std::size_t t = 0; t < taken.size() && !is_closed; ++t)
        is_closed = is_at_closed(t);
    if (!is_closed)
        return {};
    auto way = way_out(before, std::get<meshes::RegionCut>(request.tool).region, is_constrained, taken, neighbours);
    if (way.empty())
        refuse_cut("no channel as wide as this region leads to the surface past what is constrained and past other "
                   "regions",
                   "cut it out without opening the capsule, which leaves a closed cavity");
    return way;
}

/// Constraints of each piece, and of what goes.
struct Held {
    std::vector<bool> pieces;
    int num_lost = 0, num_all = 0; ///< constrained triangles
};

/// Marked ones of the boundary triangles that are left.
std::set<std::array<int, 3>> marked_faces(const Remains &before, const std::vector<bool> &is_marked) {
    std::set<std::array<int, 3>> marked;
    for (std::size_t f = 0; f < before.facet.size(); ++f)
        if (before.facet[f] >= 0 && is_marked[before.facet[f]])
            marked.insert(core::face_key(before.mesh.boundary_triangles[f]));
    return marked;
}

Held held_parts(const meshes::CleanMesh &clean, const Remains &before, const std::vector<bool> &is_constrained,
                const std::vector<bool> &stands, const std::vector<std::array<int, 4>> &neighbours) {
    const auto constrained = marked_faces(before, is_constrained), standing = marked_faces(before, stands);
    Held held{.pieces = {}, .num_lost = static_cast<int>(constrained.size())};
    held.num_all = held.num_lost;
    for (const auto &piece : clean.pieces) {
        int count = 0;
        bool is_borne = false;
        for (const int t : piece)
            for (std::size_t k = 0; k < 4; ++k)
                if (neighbours[t][k] < 0) {
                    const auto face = core::face_key(before.mesh.tetrahedra[t], k);
                    count += constrained.contains(face) ? 1 : 0;
                    is_borne = is_borne || standing.contains(face);
                }
        held.pieces.push_back(count > 0 || is_borne);
        held.num_lost -= count;
    }
    return held;
}

/// See FoundCut::margin.
double margin_around_lesions(const core::TetraMesh &whole, std::size_t num_facets, const Remains &before,
                             const std::vector<bool> &stays) {
    const auto &mesh = before.mesh;
    const int main = largest_region(whole);
    std::set<int> cut_regions;
    for (std::size_t t = 0; t < stays.size(); ++t)
        if (!stays[t] && mesh.region[t] != main)
            cut_regions.insert(mesh.region[t]);
    if (cut_regions.empty())
        return std::numeric_limits<double>::quiet_NaN();
    for (std::size_t t = 0; t < stays.size(); ++t)
        if (stays[t] && cut_regions.contains(mesh.region[t]))
            return 0.0;
    std::vector<std::array<int, 4>> lesions;
    for (std::size_t t = 0; t < whole.tetrahedra.size(); ++t)
        if (cut_regions.contains(whole.region[t]))
            lesions.push_back(whole.tetrahedra[t]);
    std::vector<char> is_gone(whole.tetrahedra.size(), 1);
    for (std::size_t t = 0; t < stays.size(); ++t)
        if (stays[t])
            is_gone[before.tetrahedron[t]] = 0;
    const auto after = remains_of(whole, is_gone, num_facets);
    std::vector<std::array<int, 3>> wound;
    for (std::size_t f = 0; f < after.facet.size(); ++f)
        if (after.facet[f] < 0)
            wound.push_back(after.mesh.boundary_triangles[f]);
    return meshes::distance_between(triangles_of_faces(whole, core::outer_faces(lesions)),
                                    triangles_of_faces(whole, wound));
}

/// Nodes of what is constrained, shape (N).
std::vector<bool> constrained_nodes_of(const Remains &before, const std::vector<bool> &is_constrained) {
    return constrained_nodes(before.mesh, constrained_remains(before, is_constrained));
}

/// Tetrahedra that a cut leaves before it is looked for what does not hold together, and the way out of a region.
std::vector<bool> left_by_tool(const core::TetraMesh &whole, const Remains &before,
                               const std::vector<bool> &is_constrained, const std::vector<core::Vector3> &displacement,
                               const CutRequest &request, const std::vector<std::array<int, 4>> &neighbours,
                               std::vector<int> &way) {
    std::vector<bool> taken;
    if (std::holds_alternative<meshes::RegionCut>(request.tool)) {
        taken = region_taken(request, before.mesh, neighbours);
        if (request.opens)
            way = needed_way_out(whole, before, is_constrained, request, taken, neighbours);
        for (const int t : way)
            taken[t] = true;
    } else {
        auto moved = before.mesh;
        for (std::size_t i = 0; i < displacement.size(); ++i)
            moved.points[i] += displacement[i];
        taken = meshes::tetrahedra_taken(request.tool, moved);
    }
    taken.flip();
    if (std::ranges::all_of(taken, std::identity{}))
        refuse_cut("the cut touches nothing of the body", "lead it through the body");
    if (std::ranges::none_of(taken, std::identity{}))
        refuse_cut("the cut takes all of the body away", "take a smaller part");
    return taken;
}

/// Finds what holds together, and what of it goes.
/// @param before     what there is, which may be parted already
/// @param alive      shape (M) of that, which the tool leaves
/// @param was_outer  shape (M, 4), faces on the boundary before the cut
void find_pieces(const core::TetraMesh &whole, const Remains &before, const std::vector<bool> &is_constrained,
                 const std::vector<bool> &stands, std::vector<bool> alive, const meshes::Faces &was_outer,
                 bool takes_loose, FoundCut &found) {
    const auto neighbours = core::face_neighbours(before.mesh.tetrahedra);
    const auto clean = meshes::clean_up(before.mesh, std::move(alive), neighbours, was_outer);
    if (clean.pieces.empty())
        refuse_cut("nothing of the body that the cut leaves holds together", "take a smaller part");
    const auto held = held_parts(clean, before, is_constrained, stands, neighbours);
    if (held.num_lost == held.num_all)
        refuse_cut("the cut takes away all that is constrained, and the body would fly away", "cut elsewhere");
    if (held.num_lost > 0)
        refuse_cut(fmt::format("the cut goes through what is constrained, of which {} of {} facets would go",
                               held.num_lost, held.num_all),
                   "cut elsewhere, or take less");
    const auto volumes = core::tetrahedron_volumes(before.mesh);
    std::vector<bool> stays(volumes.size(), false);
    double loose = 0.0;
    for (std::size_t piece = 0; piece < clean.pieces.size(); ++piece) {
        ++(held.pieces[piece] ? found.num_pieces : found.num_loose);
        for (const int t : clean.pieces[piece]) {
            stays[t] = held.pieces[piece];
            loose += held.pieces[piece] ? 0.0 : volumes[t];
        }
    }
    if (found.num_loose > 0 && !takes_loose)
        refuse_cut(fmt::format("the cut leaves {} that nothing holds, {:.3g} mL together",
                               found.num_loose == 1 ? "a piece" : fmt::format("{} pieces", found.num_loose),
                               millilitres_of * loose),
                   "take loose pieces away as well, or cut elsewhere");
    for (std::size_t t = 0; t < stays.size(); ++t)
        if (!stays[t]) {
            found.tetrahedra.push_back(before.tetrahedron[t]);
            found.volume += volumes[t];
        }
    found.margin = margin_around_lesions(whole, is_constrained.size(), before, stays);
}

} // namespace

FoundCut find_cut(const core::TetraMesh &original, const core::TetraMesh &whole, const Remains &before,
                  const std::vector<bool> &is_constrained, const std::vector<bool> &stands,
                  const std::vector<core::Vector3> &displacement, const CutRequest &request) {
    check_request(request, before.mesh);
    const auto neighbours = core::face_neighbours(before.mesh.tetrahedra);
    meshes::Faces was_outer(neighbours.size());
    for (std::size_t t = 0; t < neighbours.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            was_outer[t][k] = neighbours[t][k] < 0;
    FoundCut found;
    if (const auto *blade = std::get_if<meshes::BladeCut>(&request.tool); blade && blade->thickness == 0.0) {
        found.parted =
            part_body(original, whole, before, constrained_nodes_of(before, is_constrained), displacement, *blade);
        std::vector<char> is_gone(whole.tetrahedra.size(), 1);
        for (const int t : before.tetrahedron)
            is_gone[t] = 0;
        const auto &mesh = found.parted->mesh;
        const auto parted = remains_of(mesh, is_gone, is_constrained.size());
        find_pieces(mesh, parted, is_constrained, stands, std::vector<bool>(neighbours.size(), true), was_outer,
                    request.takes_loose, found);
        return found;
    }
    std::vector<int> way;
    auto alive = left_by_tool(whole, before, is_constrained, displacement, request, neighbours, way);
    find_pieces(whole, before, is_constrained, stands, std::move(alive), was_outer, request.takes_loose, found);
    const auto volumes = core::tetrahedron_volumes(before.mesh);
    for (const int t : way)
        found.way_volume += volumes[t];
    return found;
}

} // namespace livermark::live
