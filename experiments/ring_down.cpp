#include "experiments/ring_down.hpp"

#include <fmt/format.h>

#include "support/input_error.hpp"

namespace livermark::experiments {

using core::Vector3;

MarkerMotion mean_motion(std::span<const MarkerMotion> repeats) {
    auto mean = repeats.front();
    for (auto &displacement : mean.displacement)
        displacement.setZero();
    for (const auto &repeat : repeats)
        for (std::size_t i = 0; i < mean.displacement.size(); ++i)
            mean.displacement[i] += repeat.displacement[i] / static_cast<double>(repeats.size());
    return mean;
}

core::Body with_added_mass(core::Body body, double mass, const Vector3 &low, const Vector3 &high) {
    auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    const auto added = static_cast<int>(mesh.region_names.size());
    double volume = 0.0;
    int region = -1;
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        Vector3 middle = Vector3::Zero();
        for (const int node : mesh.tetrahedra[t])
            middle += 0.25 * mesh.points[node];
        if ((middle.array() < low.array()).any() || (middle.array() > high.array()).any())
            continue;
        if (region >= 0 && region != mesh.region[t])
            throw support::InputError(
                fmt::format("a mass of {} kg is put into regions {} and {} of {}; put it into one", mass,
                            mesh.region_names[region], mesh.region_names[mesh.region[t]], body.name));
        region = mesh.region[t];
        mesh.region[t] = added;
        volume += volumes[t];
    }
    if (region < 0)
        throw support::InputError(
            fmt::format("a mass of {} kg is put where {} has no tetrahedra; take a larger box, or "
                        "shorter edges",
                        mass, body.name));
    mesh.region_names.push_back(mesh.region_names[region] + " with a mass");
    body.materials.push_back(body.materials[region]);
    body.materials.back().density += mass / volume;
    return body;
}

} // namespace livermark::experiments
