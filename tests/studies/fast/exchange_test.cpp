#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <sstream>

#include "core/error_norms.hpp"
#include "results/hdf5/result_file.hpp"
#include "studies/exchange/exchange.hpp"
#include "studies/exchange/formats/ground_springs.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/small_bar.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::studies {
namespace {

namespace fs = std::filesystem;

/// A small bar under its weight and a traction, as a body and a load case of a user.
class ExchangeStudy : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = tests::folder_with_bar("exchange_study");
        tests::write_pull(folder_, "pull", 10.0, "acceleration = [0.0, 0.0, -0.5]\n");
        scored.body = exported.body = at("bar.toml");
        scored.load_case = exported.load_case = at("pull.toml");
        scored.solution = at("solution.csv");
        scored.output = at("scores");
        exported.output = at("out");
    }
    std::string at(const std::string &name) const { return (folder_ / name).string(); }

    /// Writes the displacements of a model, multiplied, as somebody else's, from the last node to the first.
    void write_csv(const results::Result &result, const std::string &model, double factor) const {
        const auto found = std::ranges::find(result.models, model, &results::ModelResult::name);
        std::ofstream out(at("solution.csv"));
        out << "x,y,z,ux,uy,uz\n";
        for (std::size_t i = result.problem.body->mesh.points.size(); i-- > 0;) {
            const auto &x = result.problem.body->mesh.points[i];
            const core::Vector3 u = factor * found->solution.displacement[i];
            fmt::print(out, "{},{},{},{},{},{}\n", x.x(), x.y(), x.z(), u.x(), u.y(), u.z());
        }
    }

    /// The problem, with the same displacement of every node as the solution of "own"; this is in the file, too.
    results::Result own_solution(const core::Vector3 &displacement) const {
        results::Result own;
        own.problem = results::read_result(export_problem(exported, "test").files.at(0)).problem;
        own.models.emplace_back().name = "own";
        own.models[0].solution.displacement.assign(own.problem.body->mesh.points.size(), displacement);
        write_csv(own, "own", 1.0);
        return own;
    }

    fs::path folder_;
    ScoreOptions scored;
    ExportOptions exported;
};

const results::ModelResult &find(const results::Result &result, const std::string &name) {
    return *std::ranges::find(result.models, name, &results::ModelResult::name);
}

TEST_F(ExchangeStudy, ASolutionHasTheErrorThatOurOwnModelWithTheSameHas) {
    own_solution(core::Vector3::Zero());
    const auto nothing = score(scored, "test", {}).result;
    EXPECT_EQ(find(nothing, "mine").comparison->relative_l2, 1.0) << "all of the displacement is missing";

    write_csv(nothing, "fem_p1", 1.0);
    const auto found = score(scored, "test", {});
    const auto &theirs = *find(found.result, "mine").comparison, &ours = *find(found.result, "fem_p1").comparison;
    EXPECT_EQ(theirs.reference, ours.reference);
    EXPECT_EQ(theirs.relative_l2, ours.relative_l2);
    EXPECT_EQ(theirs.max_error, ours.max_error);
    EXPECT_TRUE(std::isnan(theirs.reaction_error)) << "nothing is said of forces";
    EXPECT_EQ(found.file, fs::path(at("scores")) / "bar" / "pull.mine.h5");
    EXPECT_EQ(find(results::read_result(found.file), "mine").comparison->relative_l2, theirs.relative_l2);

    // Twice the reference is as wrong as nothing.
    write_csv(found.result, theirs.reference, 2.0);
    EXPECT_NEAR(find(score(scored, "test", {}).result, "mine").comparison->relative_l2, 1.0, 1e-12);
}

TEST_F(ExchangeStudy, AProblemIsWrittenInThreeFormats) {
    const auto found = export_problem(exported, "test");
    ASSERT_EQ(found.files.size(), 3u);
    for (const auto &file : found.files)
        EXPECT_GT(fs::file_size(file), 0u) << file;
    const auto result = results::read_result(found.files[0]);
    EXPECT_TRUE(result.models.empty());
    EXPECT_EQ(result.problem.load_case.acceleration, core::Vector3(0.0, 0.0, -0.5));
    std::ifstream inp(found.files[1]);
    std::string line;
    int num_nodes = -1;
    for (bool is_node = false; std::getline(inp, line);) {
        if (line.starts_with("*"))
            is_node = line.starts_with("*NODE,");
        num_nodes += is_node ? 1 : 0; // the heading too
    }
    EXPECT_EQ(num_nodes, result.problem.body->mesh.num_nodes());
}

TEST_F(ExchangeStudy, EveryFormatIsWrittenWhereItIsNamedAndAnUnknownOneIsRefused) {
    for (const auto &format : exchange::all_formats()) {
        if (format.name == "febio")
            continue; // Python writes it
        exported.formats = {format.name};
        const auto found = export_problem(exported, "test").files;
        ASSERT_EQ(found.size(), 1 + format.files.size()) << format.name;
        for (std::size_t f = 0; f < format.files.size(); ++f) {
            EXPECT_EQ(found[f + 1].filename(), std::string("pull") + format.files[f].ending);
            EXPECT_GT(fs::file_size(found[f + 1]), 0u) << found[f + 1];
        }
    }
    exported.formats = {"tetgn"};
    tests::expect_input_error([&] { export_problem(exported, "test"); },
                              {"no format 'tetgn'", "did you mean 'tetgen'?"});
}

const exchange::ExportFormat &format_named(const std::string &name) {
    return *std::ranges::find(exchange::all_formats(), name, &exchange::ExportFormat::name);
}

TEST(ExportFormats, SayWhichPartsTheirJobsHave) {
    using Kind = exchange::FurtherKind;
    const exchange::JobKind small{core::Regime::small, false}, quadratic{core::Regime::small, true},
        large{core::Regime::large, false};
    const auto calculix = format_named("calculix").job_has, febio = format_named("febio").job_has;
    for (const auto &job : {small, quadratic, large}) {
        EXPECT_EQ(calculix(Kind::capsule, job), job == small);
        EXPECT_EQ(calculix(Kind::vessels, job), !job.quadratic);
        EXPECT_TRUE(calculix(Kind::foundation, job));
        for (const auto kind : {Kind::plain_ball, Kind::map, Kind::other})
            EXPECT_FALSE(calculix(kind, job));
        for (const auto kind : {Kind::plain_ball, Kind::map, Kind::foundation, Kind::capsule, Kind::vessels})
            EXPECT_TRUE(febio(kind, job));
        EXPECT_FALSE(febio(Kind::other, job));
    }
    EXPECT_FALSE(format_named("vtu").job_has);
}

/// Energy of springs to the ground where nodes move.
double energy_of(const std::vector<exchange::GroundSpring> &springs, const std::vector<core::Vector3> &displacement) {
    double sum = 0.0;
    for (const auto &spring : springs) {
        core::Vector3 end = spring.rest;
        for (int i = 0; i < 3; ++i)
            for (const auto &term : spring.displacement[i])
                end[i] += term.factor * displacement[term.node][term.component];
        const double longer = end.norm() - spring.rest.norm();
        sum += 0.5 * longer * longer;
    }
    return sum;
}

/// A foundation under u = G x, by the rule of the middles of edges, which is exact for its square.
TEST(GroundSprings, HaveTheEnergyOfAFoundation) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.05, 0.04}, {3, 2, 2}), {1060.0, 5000.0, 0.45});
    core::Foundation foundation;
    for (int f = 0; f < body->mesh.num_boundary_triangles(); f += 2) {
        foundation.facets.push_back(f);
        foundation.stiffness.push_back(1e4 * (1.0 + f));
        foundation.normal_only.push_back(f % 3 == 0 ? 1 : 0);
    }
    auto load_case = tests::empty_load_case(body->mesh);
    load_case.foundation = foundation;
    Eigen::Matrix3d gradient;
    gradient << 0.1, 0.2, -0.1, 0.0, -0.2, 0.3, 0.1, -0.2, 0.1;
    double expected = 0.0;
    for (std::size_t which = 0; which < foundation.facets.size(); ++which) {
        const auto corners = core::corners_of(body->mesh, foundation.facets[which]);
        const core::Vector3 area = core::area_vector(body->mesh, foundation.facets[which]);
        for (int v = 0; v < 3; ++v) {
            const core::Vector3 u = 0.5 * gradient * (corners[v] + corners[(v + 1) % 3]);
            const double held = foundation.normal_only[which] ? u.dot(area.normalized()) : u.norm();
            expected += foundation.stiffness[which] / 2.0 * area.norm() / 3.0 * held * held;
        }
    }
    for (const int degree : {1, 2}) {
        const auto fem = exchange::discretise(body->mesh, degree);
        std::vector<core::Vector3> displacement;
        for (const auto &point : fem.points)
            displacement.emplace_back(gradient * point);
        EXPECT_NEAR(energy_of(exchange::ground_springs({body, load_case}, fem), displacement), expected,
                    1e-8 * expected);
    }
}

TEST(GroundSprings, HaveTheEnergyOfVessels) {
    const auto body = tests::vessels::with_vessels(
        tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {3, 3, 3}), {1060.0, 5000.0, 0.45}));
    Eigen::Matrix3d f;
    f << 1.3, 0.2, -0.1, 0.0, 0.8, 0.3, 0.1, -0.2, 1.1;
    double expected = 0.0;
    for (const auto &point : core::vessel_points(*body))
        expected += point.energy(f * point.direction);
    std::vector<core::Vector3> displacement;
    for (const auto &point : body->mesh.points)
        displacement.emplace_back(f * point - point);
    const auto springs =
        exchange::ground_springs({body, tests::empty_load_case(body->mesh)}, exchange::discretise(body->mesh, 1));
    EXPECT_NEAR(energy_of(springs, displacement), expected, 1e-9 * expected);
}

/// Rows of numbers behind the first line, which has their number.
std::vector<std::vector<double>> rows_of_tetgen(const fs::path &file) {
    std::ifstream text(file);
    std::vector<std::vector<double>> rows;
    std::string line;
    std::size_t count = 0;
    text >> count;
    std::getline(text, line);
    while (std::getline(text, line)) {
        std::istringstream words(line);
        rows.emplace_back(std::istream_iterator<double>(words), std::istream_iterator<double>());
    }
    EXPECT_EQ(rows.size(), count) << file;
    return rows;
}

TEST_F(ExchangeStudy, TetgenHasTheNumbersOfTheMesh) {
    exported.formats = {"tetgen"};
    const auto files = export_problem(exported, "test").files;
    ASSERT_EQ(files.size(), 4u);
    const auto mesh = results::read_result(files[0]).problem.body->mesh;
    const auto nodes = rows_of_tetgen(files[1]), elements = rows_of_tetgen(files[2]), faces = rows_of_tetgen(files[3]);
    ASSERT_EQ(nodes.size(), mesh.points.size());
    ASSERT_EQ(elements.size(), mesh.tetrahedra.size());
    ASSERT_EQ(faces.size(), mesh.boundary_triangles.size());
    for (std::size_t i = 0; i < nodes.size(); ++i)
        EXPECT_EQ(nodes[i], (std::vector{i + 1.0, mesh.points[i].x(), mesh.points[i].y(), mesh.points[i].z()}));
    for (std::size_t t = 0; t < elements.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        EXPECT_EQ(elements[t], (std::vector{t + 1.0, a + 1.0, b + 1.0, c + 1.0, d + 1.0, mesh.region[t] + 1.0}));
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto &[a, b, c] = mesh.boundary_triangles[f];
        EXPECT_EQ(faces[f], (std::vector{f + 1.0, a + 1.0, b + 1.0, c + 1.0, mesh.boundary_patch[f] + 1.0}));
    }
}

TEST_F(ExchangeStudy, ASolutionOfAnotherMeshAndANameThatIsTakenAreRefused) {
    std::ofstream(at("solution.csv")) << "x,y,z,ux,uy,uz\n1,2,3,0,0,0\n";
    tests::expect_input_error([&] { score(scored, "test", {}); }, {"belongs to another mesh"});
    scored.name = "fem_p1";
    tests::expect_input_error([&] { score(scored, "test", {}); }, {"choose another --name"});
    EXPECT_FALSE(fs::exists(at("scores")));
}

TEST_F(ExchangeStudy, AsksWhetherASolutionIsInMillimetres) {
    auto own = own_solution(core::Vector3(1e-4, 0.0, 0.0));
    const double in_metres = find(score(scored, "test", {}).result, "mine").comparison->relative_l2;

    write_csv(own, "own", 1000.0);
    tests::expect_input_error([&] { score(scored, "test", {}); }, {"these seem to be millimetres", "or --unit mm"});
    scored.unit = "mm";
    EXPECT_NEAR(find(score(scored, "test", {}).result, "mine").comparison->relative_l2, in_metres, 1e-9);
    scored.unit = "m"; // as it is
    EXPECT_GT(find(score(scored, "test", {}).result, "mine").comparison->relative_l2, 10.0);
}

TEST_F(ExchangeStudy, DoubtsTheSignOfDisplacementsThatPointAgainstTheReference) {
    own_solution(core::Vector3::Zero());
    const auto solved = score(scored, "test", {});
    EXPECT_TRUE(solved.notes.empty()) << solved.notes.front();
    write_csv(solved.result, "fem_p1", 1.0);
    EXPECT_TRUE(score(scored, "test", {}).notes.empty());
    write_csv(solved.result, "fem_p1", -0.5);
    const auto notes = score(scored, "test", {}).notes;
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find("the displacements of mine point against those of fem_p2"), std::string::npos) << notes[0];
    EXPECT_NE(notes[0].find("correlation -1.00); check their sign"), std::string::npos) << notes[0];
}

TEST_F(ExchangeStudy, RefusesPositionsInPlaceOfDisplacements) {
    auto own = own_solution(core::Vector3::Zero());
    for (const double per_metre : {1.0, 1000.0}) {
        own.models[0].solution.displacement = own.problem.body->mesh.points;
        for (auto &position : own.models[0].solution.displacement)
            position = per_metre * (position + core::Vector3(0.001, 0.0, 0.0));
        write_csv(own, "own", 1.0);
        tests::expect_input_error([&] { score(scored, "test", {}); },
                                  {"seem to be positions of the nodes", "0.001 m away", "subtract the coordinates"});
    }
}

TEST_F(ExchangeStudy, SaysWhatWillTakeLongBeforeItIsSolved) {
    auto own = own_solution(core::Vector3::Zero());
    const auto steps = [&] {
        std::vector<std::string> found;
        score(scored, "test", [&](int step, int num_steps, const std::string &about) {
            EXPECT_EQ(step, static_cast<int>(found.size()) + 1);
            EXPECT_LE(step, num_steps);
            found.push_back(step == num_steps ? about + ", the last" : about);
        });
        return found;
    };
    const auto size = fmt::format(" on {} tetrahedra", own.problem.body->mesh.num_tetrahedra());
    const auto found = steps();
    EXPECT_EQ(found.front(), "fem_p1" + size);
    EXPECT_EQ(found.back(), "mine, the last");
    const auto refined = size + " and finer meshes, which takes longest; --reference-on-mesh does without";
    EXPECT_EQ(std::ranges::count_if(found, [&](const auto &about) { return about.ends_with(refined); }), 1);
    scored.reference_on_mesh = true;
    for (const auto &about : steps())
        EXPECT_EQ(about.find("finer"), std::string::npos) << about;
}

TEST_F(ExchangeStudy, TakesCoordinatesInTheUnitOfTheDisplacementsToo) {
    auto own = own_solution(core::Vector3(1e-4, 0.0, 0.0));
    const double in_metres = find(score(scored, "test", {}).result, "mine").comparison->relative_l2;
    auto in_millimetres = *own.problem.body;
    for (auto &point : in_millimetres.mesh.points)
        point *= 1000.0;
    own.problem.body = std::make_shared<const core::Body>(std::move(in_millimetres));
    write_csv(own, "own", 1000.0);
    scored.unit = "mm";
    EXPECT_NEAR(find(score(scored, "test", {}).result, "mine").comparison->relative_l2, in_metres, 1e-9);
}

} // namespace
} // namespace livermark::studies
