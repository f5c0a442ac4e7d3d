#include "segmentation/meshing/mesh_labels.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "segmentation/meshing/delaunay_refinement.hpp"
#include "segmentation/meshing/edge_operations.hpp"
#include "segmentation/meshing/mesh_cleaning.hpp"
#include "segmentation/meshing/mesh_links.hpp"
#include "segmentation/meshing/node_moves.hpp"
#include "segmentation/meshing/quality_criteria.hpp"

namespace livermark::segmentation {

namespace {

/// Below this quality a tetrahedron is worked on: well above the quality criterion, because stiffness and time step
/// gain as well.
constexpr double aim = 0.4;

void improve(core::TetraMesh &mesh, const LabelDomain &domain) {
    constexpr int num_rounds = 4;
    for (int round = 0; round < num_rounds; ++round) {
        const double mean = mean_edge_length(mesh);
        peel_flat(mesh, 0.5 * aim);
        while (collapse_edges(mesh, 0.4 * mean, 0.3 * mean, 1.8 * mean) > 0)
            continue;
        remove_edges(mesh, aim);
        swap_faces(mesh, aim);
        snap_to_levels(mesh, domain);
        climb(mesh, domain, aim);
    }
}

void adjust(core::TetraMesh &mesh, const LabelDomain &domain) {
    constexpr int num_rounds = 3;
    for (int round = 0; round < num_rounds; ++round) {
        correct_volumes(mesh, domain.fields.volume);
        remove_edges(mesh, aim);
        climb(mesh, domain, aim);
    }
    correct_volumes(mesh, domain.fields.volume);
}

/// Tetrahedra region by region, so that those of a lesion are beside each other, and the boundary.
void finish(core::TetraMesh &mesh) {
    core::TetraMesh sorted;
    sorted.points = mesh.points;
    int num_regions = 0;
    for (const int region : mesh.region)
        num_regions = std::max(num_regions, region + 1);
    for (int region = 0; region < num_regions; ++region)
        for (int t = 0; t < mesh.num_tetrahedra(); ++t)
            if (mesh.region[t] == region) {
                sorted.tetrahedra.push_back(mesh.tetrahedra[t]);
                sorted.region.push_back(region);
            }
    drop_unused(sorted); // numbers the nodes in the order of the tetrahedra
    sorted.boundary_triangles = core::outer_faces(sorted.tetrahedra);
    sorted.boundary_patch.assign(sorted.boundary_triangles.size(), 0);
    sorted.patch_names = {"surface"};
    mesh = std::move(sorted);
}

/// Pieces of a region of less than some tetrahedra are noise [m^3].
double smallest_piece(double edge) {
    return 4.0 * edge * edge * edge / (6.0 * std::numbers::sqrt2);
}

double first_edge(const LabelFields &fields, int target_tetrahedra) {
    constexpr double shape = 9.0; // tetrahedra in the volume edge^3, measured
    const double volume = std::accumulate(fields.volume.begin(), fields.volume.end(), 0.0);
    return std::cbrt(shape * volume / target_tetrahedra);
}

core::TetraMesh attempt(const LabelDomain &domain, const std::vector<LabelPiece> &pieces,
                        const RefinementSizes &sizes) {
    core::TetraMesh mesh = refine_delaunay(domain, border_points(domain, pieces, sizes.edge), sizes);
    clean(mesh, pieces);
    if (mesh.tetrahedra.empty())
        return mesh;
    improve(mesh, domain);
    clean(mesh, pieces);
    adjust(mesh, domain);
    finish(mesh);
    return mesh;
}

} // namespace

LabelMesh mesh_labels(const LabelFields &fields, int target_tetrahedra) {
    constexpr int max_attempts = 8;
    const LabelDomain domain = match_volumes(fields);
    double edge = first_edge(fields, target_tetrahedra);
    LabelMesh best;
    const auto misses_one = [](const LabelMesh &mesh) { // advice as well: another mesh may follow it
        return mesh.quality_criteria.empty() || !std::ranges::all_of(mesh.quality_criteria, &QualityCriterion::is_met);
    };
    for (int i = 0; i < max_attempts && misses_one(best); ++i) {
        // What a mesh misses is mostly bad luck in one place, which comes out otherwise with other settings.
        const RefinementSizes sizes{edge, i % 2 == 0 ? 0.15 : 0.2, i % 4 < 2};
        const auto pieces = find_pieces(domain, smallest_piece(edge));
        core::TetraMesh mesh = attempt(domain, pieces, sizes);
        if (mesh.tetrahedra.empty()) {
            edge *= 0.8;
            continue;
        }
        edge *= std::cbrt(static_cast<double>(mesh.num_tetrahedra()) / target_tetrahedra);
        auto quality_criteria = measure_quality_criteria(mesh, fields.volume, pieces, target_tetrahedra);
        if (best.quality_criteria.empty() || total_miss(quality_criteria) < total_miss(best.quality_criteria))
            best = {std::move(mesh), std::move(quality_criteria), 0};
        best.num_attempts = i + 1;
    }
    if (best.quality_criteria.empty())
        throw std::runtime_error("no tetrahedra came of the segmentation");
    return best;
}

} // namespace livermark::segmentation
