#include "live/surface.hpp"

namespace livermark::live {

Surface touchable_surface(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained) {
    Surface surface;
    surface.nodal_area.assign(mesh.points.size(), 0.0);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (is_constrained[f])
            continue;
        const double area = core::area_vector(mesh, f).norm();
        surface.triangles.push_back(mesh.boundary_triangles[f]);
        surface.facet.push_back(f);
        surface.area.push_back(area);
        for (const int node : mesh.boundary_triangles[f])
            surface.nodal_area[node] += area / 3.0;
    }
    for (int node = 0; node < mesh.num_nodes(); ++node)
        if (surface.nodal_area[node] > 0.0)
            surface.nodes.push_back(node);
    return surface;
}

Load no_load(const Surface &surface) {
    Load load;
    load.nodal.assign(surface.nodal_area.size(), core::Vector3::Zero());
    load.facet.assign(surface.triangles.size(), core::Vector3::Zero());
    return load;
}

void clear(Load &load) {
    for (const int node : load.nodes)
        load.nodal[node].setZero();
    for (const int triangle : load.triangles)
        load.facet[triangle].setZero();
    load.nodes.clear();
    load.triangles.clear();
    load.total.setZero();
}

} // namespace livermark::live
