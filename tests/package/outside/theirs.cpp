// A simulator of somebody else: a bar of six tetrahedra, its springs, the longest step that they bear, and 1,000 steps.
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <livermark/msm/dynamics/time_step.hpp>
#include <livermark/msm/kernels/fast_steps.hpp>
#include <livermark/msm/spring_law.hpp>
#include <livermark/msm/springs/springs.hpp>
#include <memory>

using namespace livermark;

int main() {
    auto body = std::make_shared<core::Body>();
    body->name = "bar";
    auto &mesh = body->mesh;
    for (int i = 0; i < 8; ++i)
        mesh.points.emplace_back(0.01 * (i & 1), 0.01 * (i >> 1 & 1), 0.01 * (i >> 2 & 1));
    mesh.tetrahedra = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
    mesh.region.assign(mesh.tetrahedra.size(), 0);
    mesh.region_names = {"parenchyma"};
    body->materials = {{.density = 1060.0, .young_modulus = 5000.0, .poisson_ratio = 0.45}};

    const auto springs = msm::spring_network(*body, *msm::all_spring_laws().begin());
    msm::NodalConditions conditions;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (int i = 0; i < 8; ++i) {
        const bool is_fixed = i < 4; // below
        conditions.displacement.emplace_back(core::Vector3::Constant(is_fixed ? 0.0 : nan));
        conditions.constraint.push_back(is_fixed ? std::array{0, 0, 0} : std::array{-1, -1, -1});
        conditions.force.emplace_back(is_fixed ? 0.0 : 1e-3, 0.0, 0.0);
    }
    const double highest = msm::largest_angular_frequency(springs, mesh.points, conditions);
    const double step = 0.8 * msm::critical_time_step(msm::find_integrator("symplectic_euler"), {}, highest, highest);
    auto steps = msm::FastSteps::prepare(springs, mesh.points, conditions, {}, "symplectic_euler", step);
    if (!steps)
        return 1;
    steps->take(1000);
    const double moved = steps->displacement(7).norm();
    std::printf("%zu springs, the first of %.4g N/m; 1000 steps of %.3g ms; %.3g mm\n", springs.stiffness.size(),
                springs.stiffness.front(), 1e3 * step, 1e3 * moved);
    return std::isfinite(moved) && moved > 0.0 && moved < 0.01 ? 0 : 1;
}
