#include <filesystem>
#include <functional>
#include <gtest/gtest.h>

#include "core/support/input_error.hpp"
#include "results/records/springs.hpp"
#include "studies/models/model_table.hpp"
#include "tests/samples/records/sample_calibration.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

std::string refusal_by(const std::function<void()> &action) {
    try {
        action();
    } catch (const support::InputError &error) {
        return error.what();
    }
    return "nothing was refused";
}

class CalibrationFile : public testing::Test {
  protected:
    void SetUp() override {
        path_ = std::filesystem::path(testing::TempDir()) /
                (std::string("livermark_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".h5");
        std::filesystem::remove(path_);
    }
    void TearDown() override { std::filesystem::remove(path_); }

    std::filesystem::path path_;
    std::shared_ptr<const core::Body> body_ =
        tests::make_body(tests::box_mesh({0.2, 0.1, 0.1}, {2, 1, 1}), {1060.0, 5e3, 0.45});
};

TEST_F(CalibrationFile, ComesBackAsItWasWritten) {
    const auto written = tests::sample_calibration(*body_);
    results::write_calibration(path_, written);
    const auto read = results::read_calibration(path_);
    EXPECT_EQ(read.body, written.body);
    EXPECT_EQ(read.spring_law, written.spring_law);
    EXPECT_EQ(read.volume_term, written.volume_term);
    EXPECT_EQ(read.reference, written.reference);
    EXPECT_EQ(read.constrained, written.constrained);
    EXPECT_EQ(read.seed, written.seed);
    EXPECT_EQ(read.iterations, written.iterations);
    EXPECT_EQ(read.penalty, written.penalty);
    EXPECT_EQ(read.springs.origin, path_.string());
    EXPECT_EQ(read.springs.edges, written.springs.edges);
    EXPECT_EQ(read.springs.rest_length, written.springs.rest_length);
    EXPECT_EQ(read.springs.stiffness, written.springs.stiffness);
    EXPECT_EQ(read.start_stiffness, written.start_stiffness);
    EXPECT_EQ(read.held_out, written.held_out);
    EXPECT_EQ(read.error_before, written.error_before);
    EXPECT_EQ(read.error_after, written.error_after);
    ASSERT_EQ(read.springs.materials.size(), 1u);
    EXPECT_EQ(read.springs.materials[0].density, 1060.0);
    EXPECT_EQ(read.springs.materials[0].young_modulus, 5e3);
    EXPECT_EQ(read.springs.materials[0].poisson_ratio, 0.45);
}

TEST_F(CalibrationFile, OfAnotherKindIsRefusedWithTheRemedy) {
    const auto read = [&] { results::read_calibration(path_); };
    EXPECT_NE(refusal_by(read).find("make it with `python3 -m livermark.calibration`"), std::string::npos)
        << refusal_by(read);
    results::write_stability(path_, {});
    EXPECT_NE(
        refusal_by(read).find("holds no calibration; make the file again with `python3 -m livermark.calibration`"),
        std::string::npos)
        << refusal_by(read);
}

TEST_F(CalibrationFile, WithoutStiffnessInASpringIsRefused) {
    auto calibration = tests::sample_calibration(*body_);
    calibration.springs.stiffness[3] = 0.0;
    results::write_calibration(path_, calibration);
    const auto message = refusal_by([&] { results::read_calibration(path_); });
    EXPECT_NE(message.find("/springs/stiffness row 3 is 0"), std::string::npos) << message;
}

TEST(CalibratedSprings, AreRefusedForAnotherMeshOrMaterial) {
    const core::Material material{1060.0, 5e3, 0.45};
    const auto body = tests::make_body(tests::box_mesh({0.2, 0.1, 0.1}, {2, 1, 1}), material);
    const auto springs = tests::sample_calibration(*body).springs;
    EXPECT_NO_THROW(core::check_fit(springs, *body));
    auto heavier = *body;
    heavier.materials[0].density = 2000.0;
    EXPECT_NO_THROW(core::check_fit(springs, heavier));

    auto other_nodes = *body;
    other_nodes.mesh.points[0].x() -= 1e-6;
    const auto other_edges = tests::make_body(tests::box_mesh({0.2, 0.1, 0.1}, {3, 1, 1}), material);
    for (const core::Body *other : {static_cast<const core::Body *>(&other_nodes), other_edges.get()}) {
        const auto message = refusal_by([&] { core::check_fit(springs, *other); });
        EXPECT_NE(message.find("another mesh"), std::string::npos) << message;
        EXPECT_NE(message.find("`python3 -m livermark.calibration`"), std::string::npos) << message;
    }
    for (const core::Material &other : {core::Material{1060.0, 5e3, 0.3}, core::Material{1060.0, 6e3, 0.45}}) {
        const auto message = refusal_by([&] { core::check_fit(springs, *tests::make_body(body->mesh, other)); });
        EXPECT_NE(message.find("was made for Young's modulus and Poisson's ratio 5000 Pa and 0.45"), std::string::npos)
            << message;
    }
}

TEST(CalibratedSprings, AreAModelWhereThereAreAny) {
    const auto body = tests::make_body(tests::box_mesh({0.2, 0.1, 0.1}, {2, 1, 1}), {1060.0, 5e3, 0.45});
    models::ModelOptions options;
    const auto find = [&]() -> std::optional<core::Model> {
        for (const auto &model : models::all_models(options))
            if (model.name == "calibrated_nodal_volume")
                return model;
        return std::nullopt;
    };
    EXPECT_FALSE(find());
    const auto springs = tests::sample_calibration(*body).springs;
    options.calibration = std::make_shared<const core::CalibratedSprings>(springs);
    const auto model = find();
    ASSERT_TRUE(model);
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    load_case.acceleration = {0.0, 0.0, -0.01};
    EXPECT_NO_THROW(model->check({body, load_case}));
    const auto solution = model->solve({body, load_case});
    ASSERT_TRUE(solution.springs);
    EXPECT_EQ(solution.springs->stiffness, springs.stiffness);

    const auto other = tests::make_body(body->mesh, {1060.0, 5e3, 0.3});
    EXPECT_THROW(model->check({other, load_case}), support::InputError);
}

} // namespace
} // namespace livermark
