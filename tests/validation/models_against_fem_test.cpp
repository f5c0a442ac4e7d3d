#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <ostream>
#include <string>
#include <toml++/toml.h>

#include "core/error_norms.hpp"
#include "core/support/toml_input.hpp"
#include "results/hdf5/result_file.hpp"
#include "studies/models/model_table.hpp"

namespace livermark {
namespace {

using core::Vector3;

/// Models of a run on one rank.
const auto reference = models::static_reference(core::Regime::small);

/// A result file of the runs that come before these tests.
struct BenchmarkCase {
    std::string body;
    std::string load_case;
};

void PrintTo(const BenchmarkCase &benchmark_case, std::ostream *out) {
    *out << benchmark_case.body << "_" << benchmark_case.load_case;
}

std::filesystem::path runs_folder() {
    const char *folder = std::getenv("LIVERMARK_VALIDATION_RUNS"); // NOLINT(concurrency-mt-unsafe)
    return folder ? folder : "";
}

/// All of them, <runs>/<body>/<load case>.h5.
std::vector<BenchmarkCase> all_benchmark_cases() {
    std::vector<BenchmarkCase> cases;
    const auto runs = runs_folder();
    if (std::filesystem::is_directory(runs))
        for (const auto &body : support::list_toml(LIVERMARK_SOURCE_DIR "/meshes"))
            for (const auto &load_case : support::list_toml(LIVERMARK_SOURCE_DIR "/load_cases"))
                if (std::filesystem::exists(runs / body / (load_case + ".h5")))
                    cases.push_back({body, load_case});
    return cases;
}

TEST(RunsOfModelsAgainstFem, AreThere) {
    EXPECT_FALSE(all_benchmark_cases().empty()) << "no result file in LIVERMARK_VALIDATION_RUNS";
}

class ModelsAgainstFem : public testing::TestWithParam<BenchmarkCase> {
  protected:
    void SetUp() override {
        result = results::read_result(runs_folder() / GetParam().body / (GetParam().load_case + ".h5"));
    }

    results::Result result;

    /// The reference of this result: the refined one where the run solved it and needed it.
    std::string reference_name() const {
        return result.reference_uncertainty ? result.reference_uncertainty->reference : reference.on_mesh;
    }

    const results::ModelResult *find(std::string_view name) const {
        const auto found = std::ranges::find(result.models, name, &results::ModelResult::name);
        return found == result.models.end() ? nullptr : &*found;
    }
};

/// Two spring models are enough of what moves.
TEST_P(ModelsAgainstFem, HasEveryModelOfTheTableUnderItsName) {
    const bool has_all = !result.problem.load_case.release;
    for (const auto &model : models::all_models())
        if (has_all && !model.only_when_named && model.takes_part_in(result.problem)) {
            EXPECT_NE(find(model.name), nullptr) << model.name;
        }
    EXPECT_NE(find(reference.on_mesh), nullptr);
    EXPECT_NE(find(models::baseline_name()), nullptr);
    EXPECT_NE(find("lloyd"), nullptr);
}

TEST_P(ModelsAgainstFem, EverySolutionIsFoundAndComparedWithTheReference) {
    const auto *measure = find(reference_name());
    ASSERT_NE(measure, nullptr);
    for (const auto &model : result.models) {
        EXPECT_EQ(model.solution.status, core::SolutionStatus::ok) << model.name << ": " << model.solution.message;
        if (&model == measure)
            continue;
        ASSERT_TRUE(model.comparison) << model.name;
        EXPECT_EQ(model.comparison->reference, reference_name()) << model.name;
        const auto again = core::compare(result.problem.body->mesh, result.problem.load_case, model.solution,
                                         measure->solution, "again");
        EXPECT_NEAR(model.comparison->relative_l2, again.relative_l2, 1e-14) << model.name;
    }
}

/// The finite elements say how good they are, in every norm of the comparison, and how they were solved.
TEST_P(ModelsAgainstFem, TheReferenceHasAnErrorBarOfItsOwn) {
    ASSERT_TRUE(result.reference_uncertainty);
    const auto &uncertainty = *result.reference_uncertainty;
    EXPECT_EQ(uncertainty.reference, reference.refined);
    const auto observed = find(reference.refined)->solution.observed_error;
    ASSERT_TRUE(observed);
    EXPECT_EQ(uncertainty.relative_l2, observed->relative_l2);
    EXPECT_EQ(uncertainty.refinement_difference, observed->difference);
    EXPECT_EQ(uncertainty.energy_error, observed->energy);
    EXPECT_GT(uncertainty.relative_l2, 0.0);
    EXPECT_LT(uncertainty.relative_l2, 0.005);
    EXPECT_TRUE(std::isfinite(uncertainty.energy_error));
    for (const auto &name : {models::baseline_name(), models::moving_reference(core::Regime::small).on_mesh})
        EXPECT_EQ(find(name)->solution.solver, "CHOLMOD") << name;
    const auto &on_mesh = find(reference.on_mesh)->solution.solver, &refined = find(reference.refined)->solution.solver;
    EXPECT_TRUE(on_mesh.starts_with("GMRES")) << on_mesh;
    EXPECT_TRUE(refined.starts_with("stored since 20") && refined.find("GMRES") != std::string::npos) << refined;
}

/// A finer motion judges where it is kept, and on one liver at least it is.
TEST_P(ModelsAgainstFem, TheReferenceOfMotionHasAnErrorBarOfItsOwn) {
    if (!result.problem.load_case.release)
        return;
    const auto [on_mesh, refined] = models::moving_reference(core::Regime::small);
    if (!find(refined)) {
        EXPECT_NE(GetParam().body, "liver_healthy");
        return;
    }
    ASSERT_TRUE(result.motion_uncertainty);
    EXPECT_EQ(result.motion_uncertainty->reference, refined);
    const auto again = results::estimate_motion_uncertainty(*find(on_mesh)->solution.history, std::string(on_mesh),
                                                            *find(refined)->solution.history, std::string(refined));
    EXPECT_EQ(*result.motion_uncertainty, again);
    EXPECT_LT(again.relative_l2, again.difference);
    for (const auto &model : result.models)
        if (model.solution.history && model.name != refined) {
            ASSERT_TRUE(model.comparison->history) << model.name;
            EXPECT_EQ(model.comparison->history->reference, refined) << model.name;
            EXPECT_EQ(model.comparison->history->error.empty(), model.name == on_mesh) << model.name;
        }
}

/// Errors of a model on the body and under the load case of a result.
struct Band {
    double expected, margin; // of relative_l2
    std::string origin;
};

/// error_bands.toml, which says what is in it.
std::map<std::string, Band> bands_of(const BenchmarkCase &benchmark_case) {
    const auto file = toml::parse_file(LIVERMARK_SOURCE_DIR "/tests/validation/error_bands.toml");
    std::map<std::string, Band> bands;
    for (const auto &node : *file["group"].as_array()) {
        const auto &group = *node.as_table();
        const auto *models = group.at_path("relative_l2." + benchmark_case.body).as_table();
        if (!models)
            continue;
        for (const auto &[model, row] : *models)
            if (const auto expected = row.at_path(benchmark_case.load_case).value<double>()) {
                const bool is_new =
                    bands
                        .try_emplace(std::string(model.str()), *expected, group["margin"].value<double>().value(),
                                     group["origin"].value<std::string>().value())
                        .second;
                EXPECT_TRUE(is_new) << model.str() << " has two bands";
            }
    }
    return bands;
}

TEST_P(ModelsAgainstFem, EveryErrorIsInItsBand) {
    const auto bands = bands_of(GetParam());
    for (const auto &model : result.models) {
        if (model.name == reference_name())
            continue;
        ASSERT_TRUE(model.comparison) << model.name;
        const double error = model.comparison->relative_l2;
        const auto remedy =
            fmt::format("if that is understood, write {} = {:.4g} into the line of {} below "
                        "[group.relative_l2.{}] in tests/validation/error_bands.toml",
                        GetParam().load_case, std::round(1e4 * error) / 1e4, model.name, GetParam().body);
        const auto found = bands.find(model.name);
        ASSERT_NE(found, bands.end()) << model.name << " is at " << error << " and has no band; " << remedy;
        const auto &[expected, margin, origin] = found->second;
        EXPECT_NEAR(error, expected, margin) << model.name << ", band of " << origin << "; " << remedy;
    }
}

/// Sum of all loads of the problem that are known [N]; what presses is a reaction.
Vector3 total_load(const core::Problem &problem) {
    const auto &mesh = problem.body->mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    Vector3 load = Vector3::Zero();
    for (std::size_t t = 0; t < volumes.size(); ++t)
        load += volumes[t] * problem.body->materials[mesh.region[t]].density * problem.load_case.acceleration;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (problem.load_case.is_loaded(f) && !problem.load_case.presses(f))
            load += core::area_vector(mesh, f).norm() * problem.load_case.value[f];
    return load;
}

/// Sum of the sizes of all tractions [N]: what rounding is small against where they cancel, as in a torque.
double size_of_tractions(const core::Problem &problem) {
    double size = 0.0;
    for (int f = 0; f < problem.body->mesh.num_boundary_triangles(); ++f)
        if (problem.load_case.is_loaded(f) && !problem.load_case.presses(f))
            size += area_vector(problem.body->mesh, f).norm() * problem.load_case.value[f].norm();
    return size;
}

TEST_P(ModelsAgainstFem, ReactionsBalanceTheLoads) {
    const Vector3 load = total_load(result.problem);
    ASSERT_GT(result.models.size(), 1U);
    for (const auto &model : result.models) {
        Vector3 unbalanced = load;
        double scale = std::max(load.norm(), size_of_tractions(result.problem));
        for (const auto &reaction : model.solution.reaction) {
            unbalanced += reaction;
            scale += reaction.norm();
        }
        EXPECT_LT(unbalanced.norm(), 1e-9 * scale) << model.name;
    }
}

/// Within a factor of 1.3 of what the load case promises; and springs, which are geometrically nonlinear, are within
/// 0.3 % of their own linear solution, a tenth of the best errors, so that linear elasticity is a fair reference.
TEST_P(ModelsAgainstFem, LoadIsInTheLinearRange) {
    const auto *measure = find(reference_name());
    ASSERT_NE(measure, nullptr);
    double peak = 0.0;
    for (const auto &displacement : measure->solution.displacement)
        peak = std::max(peak, displacement.norm());
    const double target = result.problem.load_case.target_peak_displacement;
    EXPECT_LT(peak, 1.3 * target);
    EXPECT_GT(peak, target / 1.3);
    for (const auto &model : result.models) {
        if (model.solution.springs) {
            EXPECT_LT(model.solution.nonlinearity, 0.003) << model.name;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Runs, ModelsAgainstFem, testing::ValuesIn(all_benchmark_cases()),
                         [](const auto &info) { return info.param.body + "_" + info.param.load_case; });

} // namespace
} // namespace livermark
