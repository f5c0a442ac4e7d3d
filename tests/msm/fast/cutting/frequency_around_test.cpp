#include "msm/cutting/cut_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "msm/dynamics/time_step.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "tests/samples/cut_bodies.hpp"

namespace livermark {
namespace {

using core::Vector3;

msm::NodalConditions held_below(const core::Body &body, double x) {
    msm::NodalConditions conditions;
    for (const auto &point : body.mesh.points) {
        conditions.displacement.emplace_back(
            Vector3::Constant(point.x() < x ? 0.0 : std::numeric_limits<double>::quiet_NaN()));
        conditions.force.emplace_back(Vector3::Zero());
        conditions.constraint.push_back({-1, -1, -1});
    }
    return conditions;
}

TEST(FrequencyAround, TellsThatOfTheCutBodyWithTheFrequencyBefore) {
    const auto body = tests::crooked_box({0.2, 0.04, 0.04}, {20, 4, 4});
    const auto &law = *std::ranges::find(msm::all_spring_laws(), "van_gelder", &msm::SpringLaw::name);
    const std::vector<std::function<msm::ElasticBody(const core::Body &)>> all_springs{
        [](const core::Body &of) {
            return msm::coupled_springs_with_volume(of, msm::find_coupled_springs("nodal_neo_hookean"));
        },
        [&](const core::Body &of) {
            return msm::springs_with_volume(of, msm::springs_beside_volume(of, law),
                                            msm::find_volume_term("nodal_volume"))
                .body;
        }};
    constexpr double tolerance = 1e-6;
    for (const auto &make : all_springs)
        for (const double x : {0.06, 0.11, 0.16}) {
            const auto near = tests::tetrahedra_near(body, {x, 0.02, 0.04}, 0.014);
            std::vector<char> is_removed(body.mesh.tetrahedra.size(), 0);
            std::set<int> nodes;
            for (const int t : near) {
                is_removed[t] = 1;
                nodes.insert(body.mesh.tetrahedra[t].begin(), body.mesh.tetrahedra[t].end());
            }
            const double around = msm::frequency_around(body, is_removed, std::vector<int>(nodes.begin(), nodes.end()),
                                                        make, held_below(body, 0.005), tolerance);
            const double before =
                msm::largest_angular_frequency(make(body), body.mesh.points, held_below(body, 0.005), {}, tolerance);
            const auto rest = tests::without(body, {near.begin(), near.end()}).body;
            const double after =
                msm::largest_angular_frequency(make(rest), rest.mesh.points, held_below(rest, 0.005), {}, tolerance);
            EXPECT_LT(around, after * (1.0 + 1e-4)) << x;
            EXPECT_GT(std::max(around, before), 0.99 * after) << x;
        }
}

TEST(FrequencyAround, IsNothingWhereNothingIsLeftToMove) {
    const auto body = tests::crooked_box({0.02, 0.02, 0.02}, {1, 1, 1});
    const std::vector<char> all(body.mesh.tetrahedra.size(), 1);
    const auto make = [](const core::Body &of) {
        return msm::coupled_springs_with_volume(of, msm::find_coupled_springs("nodal_springs"));
    };
    EXPECT_EQ(msm::frequency_around(body, all, std::vector<int>{0, 1}, make, held_below(body, 0.0), 1e-6), 0.0);
}

} // namespace
} // namespace livermark
