#include "meshes/cutting/cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "meshes/cutting/parting.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::meshes {

namespace {

constexpr double millilitres = 1e6, square_centimetres = 1e4, millimetres = 1e3;

/// A body on its way: what the cut goes along are faces of it.
struct CutMesh {
    core::Body body;                     ///< with the boundary and the patches before the cut, in nodes before it
    std::vector<int> parent_tetrahedron; ///< (M) ascending
    std::vector<bool> alive;             ///< (M) what is not taken away
    std::vector<int> parent_node;        ///< (N) the node in which the boundary before is written
};

[[noreturn]] void refuse(const Cut &cut, const std::string &what, const std::string &remedy) {
    throw support::InputError("{}: {}; {}", cut.place, what, remedy);
}

/// A blade without thickness, which parts.
const BladeCut *parting_blade(const Cut &cut) {
    const auto *blade = std::get_if<BladeCut>(&cut.tool);
    return blade && blade->thickness == 0.0 ? blade : nullptr;
}

template <class Number> std::vector<Number> counted(std::size_t size) {
    std::vector<Number> numbers(size);
    std::iota(numbers.begin(), numbers.end(), Number{0});
    return numbers;
}

CutMesh part(CutMesh cut, const Faces &faces, const Cut &definition) {
    auto parted = part_along(cut.body.mesh, faces);
    if (parted.num_faces == 0)
        throw CutMissesBody(definition.place, "the blade parts no face of a tetrahedron",
                            "let it go deeper into the body");
    cut.body.mesh.points = std::move(parted.points);
    cut.body.mesh.tetrahedra = std::move(parted.tetrahedra);
    cut.parent_node = std::move(parted.parent_node);
    return cut;
}

CutMesh along_facets(const core::Body &body, const Cut &cut) {
    const auto num = body.mesh.tetrahedra.size();
    CutMesh result{body, counted<int>(num), std::vector<bool>(num, true), counted<int>(body.mesh.points.size())};
    if (const auto *blade = parting_blade(cut))
        return part(std::move(result), faces_across(*blade, body.mesh), cut);
    result.alive = tetrahedra_taken(cut.tool, body.mesh);
    result.alive.flip();
    return result;
}

CutMesh along_surface(const core::Body &body, const Cut &cut) {
    const auto *blade = parting_blade(cut);
    auto split = blade ? split_along_blade(body, *blade) : split_along(body, cut.tool);
    split.taken.flip();
    CutMesh result{std::move(split.body), std::move(split.parent_tetrahedron), std::move(split.taken), {}};
    result.parent_node = counted<int>(result.body.mesh.points.size());
    return blade ? part(std::move(result), faces_on(*blade, result.body.mesh, split.is_on_cut), cut)
                 : std::move(result);
}

/// The patch of each face on the boundary before, -1 for the others.
std::vector<std::array<int, 4>> patches_of_faces(const CutMesh &cut) {
    const auto &mesh = cut.body.mesh;
    std::map<std::array<int, 3>, int> patch_of;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        patch_of[core::face_key(mesh.boundary_triangles[f])] = mesh.boundary_patch[f];
    }
    std::vector<std::array<int, 4>> patches(mesh.tetrahedra.size(), {-1, -1, -1, -1});
    for (std::size_t t = 0; t < patches.size(); ++t) {
        auto nodes = mesh.tetrahedra[t];
        for (int &node : nodes)
            node = cut.parent_node[node];
        for (std::size_t k = 0; k < 4; ++k)
            if (const auto found = patch_of.find(core::face_key(nodes, k)); found != patch_of.end())
                patches[t][k] = found->second;
    }
    return patches;
}

/// A piece as a body of its own.
core::Body body_of(const CutMesh &cut, const std::vector<int> &piece, const Faces &is_wound,
                   const std::vector<std::array<int, 4>> &patches) {
    const auto &from = cut.body.mesh;
    core::Body body{
        .name = cut.body.name, .mesh = {}, .materials = {}, .capsule = cut.body.capsule, .vessels = cut.body.vessels};
    body.patch_confidence = cut.body.patch_confidence;
    body.axes = cut.body.axes;
    auto &mesh = body.mesh;
    std::vector<int> number(from.points.size(), -1);
    for (const int t : piece)
        for (const int node : from.tetrahedra[t])
            number[node] = 0;
    for (std::size_t node = 0; node < number.size(); ++node)
        if (number[node] == 0) {
            number[node] = mesh.num_nodes();
            mesh.points.push_back(from.points[node]);
        }
    mesh.region_names = from.region_names;
    mesh.patch_names = from.patch_names;
    auto wound = std::ranges::find(mesh.patch_names, core::wound_patch) - mesh.patch_names.begin();
    if (wound == std::ssize(mesh.patch_names))
        mesh.patch_names.emplace_back(core::wound_patch);
    for (const int t : piece) {
        auto &nodes = mesh.tetrahedra.emplace_back(from.tetrahedra[t]);
        for (int &node : nodes)
            node = number[node];
        mesh.region.push_back(from.region[t]);
        if (!cut.body.modulus_factor.empty())
            body.modulus_factor.push_back(cut.body.modulus_factor[t]);
        for (std::size_t k = 0; k < 4; ++k) {
            if (patches[t][k] < 0 && !is_wound[t][k])
                continue;
            const auto &[a, b, c] = core::tetrahedron_faces[k];
            mesh.boundary_triangles.push_back({nodes[a], nodes[b], nodes[c]});
            mesh.boundary_patch.push_back(patches[t][k] >= 0 ? patches[t][k] : static_cast<int>(wound));
        }
    }
    for (const int region : keep_used_groups(mesh.region, mesh.region_names))
        body.materials.push_back(cut.body.materials[region]);
    keep_used_groups(mesh.boundary_patch, mesh.patch_names);
    return body;
}

double area_of_patch(const core::TetraMesh &mesh, const std::string &name) {
    double area = 0.0;
    for (const int f : core::facets_in_patch(mesh, name))
        area += core::area_vector(mesh, f).norm();
    return area;
}

double volume_of(const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    return std::accumulate(volumes.begin(), volumes.end(), 0.0);
}

/// Smallest distance between the wound and the region that was taken away, as it was [m]; NaN without a margin.
double least_margin(const core::TetraMesh &before, const core::TetraMesh &left, const CutTool &tool) {
    const auto *cut = std::get_if<RegionCut>(&tool);
    if (!cut || cut->margin == 0.0)
        return std::numeric_limits<double>::quiet_NaN();
    using Corners = std::array<core::Vector3, 3>;
    std::vector<std::array<int, 4>> inside;
    for (std::size_t t = 0; t < before.tetrahedra.size(); ++t)
        if (before.region_names[before.region[t]] == cut->region)
            inside.push_back(before.tetrahedra[t]);
    std::vector<Corners> surface, wound;
    for (const auto &[a, b, c] : core::outer_faces(inside))
        surface.push_back({before.points[a], before.points[b], before.points[c]});
    for (int f = 0; f < left.num_boundary_triangles(); ++f)
        if (left.patch_names[left.boundary_patch[f]] == core::wound_patch) {
            const auto &[a, b, c] = left.boundary_triangles[f];
            wound.push_back({left.points[a], left.points[b], left.points[c]});
        }
    return distance_between(wound, surface);
}

/// Volume and mass of what is in none of the pieces that stay.
void add_up_removed(const CutMesh &cut, const std::vector<std::vector<int>> &pieces, CutBody &result) {
    std::vector<bool> stays(cut.alive.size(), false);
    for (const auto &piece : pieces)
        for (const int t : piece)
            stays[t] = true;
    const auto volumes = core::tetrahedron_volumes(cut.body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        if (!stays[t]) {
            result.removed_volume += volumes[t];
            result.removed_mass += cut.body.materials[cut.body.mesh.region[t]].density * volumes[t];
        }
}

void add_notes(const core::TetraMesh &before, const Cut &cut, std::span<const double> small_volumes, CutBody &result) {
    const auto &mesh = result.body.mesh;
    auto &notes = result.notes;
    notes.push_back(fmt::format(
        "cut {} {}: {:.4g} mL of {:.4g} mL are removed, and the wound has {:.4g} cm^2{}",
        cut.way == CutWay::facets ? "along facets" : "exactly", to_text(cut.tool), millilitres * result.removed_volume,
        millilitres * result.volume_before, square_centimetres * result.wound_area,
        std::isfinite(result.least_margin)
            ? fmt::format(", {:.3g} mm from the region where it is nearest", millimetres * result.least_margin)
            : ""));
    for (const double volume : small_volumes)
        notes.push_back(fmt::format("a loose piece of {:.3g} mL is {}", millilitres * volume,
                                    cut.small_pieces == SmallPieces::keep ? "a body of its own" : "taken away"));
    if (result.num_crumbs + result.num_spikes + result.num_bridges + result.num_hinges > 0)
        notes.push_back(
            fmt::format("parts that did not hold together at the wound are removed: {} crumbs, {} tetrahedra on one "
                        "face, {} that alone joined two parts, {} nodes at which parts touched",
                        result.num_crumbs, result.num_spikes, result.num_bridges, result.num_hinges));
    for (const auto &name : before.region_names)
        if (std::ranges::find(mesh.region_names, name) == mesh.region_names.end())
            notes.push_back(fmt::format("nothing is left of region '{}'", name));
    for (const auto &name : core::patches_of(before)) {
        if (name == core::wound_patch)
            continue;
        constexpr double rounding = 1e-9;
        const double left = area_of_patch(mesh, name) / area_of_patch(before, name);
        if (left == 0.0)
            notes.push_back(fmt::format("nothing is left of patch '{}'", name));
        else if (left < 1.0 - rounding)
            notes.push_back(fmt::format("patch '{}' loses {:.2g} % of its area", name, 100.0 * (1.0 - left)));
    }
}

void refuse_floating(const Cut &cut, const std::vector<double> &volumes, double before) {
    std::vector<std::string> shares;
    for (const double volume : volumes)
        shares.push_back(fmt::format("{:.2g} %", 100.0 * volume / before));
    throw CutNotOnBody(
        cut.place,
        fmt::format("the cut leaves {} pieces, with {} of the volume, and all but the largest would be loose",
                    volumes.size(), fmt::join(shares, ", ")),
        "remove the others with small pieces 'remove', or cut elsewhere");
}

} // namespace

CutBody cut(const core::Body &body, const Cut &cut) {
    check_cut(cut, body.mesh);
    auto cut_mesh = cut.way == CutWay::facets ? along_facets(body, cut) : along_surface(body, cut);
    if (std::ranges::none_of(cut_mesh.alive, std::identity{}))
        throw CutNotOnBody(cut.place, "the cut removes the whole body", "take a smaller part");
    if (!parting_blade(cut) && std::ranges::all_of(cut_mesh.alive, std::identity{}))
        throw CutMissesBody(cut.place, "the cut does not touch the body",
                            "check the size of the body with 'livermark mesh check'");
    const auto patches = patches_of_faces(cut_mesh);
    Faces was_outer(patches.size());
    for (std::size_t t = 0; t < patches.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            was_outer[t][k] = patches[t][k] >= 0;
    auto clean =
        clean_up(cut_mesh.body.mesh, cut_mesh.alive, core::face_neighbours(cut_mesh.body.mesh.tetrahedra), was_outer);
    const auto all_volumes = core::tetrahedron_volumes(cut_mesh.body.mesh);
    std::vector<double> volumes;
    for (const auto &piece : clean.pieces) {
        volumes.push_back(0.0);
        for (const int t : piece)
            volumes.back() += all_volumes[t];
    }
    CutBody result;
    result.volume_before = volume_of(body.mesh);
    if (volumes.empty())
        throw CutNotOnBody(cut.place, "no part of the body that the cut leaves holds together", "take a smaller part");
    if (volumes.size() > 1 && cut.small_pieces == SmallPieces::refuse)
        refuse_floating(cut, volumes, result.volume_before);
    if (cut.small_pieces != SmallPieces::keep)
        clean.pieces.resize(1);
    for (const auto &piece : clean.pieces) {
        auto part = body_of(cut_mesh, piece, clean.is_wound, patches);
        auto &parents = result.parents.emplace_back();
        for (const int t : piece)
            parents.push_back(cut_mesh.parent_tetrahedron[t]);
        if (result.parents.size() == 1) {
            result.body = std::move(part);
            continue;
        }
        part.name += fmt::format("_piece_{}", result.parents.size());
        part.assumptions = {fmt::format("a piece that was cut off from {}", body.name)};
        result.small_pieces.push_back(std::move(part));
    }
    add_up_removed(cut_mesh, clean.pieces, result);
    result.wound_area = area_of_patch(result.body.mesh, core::wound_patch);
    result.least_margin = least_margin(body.mesh, result.body.mesh, cut.tool);
    result.num_crumbs = clean.num_crumbs;
    result.num_spikes = clean.num_spikes;
    result.num_bridges = clean.num_bridges;
    result.num_hinges = clean.num_hinges;
    add_notes(body.mesh, cut, std::span(volumes).subspan(1), result);
    result.body.assumptions = body.assumptions;
    result.body.assumptions.insert(result.body.assumptions.end(), result.notes.begin(), result.notes.end());
    return result;
}

core::Body cut(core::Body body, std::span<const Cut> cuts) {
    for (std::size_t c = 0; c < cuts.size(); ++c) {
        for (std::size_t before = 0; before < c; ++before)
            if (cuts[before].tool == cuts[c].tool)
                refuse(cuts[c], fmt::format("this repeats the cut at {}", cuts[before].place), "leave one of them out");
        if (cuts[c].small_pieces == SmallPieces::keep)
            refuse(cuts[c], "small pieces cannot be kept as bodies of their own here",
                   "make them with 'livermark mesh cut --small-pieces keep', or remove them");
        body = cut(body, cuts[c]).body;
    }
    return body;
}

std::string to_text(const CutTool &tool) {
    const auto vector = [](const core::Vector3 &v) { return fmt::format("({:g}, {:g}, {:g})", v.x(), v.y(), v.z()); };
    if (const auto *region = std::get_if<RegionCut>(&tool))
        return fmt::format("around {} with {:g} mm", region->region, millimetres * region->margin);
    if (const auto *half_space = std::get_if<HalfSpaceCut>(&tool))
        return fmt::format("beyond the plane through {} m with normal {}", vector(half_space->point),
                           vector(half_space->normal));
    const auto &blade = std::get<BladeCut>(tool);
    return fmt::format("by a blade of {:g} mm between {}, {}, {} and {} m", millimetres * blade.thickness,
                       vector(blade.corners[0]), vector(blade.corners[1]), vector(blade.corners[2]),
                       vector(blade.corners[3]));
}

} // namespace livermark::meshes
