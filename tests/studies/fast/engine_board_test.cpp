#include "studies/exchange/engine_board.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "tests/bad_input.hpp"

namespace livermark::studies {
namespace {

const std::string entry_head = "engine = \"jelly\"\nversion = \"1\"\nmachine = \"a laptop\"\n";
const std::string entry_problem = "[[problem]]\nbody = \"beam\"\nload_case = \"beam_bend\"\nsolution = \"bend.csv\"\n";

TEST(EntryFile, HasAnEngineItsSettingsAndItsProblems) {
    const auto file = parse_entry_file(
        entry_head +
            "url = \"https://example.org\"\ncannot = [\"It has no contact.\"]\nboard = 7\n"
            "[settings]\nsubsteps = 20\n[[problem]]\nvariant = " +
            std::to_string(board_livers(7).front()) +
            "\ntetrahedra = 4000\nload_case = \"palpation\"\nsolution = \"a.csv\"\nsetup_seconds = 2\nunit = \"mm\"\n",
        "mine.toml");
    EXPECT_EQ(file.entry.engine, "jelly");
    EXPECT_EQ(file.entry.board, 7);
    EXPECT_EQ(file.entry.cannot.size(), 1U);
    EXPECT_EQ(file.entry.settings["substeps"], 20);
    ASSERT_EQ(file.problems.size(), 1U);
    EXPECT_EQ(file.problems[0].target_tetrahedra, 4000);
    EXPECT_EQ(file.problems[0].setup_seconds, 2.0);
    EXPECT_TRUE(std::isnan(file.problems[0].memory_bytes));
    EXPECT_TRUE(file.entry.problems.empty());
}

TEST(EntryFile, SaysWhatIsWrongAndWhere) {
    EXPECT_EQ(parse_entry_file(entry_head + entry_problem, "mine.toml").problems.size(), 1U);
    const auto refused = [](const std::string &text, const std::string &part) {
        tests::expect_input_error([&] { parse_entry_file(text, "mine.toml"); }, {"mine.toml:", part});
    };
    refused("engine = 3", "'engine'");
    refused("engine = \"a b\"\n", "a name has letters, digits, _ and - only");
    refused("engine = \"fem_p1\"\n", "there is a model 'fem_p1' already");
    refused("engine = \"jelly\"\nversion = \"\"\n", "'version' is empty");
    refused("engine = \"jelly\"\nversion = \"1\"\n", "'machine' is missing");
    refused(entry_head, "there is no [[problem]]");
    refused(entry_head + "problem = 3\n", "there is no [[problem]]");
    refused(entry_head + "setings = 3\n" + entry_problem, "unknown key 'setings'");
    refused(entry_head + "cannot = \"fly\"\n" + entry_problem, "'cannot'");
    refused(entry_head + "board = 0\n" + entry_problem, "'board' has to be a whole number from 1");
    refused(entry_head + "board = 7\n" + entry_problem, "this is no liver of board 7");
    refused(entry_head + entry_problem + entry_problem, "mine.toml:8: this problem is there twice");
    refused(entry_head + entry_problem + "tetrahedra = 4000\n", "belongs to a 'variant'");
    refused(entry_head + entry_problem + "variant = 12\n", "either 'body' or 'variant'; leave one out");
    refused(entry_head + entry_problem + "cannot = \"it diverges\"\n", "either 'solution' or 'cannot'; leave one out");
    refused(entry_head + "[[problem]]\nbody = \"beam\"\nload_case = \"beam_bend\"\n", "add one");
    refused(entry_head + entry_problem + "seconds_per_frame = -1\n", "has to be positive");
    refused(entry_head + entry_problem + "unit = \"inch\"\n", "is not a unit of length");
    refused(entry_head + entry_problem + "solutoin = \"a\"\n", "unknown key 'solutoin'");
}

TEST(BoardLivers, AreTwoThatNobodyTunedOn) {
    for (int seed = 1; seed < 200; ++seed) {
        const auto livers = board_livers(seed);
        ASSERT_EQ(livers.size(), 2U);
        EXPECT_NE(livers[0], livers[1]);
        for (const int liver : livers) {
            EXPECT_EQ(liver % 2, 0);
            EXPECT_GT(liver, 1000);
            EXPECT_LE(liver, 1000000);
        }
        EXPECT_EQ(board_livers(seed), livers);
        EXPECT_NE(board_livers(seed + 1), livers);
    }
}

} // namespace
} // namespace livermark::studies
