#include <gtest/gtest.h>

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

class CoupledSprings : public tests::EveryVectorUnit {};

TEST_P(CoupledSprings, AroundNodesMoveAsTheOracleDoes) {
    for (const int count : all_counts)
        for (const auto &[soft_ratio, hard_ratio] :
             {std::pair(0.25, 0.25), std::pair(0.45, 0.45), std::pair(0.25, 0.4)}) {
            SCOPED_TRACE(testing::Message() << count << " " << soft_ratio << " " << hard_ratio);
            tests::expect_what_the_oracle_does(around_nodes(count, soft_ratio, hard_ratio));
        }
}

TEST_P(CoupledSprings, GiveTheSameForAnyNumberOfThreads) {
    tests::expect_the_same_for_any_number_of_threads(around_nodes(108, 0.4, 0.45));
}

INSTANTIATE_TEST_SUITE_P(FastSteps, CoupledSprings, testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         tests::name_of_unit);

} // namespace
} // namespace livermark
