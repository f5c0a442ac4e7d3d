#include "tests/cut_checks.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numeric>
#include <set>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::tests {

namespace {

using core::Vector3;
using meshes::CutWay;

double sum(const std::vector<double> &values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

double mass_of(const core::Body &body) {
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    double mass = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t)
        mass += body.materials[body.mesh.region[t]].density * volumes[t];
    return mass;
}

std::string fault_of_mesh(const core::Body &body) {
    const auto &mesh = body.mesh;
    std::set<std::array<int, 4>> seen;
    std::vector<bool> is_used(mesh.points.size(), false);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        if (!(meshes::tetrahedron_quality(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) > 1e-5))
            return fmt::format("tetrahedron {} is flat or inverted", t);
        auto key = mesh.tetrahedra[t];
        std::ranges::sort(key);
        if (!seen.insert(key).second)
            return fmt::format("tetrahedron {} is there twice", t);
        for (const int node : key)
            is_used[node] = true;
    }
    if (std::ranges::find(is_used, false) != is_used.end())
        return "a node is in no tetrahedron";
    if (core::apart_by_faces(mesh.tetrahedra))
        return "it is in several parts";
    for (std::size_t region = 0; region < mesh.region_names.size(); ++region)
        if (std::ranges::find(mesh.region, static_cast<int>(region)) == mesh.region.end())
            return fmt::format("nothing is in region {}", mesh.region_names[region]);
    for (std::size_t patch = 0; patch < mesh.patch_names.size(); ++patch)
        if (std::ranges::find(mesh.boundary_patch, static_cast<int>(patch)) == mesh.boundary_patch.end())
            return fmt::format("nothing is in patch {}", mesh.patch_names[patch]);
    if (mesh.region_names.size() != body.materials.size())
        return "there are more or fewer materials than regions";
    return fault_of_surface(mesh);
}

/// A tetrahedron along facets has the corners that it had; one that was split has its region.
std::string fault_of_parents(const core::Body &before, const meshes::Cut &cut, const core::Body &after,
                             const std::vector<int> &parents, std::vector<double> &volume_left) {
    const auto volumes = core::tetrahedron_volumes(after.mesh);
    for (std::size_t t = 0; t < parents.size(); ++t) {
        const int parent = parents[t];
        volume_left[parent] -= volumes[t];
        if (after.mesh.region_names[after.mesh.region[t]] != before.mesh.region_names[before.mesh.region[parent]])
            return fmt::format("tetrahedron {} has changed its region", t);
        if (cut.way == CutWay::exact)
            continue;
        if (t > 0 && parents[t - 1] >= parent)
            return fmt::format("tetrahedron {} of the body before is there twice", parent);
        for (std::size_t c = 0; c < 4; ++c)
            if (after.mesh.points[after.mesh.tetrahedra[t][c]] != before.mesh.points[before.mesh.tetrahedra[parent][c]])
                return fmt::format("tetrahedron {} has moved", t);
    }
    return "";
}

} // namespace

std::string fault_of_surface(const core::TetraMesh &mesh) {
    const auto sorted = [](std::array<int, 3> face) {
        std::ranges::sort(face);
        return face;
    };
    std::set<std::array<int, 3>> outer, named;
    for (const auto &face : core::outer_faces(mesh.tetrahedra))
        outer.insert(sorted(face));
    for (const auto &face : mesh.boundary_triangles)
        if (!named.insert(sorted(face)).second)
            return "a triangle of the boundary is there twice";
    if (outer != named)
        return "the boundary is not that of the tetrahedra";
    std::map<std::array<int, 2>, int> balance;
    std::map<int, std::vector<std::array<int, 2>>> rings;
    std::set<int> in_wound;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const auto &nodes = mesh.boundary_triangles[f];
        for (std::size_t c = 0; c < 3; ++c) {
            const int a = nodes[c], b = nodes[(c + 1) % 3];
            balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
            rings[a].push_back({b, nodes[(c + 2) % 3]});
            if (mesh.patch_names[mesh.boundary_patch[f]] == core::wound_patch)
                in_wound.insert(a);
        }
    }
    for (const auto &[edge, count] : balance)
        if (count != 0)
            return fmt::format("the boundary is open at the edge {} {}", edge[0], edge[1]);
    for (const int node : in_wound) {
        auto sides = rings[node];
        std::vector<int> reached{sides.front()[0]};
        std::set<int> ends;
        for (const auto &[from, to] : sides)
            if (!ends.insert(from).second)
                return fmt::format("the wound touches itself at an edge of node {}", node);
        while (true) {
            const auto next = std::ranges::find_if(sides, [&](const auto &side) { return side[0] == reached.back(); });
            if (next == sides.end())
                break;
            reached.push_back((*next)[1]);
            sides.erase(next);
        }
        if (!sides.empty() || reached.front() != reached.back())
            return fmt::format("the wound touches itself at node {}", node);
    }
    return "";
}

meshes::Cut random_cut(const core::Body &body, std::mt19937 &random) {
    const auto number = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
    };
    const auto box = core::bounding_box(body.mesh.points);
    const double size = box.diagonal().norm();
    const auto point = [&] {
        Vector3 x;
        for (int axis = 0; axis < 3; ++axis)
            x[axis] = number(box.min()[axis], box.max()[axis]);
        return x;
    };
    const auto direction = [&] {
        Vector3 x;
        do
            x = {number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0)};
        while (x.norm() > 1.0 || x.norm() < 0.1);
        return Vector3(x.normalized());
    };
    meshes::Cut cut{meshes::HalfSpaceCut{point(), direction()}};
    const auto &regions = body.mesh.region_names;
    const auto kind = random() % 4;
    if (kind == 0 && regions.size() > 1)
        cut.tool = meshes::RegionCut{regions[1 + random() % (regions.size() - 1)], number(0.0, 0.06 * size)};
    if (kind >= 2) {
        const Vector3 middle = point(), along = number(0.05, 0.6) * size * direction();
        const Vector3 across = number(0.05, 0.6) * size * along.cross(direction()).normalized();
        cut.tool = meshes::BladeCut{
            {middle - along - across, middle + along - across, middle + along + across, middle - along + across},
            kind == 2 ? 0.0 : number(0.001, 0.05) * size};
    }
    cut.way = random() % 2 == 0 ? CutWay::facets : CutWay::exact;
    constexpr std::array fates{meshes::SmallPieces::refuse, meshes::SmallPieces::remove, meshes::SmallPieces::keep};
    cut.small_pieces = fates[random() % fates.size()];
    return cut;
}

std::string fault_of(const core::Body &before, const meshes::Cut &cut, const meshes::CutBody &after) {
    constexpr double rounding = 1e-11;
    const auto volumes = core::tetrahedron_volumes(before.mesh);
    auto volume_left = volumes;
    double volume = after.removed_volume, mass = after.removed_mass;
    for (std::size_t piece = 0; piece < after.parents.size(); ++piece) {
        const auto &body = piece == 0 ? after.body : after.small_pieces[piece - 1];
        volume += sum(core::tetrahedron_volumes(body.mesh));
        mass += mass_of(body);
        if (auto fault = fault_of_mesh(body); !fault.empty())
            return fault;
        if (auto fault = fault_of_parents(before, cut, body, after.parents[piece], volume_left); !fault.empty())
            return fault;
    }
    if (std::abs(volume - sum(volumes)) > rounding * sum(volumes) ||
        std::abs(after.volume_before - sum(volumes)) > rounding * sum(volumes))
        return fmt::format("{} m^3 are left and taken away of {} m^3", volume, sum(volumes));
    if (std::abs(mass - mass_of(before)) > rounding * mass_of(before))
        return fmt::format("{} kg are left and taken away of {} kg", mass, mass_of(before));
    if (cut.way == CutWay::facets)
        for (std::size_t t = 0; t < volumes.size(); ++t)
            if (std::abs(volume_left[t]) > rounding * volumes[t] && volume_left[t] != volumes[t])
                return fmt::format("tetrahedron {} of the body before is there twice, or in part", t);
    if (const auto *blade = std::get_if<meshes::BladeCut>(&cut.tool); blade && blade->thickness == 0.0 &&
                                                                      cut.small_pieces == meshes::SmallPieces::keep &&
                                                                      after.removed_volume > 0.05 * sum(volumes))
        return "a blade without thickness has taken more than crumbs away";
    return "";
}

RandomCuts try_random_cuts(const core::Body &body, int num_cuts, unsigned seed) {
    std::mt19937 random(seed);
    RandomCuts result;
    for (int c = 0; c < num_cuts; ++c) {
        const auto cut = random_cut(body, random);
        try {
            const auto after = meshes::cut(body, cut);
            ++result.num_cut;
            if (const auto fault = fault_of(body, cut, after); !fault.empty())
                result.faults.push_back(fmt::format("cut {} {} ({}): {}", c, to_text(cut.tool),
                                                    cut.way == CutWay::facets ? "facets" : "exact", fault));
        } catch (const meshes::CutNotOnBody &) {
            ++result.num_refused;
        }
    }
    return result;
}

} // namespace livermark::tests
