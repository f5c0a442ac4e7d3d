#pragma once

#include <array>
#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <random>

#include "core/problem.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"

/// Bodies that fast kernels move, and the slow steps that they are compared with.
namespace livermark::tests {

inline constexpr double sample_step = 1e-4; ///< [s]

/// Point masses, where they are, and what is done to them.
struct Sample {
    msm::ElasticBody body{{}, {}};
    std::vector<core::Vector3> positions;
    msm::NodalConditions conditions;
};

double random_value(std::mt19937 &random, double lowest, double highest);
core::Vector3 random_vector(std::mt19937 &random, double largest);

/// Every fifth node is constrained, half of these in one direction only; the others bear loads.
msm::NodalConditions some_conditions(std::size_t num_nodes, std::mt19937 &random);

/// The first tetrahedra of a box of two materials.
core::Body two_materials(int num_tetrahedra, double soft_ratio, double hard_ratio);

/// A bar of 12 x 4 x 4 cm, soft but for its middle third.
core::Body lumpy_bar(const std::array<int, 3> &bricks, double hardness);

/// Nothing is constrained or loaded.
msm::NodalConditions free_conditions(std::size_t num_nodes);

/// A body with nothing that holds it together yet.
Sample loose(const core::Body &body);

/// Tetrahedra with springs, a volume term if one is named, and the guard.
Sample tetrahedra(int num_tetrahedra, const std::string &volume_term);

/// The same with coupled springs, and with volumes where a ratio is not that of springs.
Sample coupled(const char *springs, int num_tetrahedra, double soft_ratio, double hard_ratio);

/// So far from rest that some tetrahedra are inverted; constrained components stand still.
msm::State shaken(const Sample &sample);

/// Steps from there.
msm::State by_the_oracle(const Sample &sample, const core::RayleighDamping &damping, const msm::Integrator &integrator,
                         int num_steps);
msm::State by_the_oracle(const Sample &sample, const core::RayleighDamping &damping, const std::string &integrator,
                         int num_steps);
msm::State by_the_kernel(const Sample &sample, const core::RayleighDamping &damping, const std::string &integrator,
                         int num_steps, const msm::FastStepOptions &options);

/// Largest difference of velocities and displacements, as parts of the largest changes that the steps have made.
double error(const msm::State &found, const msm::State &expected, const Sample &sample);

inline constexpr auto both_precisions = {msm::ForcePrecision::single_precision, msm::ForcePrecision::double_precision};

constexpr double tolerance(msm::ForcePrecision precision) {
    return precision == msm::ForcePrecision::double_precision ? 1e-12 : 1e-5;
}

/// In both precisions, without damping and with it.
void expect_what_the_oracle_does(const Sample &sample);

void expect_the_same_for_any_number_of_threads(const Sample &sample);

/// A vector unit that this machine has and this binary was built for.
class EveryVectorUnit : public testing::TestWithParam<int64_t> {
  protected:
    EveryVectorUnit() { choose(GetParam()); }
    ~EveryVectorUnit() override { choose(0); }

  private:
    /// Zero stands for the best one.
    static void choose(int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
};

inline std::string name_of_unit(const testing::TestParamInfo<int64_t> &info) {
    return hwy::TargetName(info.param);
}

} // namespace livermark::tests
