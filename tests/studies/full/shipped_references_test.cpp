#include <algorithm>
#include <gtest/gtest.h>
#include <optional>
#include <string>

#include "core/tool/tool_stiffness.hpp"
#include "studies/models/model_table.hpp"
#include "studies/run/run.hpp"

namespace livermark {
namespace {

/// References of all large load cases that ship, on both livers, at both ratios.
TEST(ReferencesThatShip, AreOfTheWholeLoadAndHaveABarOfEachNumber) {
    const auto models = models::all_models();
    const auto &refined =
        *std::ranges::find(models, models::static_reference(core::Regime::large).refined, &core::Model::name);
    const auto shipped = studies::SolutionCache::shipped();
    int num_references = 0;
    for (const auto poisson_ratio : {std::optional<double>(), std::optional(0.49)})
        for (const auto &problem :
             studies::read_problems({"liver_healthy", "liver_tumours"}, {}, {{}, poisson_ratio}).problems) {
            const auto &load_case = problem.load_case;
            if (load_case.regime != core::Regime::large || (load_case.in_time() && poisson_ratio))
                continue;
            SCOPED_TRACE(problem.body->name + " " + load_case.name + (poisson_ratio ? " 0.49" : ""));
            const auto reference = shipped.find(refined, problem);
            ASSERT_TRUE(reference) << "make it with `livermark reference`";
            ++num_references;
            ASSERT_TRUE(reference->observed_error) << reference->solver;
            const auto &bar = *reference->observed_error;
            EXPECT_EQ(bar.load_fraction, 1.0);
            EXPECT_EQ(bar.stiffness.has_value(), !core::tool_places(problem.body->mesh, load_case).empty());
            constexpr double goal = 0.01; // of the displacement, as the reference has it
            EXPECT_LT(bar.relative_l2, goal);
            for (const double number : {bar.energy, bar.reaction, bar.stiffness.value_or(0.0)})
                EXPECT_LT(number, goal);
        }
    EXPECT_GE(num_references, 30);
}

} // namespace
} // namespace livermark
