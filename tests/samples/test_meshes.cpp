#include "tests/samples/test_meshes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace livermark::tests {

namespace {

int patch_index(const core::TetraMesh &mesh, const std::string &name) {
    const auto found = std::ranges::find(mesh.patch_names, name);
    if (found == mesh.patch_names.end())
        throw std::invalid_argument("no patch " + name);
    return static_cast<int>(found - mesh.patch_names.begin());
}

} // namespace

core::TetraMesh box_mesh(const core::Vector3 &size, const std::array<int, 3> &bricks) {
    const auto [nx, ny, nz] = bricks;
    core::TetraMesh mesh;
    for (int k = 0; k <= nz; ++k)
        for (int j = 0; j <= ny; ++j)
            for (int i = 0; i <= nx; ++i)
                mesh.points.emplace_back(size.x() * i / nx, size.y() * j / ny, size.z() * k / nz);
    const auto node = [nx = nx, ny = ny](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
    // Kuhn's cut: a tetrahedron for each order in which one can walk the axes from corner to opposite corner.
    constexpr std::array<std::array<int, 3>, 6> walks{
        {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
    for (int k = 0; k < nz; ++k)
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i)
                for (std::size_t w = 0; w < walks.size(); ++w) {
                    std::array<int, 3> at{i, j, k};
                    std::array<int, 4> nodes{node(i, j, k)};
                    for (int step = 0; step < 3; ++step) {
                        ++at[walks[w][step]];
                        nodes[step + 1] = node(at[0], at[1], at[2]);
                    }
                    if (w >= 3)
                        std::swap(nodes[2], nodes[3]);
                    mesh.tetrahedra.push_back(nodes);
                }
    mesh.region.assign(mesh.tetrahedra.size(), 0);
    mesh.region_names = {"solid"};
    put_patches_on_sides(mesh);
    return mesh;
}

void put_patches_on_sides(core::TetraMesh &box) {
    box.patch_names = {"x_min", "x_max", "y_min", "y_max", "z_min", "z_max"};
    box.boundary_triangles = core::outer_faces(box.tetrahedra);
    box.boundary_patch.clear();
    for (int f = 0; f < box.num_boundary_triangles(); ++f) {
        const core::Vector3 normal = core::area_vector(box, f).normalized();
        int axis = 0;
        normal.cwiseAbs().maxCoeff(&axis);
        box.boundary_patch.push_back(2 * axis + (normal[axis] > 0.0 ? 1 : 0));
    }
}

core::TetraMesh regular_tetrahedron(double edge) {
    const double s = edge / std::sqrt(8.0);
    core::TetraMesh mesh;
    mesh.points = {{s, s, s}, {s, -s, -s}, {-s, s, -s}, {-s, -s, s}};
    mesh.tetrahedra = {{0, 1, 2, 3}};
    if (core::signed_volume(mesh.points[0], mesh.points[1], mesh.points[2], mesh.points[3]) < 0.0)
        std::swap(mesh.tetrahedra[0][2], mesh.tetrahedra[0][3]);
    mesh.region = {0};
    mesh.region_names = {"solid"};
    mesh.boundary_triangles = core::outer_faces(mesh.tetrahedra);
    mesh.boundary_patch.assign(4, 0);
    mesh.patch_names = {"surface"};
    return mesh;
}

std::shared_ptr<const core::Body> make_body(core::TetraMesh mesh, const core::Material &material) {
    auto body = std::make_shared<core::Body>();
    body->name = "test_body";
    body->materials.assign(mesh.region_names.size(), material);
    body->mesh = std::move(mesh);
    return body;
}

namespace {

std::vector<int> facets_of(const core::TetraMesh &mesh, const std::string &patch) {
    std::vector<int> facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.boundary_patch[f] == patch_index(mesh, patch))
            facets.push_back(f);
    return facets;
}

} // namespace

core::LoadCase empty_load_case(const core::TetraMesh &mesh) {
    auto load_case = core::with_free_surface({}, mesh);
    load_case.name = "test_load_case";
    return load_case;
}

void prescribe(core::LoadCase &load_case, const core::TetraMesh &mesh, const std::string &patch,
               const core::Vector3 &displacement) {
    load_case.put({patch}, facets_of(mesh, patch), displacement);
}

void pull(core::LoadCase &load_case, const core::TetraMesh &mesh, const std::string &patch,
          const core::Vector3 &traction) {
    load_case.put({patch, core::ConditionKind::traction}, facets_of(mesh, patch), traction);
}

void press(core::LoadCase &load_case, const core::TetraMesh &mesh, const std::string &patch,
           const core::Vector3 &direction, double depth) {
    double area = 0.0;
    for (const int f : facets_of(mesh, patch))
        area += area_vector(mesh, f).norm();
    load_case.put({patch, core::ConditionKind::press}, facets_of(mesh, patch), direction.normalized() / area);
    load_case.press_depth = depth;
}

} // namespace livermark::tests
