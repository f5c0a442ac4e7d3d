#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "msm/cutting/cut_parts.hpp"
#include "msm/springs/springs.hpp"
#include "tests/samples/cut_bodies.hpp"

/// Springs of bodies that are cut.
namespace livermark::tests {

/// Springs that a body may have.
struct SpringsToCut {
    std::string name;
    std::function<msm::ElasticBody(const core::Body &)> make;
    std::function<std::optional<msm::SpringSource>(const core::Body &)> source;
};

/// All that msm::CutParts handles.
inline std::vector<SpringsToCut> all_springs_to_cut() {
    std::vector<SpringsToCut> all;
    const auto add = [&](const msm::SpringLaw &law, const std::string &volume) {
        all.push_back({law.name + " with " + volume,
                       [=](const core::Body &body) {
                           return msm::springs_with_volume(body, msm::springs_beside_volume(body, law),
                                                           msm::find_volume_term(volume))
                               .body;
                       },
                       [=](const core::Body &body) {
                           return msm::SpringSource{law, msm::for_springs_beside_volume(body)};
                       }});
    };
    for (const auto &law : msm::all_spring_laws())
        add(law, "nodal_volume");
    add(msm::all_spring_laws().front(), "tetrahedral_volume");
    const auto &alone = msm::all_spring_laws().front();
    all.push_back({alone.name + " alone",
                   [=](const core::Body &body) { return msm::ElasticBody(msm::spring_network(body, alone)); },
                   [=](const core::Body &body) {
                       return msm::SpringSource{alone, body};
                   }});
    for (const auto &coupled : msm::all_coupled_springs())
        if (msm::are_in_kernels(coupled))
            all.push_back({coupled.name,
                           [=](const core::Body &body) { return msm::coupled_springs_with_volume(body, coupled); },
                           [](const core::Body &) { return std::nullopt; }});
    return all;
}

inline std::string name_of_springs_to_cut(const testing::TestParamInfo<SpringsToCut> &info) {
    std::string name = info.param.name;
    std::ranges::replace(name, ' ', '_');
    return name;
}

/// Expects the numbers of a set-up of the cut body from nothing, to the bit.
/// @param body     all nodes and tetrahedra, by the numbers that they keep
/// @param removed  tetrahedra
inline void expect_numbers_of_set_up(const msm::CutParts &parts, const SpringsToCut &springs, const core::Body &body,
                                     const std::set<int> &removed) {
    const auto [rest, number] = without(body, removed);
    const auto elastic_of_rest = springs.make(rest);
    const auto anew = msm::step_parts(msm::part_terms(elastic_of_rest).in_kernels).value();
    const auto &now = parts.parts();
    ASSERT_EQ(parts.node_mass().size(), number.size());
    for (std::size_t i = 0; i < number.size(); ++i)
        EXPECT_EQ(parts.node_mass()[i], number[i] < 0 ? 0.0 : elastic_of_rest.node_mass[number[i]]) << i;
    std::map<std::array<int, 2>, std::size_t> spring;
    for (std::size_t s = 0; s < anew.edges.size(); ++s)
        spring[anew.edges[s]] = s;
    std::size_t num_springs = 0;
    for (std::size_t s = 0; s < now.edges.size(); ++s) {
        const auto [i, j] = now.edges[s];
        const auto found = spring.find({number[i], number[j]});
        EXPECT_EQ(now.stiffness[s], found == spring.end() ? 0.0 : anew.stiffness[found->second]) << s;
        if (found == spring.end())
            continue;
        EXPECT_EQ(now.rest_length[s], anew.rest_length[found->second]) << s;
        ++num_springs;
    }
    EXPECT_EQ(num_springs, anew.edges.size());
    std::size_t t_anew = 0;
    for (int t = 0; t < body.mesh.num_tetrahedra(); ++t) {
        EXPECT_EQ(now.is_there(t), !removed.contains(t)) << t;
        if (removed.contains(t))
            continue;
        for (std::size_t k = 0; k < 4; ++k) {
            if (!anew.tetrahedra.empty()) {
                EXPECT_EQ(now.tetrahedra[t][k], body.mesh.tetrahedra[t][k]) << t;
            }
            if (anew.corner_volume.empty())
                continue;
            const int c = now.corner_volume[t][k], d = anew.corner_volume[t_anew][k];
            EXPECT_EQ(number[now.centre[c]], anew.centre[d]) << t;
            if (!anew.volume_stiffness.empty()) {
                EXPECT_EQ(now.volume_stiffness[c], anew.volume_stiffness[d]) << c;
            }
            if (!anew.coupled_modulus.empty()) {
                EXPECT_EQ(now.coupled_modulus[c], anew.coupled_modulus[d]) << c;
            }
        }
        for (std::size_t e = 0; e < 6 && !anew.edge_part.empty(); ++e)
            EXPECT_EQ(now.edge_modulus[now.edge_part[t][e]], anew.edge_modulus[anew.edge_part[t_anew][e]]) << t;
        ++t_anew;
    }
    EXPECT_EQ(t_anew, rest.mesh.tetrahedra.size());
}

/// A box of springs that are cut one time after the other.
class CutBox : public testing::TestWithParam<SpringsToCut> {
  protected:
    core::Body body = crooked_box({0.07, 0.06, 0.05}, {6, 5, 4});
    msm::ElasticBody elastic = GetParam().make(body);
    msm::CutParts parts = msm::CutParts::prepare(body, elastic, GetParam().source(body)).value();
    std::set<int> removed;

    /// Tetrahedra of a body near a place on its upper side that are still there; they count as removed from now on.
    std::vector<int> take_near(const core::Body &of, double x, double distance) {
        auto near = tetrahedra_near(of, {x, 0.03, 0.05}, distance);
        std::erase_if(near, [&](int t) { return removed.contains(t); });
        removed.insert(near.begin(), near.end());
        return near;
    }
};

} // namespace livermark::tests
