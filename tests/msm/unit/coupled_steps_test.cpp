#include <gtest/gtest.h>

#include "msm/biquadratic_springs.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/nodal_springs.hpp"
#include "tests/moving_samples.hpp"

namespace livermark {
namespace {

using tests::Sample;

constexpr auto all_counts = {1, 2, 15, 16, 17, 33, 108};

/// Tetrahedra with springs that are coupled around nodes and the guard, and with means of the volume around nodes where
/// they have another Poisson's ratio than springs.
Sample around_nodes(int num_tetrahedra, double soft_ratio, double hard_ratio) {
    const auto body = tests::two_materials(num_tetrahedra, soft_ratio, hard_ratio);
    auto sample = tests::loose(body);
    sample.body.terms = msm::nodal_springs_with_volume(body).terms;
    return sample;
}

/// Tetrahedra with springs that are coupled inside each.
Sample inside_tetrahedra(int num_tetrahedra) {
    const auto body = tests::two_materials(num_tetrahedra, 0.25, 0.45);
    auto sample = tests::loose(body);
    sample.body.terms = {msm::biquadratic_springs(body)};
    return sample;
}

/// The same beside springs, a volume term if one is named, and the guard.
Sample beside_others(int num_tetrahedra, const std::string &volume_term) {
    auto sample = tests::tetrahedra(num_tetrahedra, volume_term);
    sample.body.terms.push_back(inside_tetrahedra(num_tetrahedra).body.terms.front());
    return sample;
}

class CoupledSprings : public tests::EveryVectorUnit {};

TEST_P(CoupledSprings, AroundNodesMoveAsTheOracleDoes) {
    for (const int count : all_counts)
        for (const auto &[soft_ratio, hard_ratio] :
             {std::pair(0.25, 0.25), std::pair(0.45, 0.45), std::pair(0.25, 0.4)}) {
            SCOPED_TRACE(testing::Message() << count << " " << soft_ratio << " " << hard_ratio);
            tests::expect_what_the_oracle_does(around_nodes(count, soft_ratio, hard_ratio));
        }
}

TEST_P(CoupledSprings, InsideTetrahedraMoveAsTheOracleDoes) {
    for (const int count : all_counts) {
        SCOPED_TRACE(count);
        tests::expect_what_the_oracle_does(inside_tetrahedra(count));
    }
}

TEST_P(CoupledSprings, InsideTetrahedraMoveAsTheOracleDoesBesideOtherTerms) {
    for (const int count : all_counts)
        for (const auto *term : {"", "mean_nodal_volume", "nodal_volume", "tetrahedral_volume"}) {
            SCOPED_TRACE(testing::Message() << count << " " << term);
            tests::expect_what_the_oracle_does(beside_others(count, term));
        }
}

TEST_P(CoupledSprings, GiveTheSameForAnyNumberOfThreads) {
    for (const auto &sample :
         {around_nodes(108, 0.4, 0.45), inside_tetrahedra(108), beside_others(108, "nodal_volume")})
        tests::expect_the_same_for_any_number_of_threads(sample);
}

INSTANTIATE_TEST_SUITE_P(FastSteps, CoupledSprings, testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         tests::name_of_unit);

TEST(FastSteps, AreNotThereForSpringsOfBothKinds) {
    const auto body = tests::two_materials(108, 0.25, 0.25);
    auto sample = tests::loose(body);
    const auto inside = msm::biquadratic_springs(body), around = msm::nodal_springs(body, 0.2);
    for (const auto &terms : {std::vector{inside, around}, std::vector{around, inside}}) {
        sample.body.terms = terms;
        EXPECT_FALSE(msm::FastSteps::prepare(sample.body, sample.positions, sample.conditions, {}, "symplectic_euler",
                                             tests::sample_step)
                         .has_value());
    }
}

} // namespace
} // namespace livermark
