#include "segmentation/meshing/delaunay_refinement.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>
#include <CGAL/refine_mesh_3.h>
#include <algorithm>
#include <map>

namespace livermark::segmentation {

namespace {

using core::Vector3;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

// CGAL keeps 0 for the outside; our labels start with it.
static_assert(outside == -1);

Domain cgal_domain(const LabelDomain &domain, double unit) {
    const Vector3 low = domain.fields.low / unit;
    const Vector3 extent(domain.fields.size[0] - 1, domain.fields.size[1] - 1, domain.fields.size[2] - 1);
    const Vector3 high = low + extent * domain.fields.spacing / unit;
    const double diagonal = (high - low).norm();
    const auto label = [&domain, unit](const Kernel::Point_3 &point) {
        return 1 + label_at(domain, unit * Vector3(point.x(), point.y(), point.z()));
    };
    return Domain(label, CGAL::Bbox_3(low.x(), low.y(), low.z(), high.x(), high.y(), high.z()),
                  CGAL::parameters::relative_error_bound = 0.01 / diagonal); // of twice the unit
}

void insert_seeds(Complex &complex, const Domain &domain, const std::vector<BorderPoint> &seeds, double unit) {
    auto &triangulation = complex.triangulation();
    for (const auto &seed : seeds) {
        const Vector3 place = seed.place / unit;
        const auto vertex = triangulation.insert(Triangulation::Weighted_point({place.x(), place.y(), place.z()}, 0.0));
        const std::pair labels{1 + std::min(seed.from, seed.to), 1 + std::max(seed.from, seed.to)};
        complex.set_dimension(vertex, 2);
        complex.set_index(vertex, domain.index_from_surface_patch_index(labels));
    }
}

core::TetraMesh from_complex(const Complex &complex, double unit) {
    core::TetraMesh mesh;
    std::map<Complex::Vertex_handle, int> number;
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
        std::array<int, 4> nodes{};
        for (int corner = 0; corner < 4; ++corner) {
            const auto [entry, is_new] = number.emplace(cell->vertex(corner), mesh.num_nodes());
            if (is_new) {
                const auto &point = cell->vertex(corner)->point();
                mesh.points.push_back(unit * Vector3(point.x(), point.y(), point.z()));
            }
            nodes[corner] = entry->second;
        }
        mesh.tetrahedra.push_back(nodes);
        mesh.region.push_back(complex.subdomain_index(cell) - 1);
    }
    return mesh;
}

} // namespace

core::TetraMesh refine_delaunay(const LabelDomain &domain, const std::vector<BorderPoint> &seeds,
                                const RefinementSizes &sizes) {
    namespace p = CGAL::parameters;
    const double unit = sizes.edge; // lengths about 1, for tolerances that CGAL does not scale
    const Domain labels = cgal_domain(domain, unit);
    const Criteria criteria(p::facet_angle = 25.0, p::facet_size = 0.75, p::facet_distance = sizes.facet_distance,
                            p::cell_radius_edge_ratio = 2.0, p::cell_size = 0.8);
    Complex complex;
    insert_seeds(complex, labels, seeds, unit);
    CGAL::refine_mesh_3(complex, labels, criteria, p::no_reset_c3t3(), p::no_perturb(), p::no_exude());
    if (sizes.against_slivers) {
        // Without a limit on the time, which would make the mesh depend on how busy the machine is.
        constexpr double sliver = 12.0; // dihedral angle [degrees]
        CGAL::perturb_mesh_3(complex, labels, p::time_limit = 0.0, p::sliver_bound = sliver);
        CGAL::exude_mesh_3(complex, p::time_limit = 0.0, p::sliver_bound = sliver);
    }
    return from_complex(complex, unit);
}

} // namespace livermark::segmentation
