// Somebody else's static problem: a cube of six tetrahedra, fixed below and pulled above by a hundredth of a newton.
#include <cmath>
#include <cstdio>
#include <livermark/fem_reference/linear/linear_elasticity.hpp>
#include <memory>

using namespace livermark;

int main() {
    auto body = std::make_shared<core::Body>();
    body->name = "cube";
    auto &mesh = body->mesh;
    for (int i = 0; i < 8; ++i)
        mesh.points.emplace_back(0.01 * (i & 1), 0.01 * (i >> 1 & 1), 0.01 * (i >> 2 & 1));
    mesh.tetrahedra = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    mesh.region.assign(mesh.tetrahedra.size(), 0);
    mesh.region_names = {"parenchyma"};
    mesh.boundary_triangles = {{0, 3, 1}, {0, 2, 3}, {4, 5, 7}, {4, 7, 6}};
    mesh.boundary_patch = {0, 0, 1, 1};
    mesh.patch_names = {"below", "above"};
    body->materials = {{.density = 1060.0, .young_modulus = 5000.0, .poisson_ratio = 0.45}};

    core::LoadCase load_case;
    load_case.conditions = {{"below"}, {"above", core::ConditionKind::traction}};
    load_case.condition_on = {0, 0, 1, 1};
    load_case.value = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 100.0}, {0.0, 0.0, 100.0}};

    const auto solution = fem_reference::solve_static({body, load_case}, 2);
    const double moved = solution.displacement[7].z();
    std::printf("%s, the top moves by %.3g mm, the reaction is %.3g N\n", core::to_string(solution.status), 1e3 * moved,
                solution.reaction[0].z());
    return moved > 0.0 && moved < 0.01 && std::abs(solution.reaction[0].z() + 0.01) < 1e-9 ? 0 : 1;
}
