#include "benchmarks/scene.hpp"

#include <cmath>
#include <numeric>

#include "benchmarks/bodies.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/springs/spring_network.hpp"

namespace livermark::benchmarks {

namespace {

constexpr double stretch = 0.01;

double largest_frequency(const Scene &scene) {
    return msm::largest_angular_frequency(scene.springs, scene.problem.body->mesh.points, scene.conditions);
}

} // namespace

Scene make_scene(std::shared_ptr<const core::Body> body) {
    Scene scene;
    scene.problem = {.body = std::move(body), .load_case = {}};
    scene.problem.load_case = constrained(*scene.problem.body);
    scene.springs = msm::spring_network(*scene.problem.body, msm::all_spring_laws().front());
    scene.conditions = msm::nodal_conditions(scene.problem, scene.springs.node_mass);
    for (const auto &displacement : scene.conditions.displacement)
        scene.is_constrained.push_back(!std::isnan(displacement.x()));
    scene.start = scene.problem.body->mesh.points;
    for (auto &x : scene.start)
        x.x() *= 1.0 + stretch;
    scene.largest_angular_frequency = largest_frequency(scene);
    return scene;
}

Scene with_mean_stiffness(Scene scene) {
    auto &stiffness = scene.springs.stiffness;
    const double sum = std::accumulate(stiffness.begin(), stiffness.end(), 0.0);
    stiffness.assign(stiffness.size(), sum / static_cast<double>(stiffness.size()));
    scene.largest_angular_frequency = largest_frequency(scene);
    return scene;
}

double critical_time_step(const Scene &scene, const std::string &integrator) {
    const double highest = scene.largest_angular_frequency;
    return msm::critical_time_step(msm::find_integrator(integrator), {}, highest, highest);
}

} // namespace livermark::benchmarks
