#include "experiments/ring_down.hpp"

#include <cmath>
#include <fmt/format.h>

#include "support/input_error.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

/// Of the displacement at the end, that the first turning point is beyond.
constexpr double least_swing = 0.75;

/// The mean displacement of all markers in a record.
Vector3 mean_of_record(const MarkerMotion &motion, int record) {
    Vector3 sum = Vector3::Zero();
    for (int k = 0; k < motion.num_markers; ++k)
        sum += motion.at(record, k);
    return sum / motion.num_markers;
}

/// Between records 1 and 2 of four, at a part of the way.
Vector3 catmull_rom(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d, double part) {
    return b + 0.5 * part * (c - a + part * (2.0 * a - 5.0 * b + 4.0 * c - d + part * (3.0 * (b - c) + d - a)));
}

} // namespace

MarkerMotion mean_motion(std::span<const MarkerMotion> repeats) {
    auto mean = repeats.front();
    for (auto &displacement : mean.displacement)
        displacement.setZero();
    for (const auto &repeat : repeats)
        for (std::size_t i = 0; i < mean.displacement.size(); ++i)
            mean.displacement[i] += repeat.displacement[i] / static_cast<double>(repeats.size());
    return mean;
}

MarkerMotion from_turning_point(const MarkerMotion &recording, int num_records, const std::string &place) {
    const int last = recording.num_records() - 1;
    const Vector3 at_end = mean_of_record(recording, last);
    const auto along = [&](int record) { return mean_of_record(recording, record).dot(at_end) / at_end.squaredNorm(); };
    int turn = 1;
    while (turn < last &&
           (along(turn) < least_swing || along(turn) <= along(turn - 1) || along(turn) < along(turn + 1)))
        ++turn;
    const double before = along(turn - 1), there = along(turn), after = turn < last ? along(turn + 1) : there;
    const double curvature = before - 2.0 * there + after;
    const double start = turn + (curvature < 0.0 ? 0.5 * (before - after) / curvature : 0.0);
    const int first = static_cast<int>(std::floor(start));
    if (turn == last || first < 1 || first + num_records + 1 > last)
        throw support::InputError(fmt::format("{}: there are not {} records behind the first turning point of the "
                                              "markers; record for longer, or from before the body is let go",
                                              place, num_records));
    MarkerMotion motion{recording.interval, recording.num_markers, {}};
    for (int record = first; record < first + num_records; ++record)
        for (int k = 0; k < recording.num_markers; ++k)
            motion.displacement.push_back(catmull_rom(recording.at(record - 1, k), recording.at(record, k),
                                                      recording.at(record + 1, k), recording.at(record + 2, k),
                                                      start - first));
    return motion;
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
