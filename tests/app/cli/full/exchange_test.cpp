#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "results/hdf5/result_file.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark {
namespace {

namespace fs = std::filesystem;

/// A small bar under its weight and a traction, as a body and a load case of a user.
class Exchange : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = tests::folder_with_bar("exchange");
        tests::write_pull(folder_, "pull", 10.0, "acceleration = [0.0, 0.0, -0.5]\n");
    }

    std::string at(const std::string &name) const { return (folder_ / name).string(); }
    std::string problem() const { return at("bar.toml") + " " + at("pull.toml"); }

    fs::path folder_;
};

TEST_F(Exchange, AProblemIsWrittenInThreeFormats) {
    const auto outcome = tests::livermark(fmt::format("export {} -o {}", problem(), at("out")));
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const auto folder = folder_ / "out" / "bar";
    const auto problem_file = results::read_result(folder / "pull.problem.h5");
    EXPECT_TRUE(problem_file.models.empty());
    const auto &mesh = problem_file.problem.body->mesh;
    // What VTK's reader in meshio sees: the forces add up to the traction times the area and the weight.
    const auto sums = tests::run_command(fmt::format(
        "/usr/bin/python3 -c \"import meshio; m = meshio.read('{}'); f = m.point_data['nodal_force'].sum(0); "
        "print('nodes', len(m.points), 'held', m.point_data['is_prescribed'].all(1).sum(), 'force %.6e %.6e' % (f[0], "
        "f[2]))\"",
        (folder / "pull.vtu").string()));
    ASSERT_EQ(sums.status, 0) << sums.output;
    EXPECT_NE(sums.output.find(fmt::format("nodes {} ", mesh.points.size())), std::string::npos) << sums.output;
    const auto constrained = std::ranges::count_if(mesh.points, [](const auto &x) { return x.x() < 1e-9; });
    EXPECT_NE(sums.output.find(fmt::format("held {} ", constrained)), std::string::npos) << sums.output;
    EXPECT_NE(sums.output.find(fmt::format("force {:.6e} {:.6e}", 10.0 * 9e-4, -0.5 * 1000.0 * 8.1e-5)),
              std::string::npos)
        << sums.output;
    EXPECT_TRUE(fs::exists(folder / "pull.inp"));
}

TEST_F(Exchange, PythonWritesAJobOfFebio) {
    const auto outcome = tests::livermark(fmt::format("export {} --format febio -o {}", problem(), at("out")));
    tests::expect_outcome(outcome, 0, {"pull.problem.h5", "pull.feb"});
    const auto folder = folder_ / "out" / "bar";
    const auto mesh = results::read_result(folder / "pull.problem.h5").problem.body->mesh;
    const auto sums = tests::run_command(
        fmt::format("/usr/bin/python3 -c \"import xml.etree.ElementTree as t; j = t.parse('{}').getroot(); n = lambda "
                    "p: j.findall(p); "
                    "f = [list(map(float, e.text.split(','))) for e in n('MeshData/NodeData/node')]; "
                    "print('nodes', len(n('Mesh/Nodes/node')), 'elements', len(n('Mesh/Elements/elem')), "
                    "'force %.6e %.6e' % (sum(e[0] for e in f), sum(e[2] for e in f)))\"",
                    (folder / "pull.feb").string()));
    tests::expect_outcome(sums, 0,
                          {fmt::format("nodes {} elements {} ", mesh.num_nodes(), mesh.num_tetrahedra()),
                           fmt::format("force {:.6e} {:.6e}", 10.0 * 9e-4, -0.5 * 1000.0 * 8.1e-5)});
}

} // namespace
} // namespace livermark

namespace livermark::tests {
namespace {

bool says(const Outcome &outcome, const std::string &text) {
    return outcome.output.find(text) != std::string::npos;
}

TEST(AdviseCommand, NamesModelsStepsErrorsAndCaveatsOfAMeshAlone) {
    const auto mesh = (folder_with_bar("advise") / "bar.msh").string();
    const auto advised = livermark("advise " + mesh);
    ASSERT_EQ(advised.status, 0) << advised.output;
    for (const auto *part :
         {"For touch", "For position", "one stiffness on each edge", "What matters on this body", "critical step [ms]",
          "results/cohorts/", "one layer of tetrahedra thick", "  3. ", "livermark springs BODY --for ENGINE"})
        EXPECT_TRUE(says(advised, part)) << part << '\n' << advised.output;
    EXPECT_FALSE(says(advised, "nan")) << advised.output;
    EXPECT_FALSE(says(advised, "about 0 ")) << advised.output;
    expect_outcome(livermark("advise " + mesh + " --budget 1e-9"), 2, {"every model takes longer"});
    const auto json = livermark("advise --body " + mesh + " --poisson 0.3 --json");
    expect_outcome(json, 0, {"{\n    \"body\" : {", "\"poisson_ratio\" : 0.29999999999999999"});
}

TEST(SpringsCommand, WritesAFileForEveryEngineAndSaysWhatWasNotMeasured) {
    const auto folder = folder_with_bar("springs_command", 0.02, pressure_ratio);
    const auto body = (folder / "bar.toml").string(), out = (folder / "out").string();
    expect_outcome(livermark("springs " + body + " --for jolt --substeps 40 -o " + out), 0,
                   {"bar for jolt: edges and tetrahedra", "mNumIterations", "40", "edge_compliance", "How to use them",
                    "xpected error", "bar.jolt.json"});
    expect_outcome(livermark("springs " + body + " --for mujoco --poisson 0.3 -o " + out), 0,
                   {"0.3", "bar.mujoco.json", "bar.mujoco.xml"});
    for (const auto *engine : {"bullet", "godot", "newton", "sofa"})
        expect_outcome(livermark(fmt::format("springs {} --for {} --markdown -o {}", body, engine, out)), 0,
                       {"| setting |", fmt::format("bar.{}.json", engine)});
    const auto read = run_command(
        fmt::format("/usr/bin/python3 -c \"import json; j = json.load(open('{}/bar.jolt.json')); a = j['arrays']; "
                    "print(len(a['points']['values']) == a['points']['shape'][0], a['edge_compliance']['unit'], "
                    "j['settings'][0]['value'])\"",
                    out));
    expect_outcome(read, 0, {"True m/N 40"});
    expect_outcome(livermark("springs " + body + " --for unity -o " + out), 2,
                   {"no engine 'unity'; known are: bullet, godot, jolt, mujoco, newton, sofa"});
    expect_outcome(livermark("springs " + body + " --for jolt --law loyd -o " + out), 2, {"no spring law 'loyd'"});
    expect_outcome(livermark("springs " + body + " --for jolt --substeps 0 -o " + out), 2, {"0 substeps in a frame"});
    expect_outcome(livermark("springs " + body + " --for jolt --frame -1 -o " + out), 2, {"above zero"});
    expect_outcome(livermark("springs " + body + " -o " + out), 2, {"--for"});
}

TEST(BodyArgument, IsTheSameBehindTheCommandAndBehindAnOption) {
    const auto folder = folder_with_bar("body_argument");
    const auto body = (folder / "bar.toml").string();
    std::ofstream(folder / "hang.toml") << "acceleration = [0.0, 0.0, -0.1]\n[[condition]]\npatch = \"x_min\"\n"
                                           "displacement = [0.0, 0.0, 0.0]\n";
    const auto hang = (folder / "hang.toml").string(), out = (folder / "out").string();
    for (const auto &arguments :
         {"modes " + body + " --load-case " + hang, "modes --body " + body + " --load-case " + hang,
          "run " + body + " --load-case " + hang + " --model lloyd --reference-on-mesh",
          "run --body " + body + " --load-case " + hang + " --model lloyd --reference-on-mesh",
          "export " + body + " " + hang, "export --body " + body + " --load-case " + hang}) {
        const auto done = livermark(arguments + " --output " + out);
        EXPECT_EQ(done.status, 0) << arguments << '\n' << done.output;
    }
}

TEST(HelpCommand, IsTheHelpOfACommandAndNamesTheEnvironment) {
    EXPECT_EQ(livermark("help modes").output, livermark("modes --help").output);
    const auto help = livermark("help");
    expect_outcome(help, 0, {"LIVERMARK_ROOT"});
}

TEST(Modes, OfABarThatShipsAreConstrainedAsInALoadCaseThatFits) {
    const auto folder = folder_with_bar("modes_of_beam");
    const auto found = livermark("modes beam --model lloyd --count 2 --output " + (folder / "out").string());
    expect_outcome(found, 0, {"beam: constrained as in beam_bend, because traction does not fit"});
}

TEST(RootFolder, IsThatOfTheTreeThatTheProgramLiesIn) {
    namespace fs = std::filesystem;
    const auto copy = folder_with_bar("copied_tree");
    for (const auto *folder : {"meshes", "load_cases"})
        fs::create_directories(copy / folder);
    fs::create_directories(copy / "build" / "release");
    std::ofstream(copy / "meshes" / "liver_healthy.toml") << "title = \"of the copy\"\nmesh = \"none.msh\"\n";
    const auto program = copy / "build" / "release" / "livermark";
    fs::copy_file(LIVERMARK_BINARY, program);
    const auto listed = run_command("env --unset=LIVERMARK_ROOT " + program.string() + " list bodies");
    expect_outcome(listed, 0, {"of the copy"});
    EXPECT_FALSE(says(listed, "liver_tumours")) << listed.output;
}

} // namespace
} // namespace livermark::tests
