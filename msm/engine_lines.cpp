#include "msm/engine_lines.hpp"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <functional>
#include <utility>

#include "core/capsule.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/part_springs.hpp"

namespace livermark::msm {

namespace {

void add_capsule(std::vector<EngineArray> &arrays, const core::Body &body) {
    core::CapsuleEdges springs(body);
    std::vector<int> edges;
    std::vector<double> length;
    for (const auto &[a, b] : springs.nodes) {
        edges.insert(edges.end(), {a, b});
        length.push_back((body.mesh.points[b] - body.mesh.points[a]).norm());
    }
    arrays.push_back({"capsule_edges", "",
                      "ends of the springs of the capsule, beside tetrahedra; those of 'edges' "
                      "have them already",
                      std::move(edges), 2});
    arrays.push_back({"capsule_stiffness", "N/m", "of each of them", std::move(springs.stiffness)});
    arrays.push_back({"capsule_length", "m", "of each of them at rest", std::move(length)});
}

void add_vessels(std::vector<EngineArray> &arrays, const core::Body &body) {
    std::vector<double> points, stiffness, length;
    std::vector<int> ends;
    for (const auto &spring : core::vessel_springs(body)) {
        for (const auto &end : spring.ends) {
            ends.push_back(static_cast<int>(points.size() / 3));
            const auto point = core::point_in(body, spring.tetrahedron, end);
            points.insert(points.end(), point.begin(), point.end());
        }
        stiffness.push_back(spring.stiffness);
        length.push_back(spring.rest_length);
    }
    arrays.push_back(
        {"vessel_points", "m", "points at rest that move with the tetrahedra around them", std::move(points), 3});
    arrays.push_back({"vessel_springs", "", "points of each spring of the vessels", std::move(ends), 2});
    arrays.push_back({"vessel_stiffness", "N/m", "of each of them", std::move(stiffness)});
    arrays.push_back({"vessel_length", "m", "of each of them at rest", std::move(length)});
}

} // namespace

std::vector<EngineArray> springs_beside(const core::Body &body) {
    std::vector<EngineArray> arrays;
    if (body.capsule)
        add_capsule(arrays, body);
    if (body.vessels)
        add_vessels(arrays, body);
    return arrays;
}

std::vector<std::string> left_out_beside(const core::Body &body, const Engine &engine) {
    std::vector<std::string> sentences;
    if (body.capsule && !engine.has_capsule)
        sentences.emplace_back("the capsule is left out, because there are no springs on edges beside tetrahedra");
    if (body.vessels && !engine.has_vessels)
        sentences.emplace_back("vessels as lines are left out, because no points move with tetrahedra");
    return sentences;
}

std::string note_on_springs(const core::SpringNetwork &springs, const core::Body &body, const std::string &law) {
    auto tissue_stiffness = springs.stiffness;
    std::ranges::transform(tissue_stiffness, core::capsule_springs(body, core::edge_table(body.mesh.tetrahedra)),
                           tissue_stiffness.begin(), std::minus());
    return fmt::format("The springs are of the law {}; averaged over all directions their shear modulus is {:.3f} of "
                       "the tissue's on this mesh{}",
                       law, mean_shear_modulus_ratio(tissue_stiffness, springs.rest_length, body),
                       body.capsule ? ", and the capsule adds to those on its surface" : "");
}

} // namespace livermark::msm
