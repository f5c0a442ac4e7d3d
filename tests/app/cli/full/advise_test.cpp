#include <gtest/gtest.h>
#include <string>

#include "tests/livermark_command.hpp"
#include "tests/samples/small_bar.hpp"

namespace livermark::tests {
namespace {

bool says(const Outcome &outcome, const std::string &text) {
    return outcome.output.find(text) != std::string::npos;
}

TEST(AdviseCommand, NamesModelsStepsErrorsAndCaveatsOfAMeshAlone) {
    const auto mesh = (folder_with_bar("advise") / "bar.msh").string();
    const auto advised = livermark("advise " + mesh);
    ASSERT_EQ(advised.status, 0) << advised.output;
    for (const auto *part : {"For touch", "For position", "one stiffness on each edge", "What matters on this body",
                             "critical step [ms]", "results/cohorts/", "one layer of tetrahedra thick", "  3. "})
        EXPECT_TRUE(says(advised, part)) << part << '\n' << advised.output;
    EXPECT_FALSE(says(advised, "nan")) << advised.output;
    EXPECT_FALSE(says(advised, "about 0 ")) << advised.output;
    const auto json = livermark("advise --body " + mesh + " --poisson 0.3 --json");
    EXPECT_EQ(json.status, 0);
    EXPECT_TRUE(says(json, "{\n    \"body\" : {")) << json.output;
    EXPECT_TRUE(says(json, "\"poisson_ratio\" : 0.29999999999999999")) << json.output;
}

TEST(AdviseCommand, RefusesWhatItCannotAdviseOn) {
    const auto folder = folder_with_bar("advise");
    const auto mesh = (folder / "bar.msh").string(), body = (folder / "bar.toml").string();
    for (const auto &[arguments, fault] : {std::pair<std::string, std::string>{"advise", "--body is required"},
                                           {"advise " + mesh + " " + body, "bodies are given; name one"},
                                           {"advise " + mesh + " --tool-radius 12", "12 mm are 0.012"},
                                           {"advise " + mesh + " --budget 1e-9", "every model takes longer"}}) {
        const auto refused = livermark(arguments);
        EXPECT_EQ(refused.status, 2) << arguments;
        EXPECT_TRUE(says(refused, fault)) << refused.output;
    }
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
    EXPECT_EQ(help.status, 0);
    EXPECT_TRUE(says(help, "LIVERMARK_ROOT")) << help.output;
}

TEST(Modes, OfABarThatShipsAreConstrainedAsInALoadCaseThatFits) {
    const auto folder = folder_with_bar("modes_of_beam");
    const auto found = livermark("modes beam --model lloyd --count 2 --output " + (folder / "out").string());
    EXPECT_EQ(found.status, 0) << found.output;
    EXPECT_TRUE(says(found, "beam: constrained as in beam_bend, because traction does not fit")) << found.output;
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
    EXPECT_EQ(listed.status, 0) << listed.output;
    EXPECT_TRUE(says(listed, "of the copy")) << listed.output;
    EXPECT_FALSE(says(listed, "liver_tumours")) << listed.output;
}

} // namespace
} // namespace livermark::tests
