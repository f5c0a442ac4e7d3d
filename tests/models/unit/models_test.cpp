#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>
#include <set>

#include "core/error_norms.hpp"
#include "models/model_table.hpp"
#include "msm/spring_law.hpp"
#include "tests/test_meshes.hpp"

namespace livermark {
namespace {

TEST(ModelTable, HasEveryFileOfItsFolderUnderItsName) {
    std::set<std::string> files;
    for (const auto &file : std::filesystem::directory_iterator(LIVERMARK_SOURCE_DIR "/models/families"))
        files.insert(file.path().stem().string());
    std::set<std::string> names;
    for (const auto &family : models::all_families()) {
        names.insert(family.name);
        const bool needs_calibration = family.name == "calibrated";
        EXPECT_EQ(family.models({}).empty(), needs_calibration) << family.name;
    }
    EXPECT_EQ(names, files);
}

TEST(ModelTable, NamesEveryModelOnceAndSaysWhereItComesFrom) {
    std::set<std::string> names;
    for (const auto &model : models::all_models()) {
        EXPECT_TRUE(names.insert(model.name).second) << model.name << " is there twice";
        EXPECT_FALSE(model.summary.empty()) << model.name;
        EXPECT_FALSE(model.source.empty()) << model.name;
    }
}

TEST(ModelTable, HasTheReferenceTheBaselineAndEverySpringLaw) {
    std::set<std::string> names;
    for (const auto &model : models::all_models())
        names.insert(model.name);
    EXPECT_TRUE(names.contains(std::string(models::references.front().on_mesh)));
    EXPECT_TRUE(names.contains(std::string(models::references.front().refined)));
    EXPECT_TRUE(names.contains(std::string(models::moving_reference_model)));
    EXPECT_TRUE(names.contains(std::string(models::baseline_model)));
    for (const auto &law : msm::all_spring_laws())
        EXPECT_TRUE(names.contains(law.name)) << law.name;
}

/// A constrained block under an acceleration small enough to be linear: every model says where it is in the problem's
/// shapes.
TEST(EveryModel, SolvesInTheShapesOfTheProblem) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {4, 2, 2}), {1060.0, 5e3, 0.25});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    load_case.acceleration = {0.0, 0.0, -0.01};
    const core::Problem problem{body, load_case};
    for (const auto &model : models::all_models()) {
        const auto solution = model.solve(problem);
        EXPECT_EQ(solution.status, core::SolutionStatus::ok) << model.name << ": " << solution.message;
        EXPECT_EQ(solution.displacement.size(), body->mesh.points.size()) << model.name;
        EXPECT_EQ(solution.reaction.size(), 1U) << model.name;
        EXPECT_GT(solution.strain_energy, 0.0) << model.name;
        EXPECT_GT(solution.degrees_of_freedom, 0) << model.name;
        const double weight = 1060.0 * 0.1 * 0.05 * 0.05 * 0.01;
        EXPECT_NEAR(solution.reaction[0].z(), weight, 1e-9 * weight) << model.name;
    }
}

/// The whole field of every second record: it begins with the static solution, and its probes are the probes.
TEST(EveryModel, ThatMovesKeepsFramesOfItsMotion) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {4, 1, 1}), {1060.0, 5e3, 0.25});
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    tests::pull(load_case, body->mesh, "x_max", {0.0, 0.0, 0.5});
    const int num_nodes = body->mesh.num_nodes();
    const core::Release release{52, 0.002, {1.0, 1e-4}, {{"tip", num_nodes - 1}, {"middle", num_nodes / 2}}};
    load_case.release = release;
    int num_moving = 0;
    for (const auto &model : models::all_models()) {
        const auto solution = model.solve({body, load_case});
        ASSERT_EQ(solution.status, core::SolutionStatus::ok) << model.name << ": " << solution.message;
        if (!solution.history)
            continue;
        ++num_moving;
        const auto &history = *solution.history;
        ASSERT_EQ(history.frames.size(), 27U * body->mesh.points.size()) << model.name;
        for (int i = 0; i < num_nodes; ++i)
            EXPECT_EQ(history.frames[i], solution.displacement[i].cast<float>()) << model.name;
        for (int frame = 0; frame < release.num_frames(); ++frame)
            for (int q = 0; q < 2; ++q)
                EXPECT_EQ(history.frames[frame * num_nodes + release.probes[q].node],
                          history.displacement[2 * frame * 2 + q].cast<float>())
                    << model.name << ", frame " << frame;
    }
    EXPECT_GE(num_moving, 3);
}

TEST(EveryModel, FollowsARigidTranslationOfAllThatIsPrescribed) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {4, 2, 2}), {1060.0, 5e3, 0.25});
    auto load_case = tests::empty_load_case(body->mesh);
    const core::Vector3 shift(0.001, -0.002, 0.003);
    tests::prescribe(load_case, body->mesh, "x_min", shift);
    for (const auto &model : models::all_models())
        for (const auto &displacement : model.solve({body, load_case}).displacement)
            EXPECT_LT((displacement - shift).norm(), 1e-9 * shift.norm()) << model.name;
}

} // namespace
} // namespace livermark
