#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <random>

#include "load_cases/readers/load_case_reader.hpp"
#include "load_cases/readers/needle_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "models/model_table.hpp"
#include "results/records/needle.hpp"
#include "studies/needle/insertion.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"

namespace livermark::studies {
namespace {

constexpr int num_tries = 40, num_driven = 8;

class RandomNeedles : public testing::TestWithParam<std::pair<const char *, const char *>> {};

/// A needle from somewhere on the surface to somewhere inside, as one would write it.
std::string needle_text(const core::TetraMesh &mesh, std::mt19937 &random) {
    std::uniform_real_distribution<double> part;
    std::uniform_int_distribution<int> facet(0, mesh.num_boundary_triangles() - 1);
    const auto &nodes = mesh.boundary_triangles[facet(random)];
    const core::Vector3 entry = (mesh.points[nodes[0]] + mesh.points[nodes[1]] + mesh.points[nodes[2]]) / 3.0;
    const core::Vector3 normal = (mesh.points[nodes[1]] - mesh.points[nodes[0]])
                                     .cross(mesh.points[nodes[2]] - mesh.points[nodes[0]])
                                     .normalized();
    const core::Vector3 aside = normal.unitOrthogonal();
    const core::Vector3 target = entry - (0.012 + 0.04 * part(random)) * (normal + 0.5 * part(random) * aside);
    return fmt::format("[[needle]]\nname = \"some\"\nentry = [{}, {}, {}]\ntarget = [{}, {}, {}]\ndiameter = {}\n"
                       "spread = {}\ntoughness = {}\nfriction = {}\nstep = 0.00025\n",
                       entry.x(), entry.y(), entry.z(), target.x(), target.y(), target.z(),
                       5e-4 + 1.5e-3 * part(random), 0.006 + 0.004 * part(random), 50.0 + 150.0 * part(random),
                       20.0 * part(random));
}

TEST_P(RandomNeedles, AreRefusedOrBalanceTheirEnergies) {
    const auto [name, held] = GetParam();
    const auto body = std::make_shared<const core::Body>(
        meshes::read_body(std::filesystem::path(LIVERMARK_SOURCE_DIR) / "meshes" / fmt::format("{}.toml", name)));
    const auto file = std::filesystem::path(testing::TempDir()) / fmt::format("random_needles_{}.toml", name);
    const auto models = models::all_models();
    const auto &model = support::find_named(models, std::string("fem_p1"), "model");
    std::mt19937 random(3);
    int driven = 0;
    for (int n = 0; n < num_tries && driven < num_driven; ++n) {
        std::ofstream(file) << "title = \"Some needle\"\ntarget_peak_displacement = 0.01\n[[condition]]\npatch = \""
                            << held << "\"\ndisplacement = [0.0, 0.0, 0.0]\n"
                            << needle_text(body->mesh, random);
        core::Problem problem{body, load_cases::read_load_case(file, body->mesh)};
        std::vector<core::Needle> needles;
        try {
            needles = load_cases::read_needles(file, *body, problem.load_case);
        } catch (const support::InputError &) {
            continue; // it would leave the body, or begin where that is held
        }
        ++driven;
        const auto line = core::needle_line(needles.front());
        const auto compliance = model.compliance(problem, line.places);
        const results::NeedleRun run{.model = model.name,
                                     .insertion = insert(compliance.matrix, line, needles.front())};
        for (const double force : run.insertion.force)
            ASSERT_TRUE(std::isfinite(force)) << n;
        EXPECT_GT(run.largest_force(), 0.0) << n;
        EXPECT_LT(run.energy_error(), 0.02) << n;
    }
    EXPECT_EQ(driven, num_driven);
    std::filesystem::remove(file);
}

INSTANTIATE_TEST_SUITE_P(Bodies, RandomNeedles,
                         testing::Values(std::pair{"beam", "x_min"}, std::pair{"liver_healthy", "posterior"},
                                         std::pair{"liver_tumours", "posterior"}),
                         [](const auto &of) { return std::string(of.param.first); });

} // namespace
} // namespace livermark::studies
