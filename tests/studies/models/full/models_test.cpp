#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <set>

#include "core/error_norms.hpp"
#include "msm/spring_law.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

TEST(ModelTable, HasEveryFileOfItsFolderUnderItsName) {
    std::set<std::string> files;
    for (const auto &file : std::filesystem::directory_iterator(LIVERMARK_SOURCE_DIR "/studies/models/families"))
        files.insert(file.path().stem().string());
    std::set<std::string> names;
    for (const auto &family : models::all_families()) {
        names.insert(family.name);
        EXPECT_FALSE(family.models({}).empty()) << family.name;
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
    for (const auto regime : {core::Regime::small, core::Regime::large})
        for (const auto &[on_mesh, refined] : {models::static_reference(regime), models::moving_reference(regime)}) {
            EXPECT_TRUE(names.contains(on_mesh));
            EXPECT_TRUE(names.contains(refined));
        }
    EXPECT_TRUE(names.contains(models::baseline_name()));
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
        if (model.only_moving) { // what tells how good others are keeps the probes
            EXPECT_TRUE(solution.history->frames.empty()) << model.name;
            continue;
        }
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

/// What is let go begins where the model itself is at rest under the whole load: its reactions balance the load there,
/// and springs and hyperelastic elements are not in proportion to it. Linear models are, all of the time.
TEST(EveryModel, IsLetGoFromItsOwnLargeEquilibrium) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.03, 0.03}, {6, 2, 2}), {1060.0, 5e3, 0.25});
    const int tip = body->mesh.num_nodes() - 1;
    const auto pulled = [&](double traction) {
        auto load_case = tests::empty_load_case(body->mesh);
        load_case.regime = core::Regime::large;
        load_case.path = {0.25, 0.5, 0.75, 1.0};
        tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
        tests::pull(load_case, body->mesh, "x_max", {0.0, 0.0, traction});
        load_case.release = core::Release{10, 0.005, {1.0, 1e-3}, {{"tip", tip}}};
        return core::Problem{body, load_case};
    };
    int num_linear = 0, num_others = 0;
    for (const auto &model : models::all_models()) {
        const auto half = model.solve(pulled(10.0)), whole = model.solve(pulled(20.0));
        ASSERT_EQ(whole.status, core::SolutionStatus::ok) << model.name << ": " << whole.message;
        if (!whole.history)
            continue;
        const double load = 20.0 * 0.03 * 0.03;
        EXPECT_NEAR(whole.reaction[0].z(), -load, 1e-6 * load) << model.name;
        const auto &from_half = half.history->displacement, &from_whole = whole.history->displacement;
        EXPECT_EQ(from_whole[0], whole.displacement[tip]) << model.name;
        EXPECT_EQ(whole.history->kinetic_energy[0], 0.0) << model.name;
        EXPECT_LT(from_whole[3].z(), from_whole[0].z()) << model.name;
        double out_of_proportion = 0.0;
        for (std::size_t k = 0; k < from_whole.size(); ++k)
            out_of_proportion = std::max(out_of_proportion, (from_whole[k] - 2.0 * from_half[k]).norm());
        out_of_proportion /= from_whole[0].norm();
        const bool is_linear = std::isnan(whole.nonlinearity);
        (is_linear ? num_linear : num_others) += 1;
        if (is_linear) {
            EXPECT_LT(out_of_proportion, 1e-9) << model.name;
        } else {
            EXPECT_GT(out_of_proportion, 1e-3) << model.name;
            EXPECT_EQ(whole.path.size(), model.only_moving ? 0U : 4U) << model.name;
        }
    }
    EXPECT_GE(num_linear, 2);
    EXPECT_GE(num_others, 5);
}

TEST(EveryModel, FollowsARigidTranslationOfAllThatIsPrescribed) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.05}, {4, 2, 2}), {1060.0, 5e3, 0.25});
    auto load_case = tests::empty_load_case(body->mesh);
    const core::Vector3 shift(0.001, -0.002, 0.003);
    tests::prescribe(load_case, body->mesh, "x_min", shift);
    for (const auto &model : models::all_models()) {
        const auto solution = model.solve({body, load_case});
        ASSERT_EQ(solution.displacement.size(), body->mesh.points.size()) << model.name;
        for (const auto &displacement : solution.displacement)
            EXPECT_LT((displacement - shift).norm(), 1e-9 * shift.norm()) << model.name;
    }
}

} // namespace
} // namespace livermark
