#include "results/records/engine_entry.hpp"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

namespace livermark::results {
namespace {

EngineEntry sample_entry() {
    EngineProblem rest{.body = "liver_variant_12",
                       .load_case = "palpation",
                       .regime = "small",
                       .variant = 12,
                       .target_tetrahedra = 4000,
                       .tetrahedra = 4011,
                       .digest = "0123456789abcdef",
                       .relative_l2 = 0.175,
                       .stiffness_at_tool = -0.025,
                       .reference = "fem_p2p1_refined",
                       .reference_error = 1e-3,
                       .setup_seconds = 2.5};
    EngineProblem motion{.body = "beam",
                         .load_case = "press",
                         .kind = in_motion,
                         .outcome = failed_outcome,
                         .message = "motion.h5: \"force\" is missing;\nadd it"};
    return {.engine = "jelly",
            .version = "1.0",
            .url = "https://example.org/jelly",
            .machine = "a laptop, \xc2\xb5",
            .notes = "",
            .board = 3,
            .cannot = {"It has no tumours.", "It has no \\ either."},
            .settings = {{"substeps", 20}, {"damping", 0.5}, {"solver", {{"name", "pcg"}}}},
            .livermark = "0.1.0",
            .git_commit = "abc-dirty",
            .created = "2026-11-29T12:00:00Z",
            .problems = {rest, motion}};
}

std::string refusal_of(const std::string &text) {
    try {
        parse_engine_entry(text, "mine.json");
    } catch (const support::InputError &error) {
        return error.what();
    }
    return "";
}

TEST(EngineEntry, IsTheSameAfterItWasWrittenAndRead) {
    const auto entry = sample_entry();
    const auto text = engine_entry_text(entry);
    const auto again = parse_engine_entry(text, "mine.json");
    EXPECT_EQ(engine_entry_text(again), text);
    EXPECT_EQ(again.machine, entry.machine);
    EXPECT_EQ(again.cannot, entry.cannot);
    EXPECT_EQ(again.settings, entry.settings);
    ASSERT_EQ(again.problems.size(), 2U);
    EXPECT_EQ(again.problems[0].relative_l2, 0.175);
    EXPECT_EQ(again.problems[0].variant, 12);
    EXPECT_TRUE(std::isnan(again.problems[0].force));
    EXPECT_TRUE(again.problems[1].has_failed());
    EXPECT_EQ(again.problems[1].message, entry.problems[1].message);
}

TEST(EngineEntry, HasNullForWhatIsNotKnown) {
    EXPECT_NE(engine_entry_text(sample_entry()).find("\"memory_bytes\": null"), std::string::npos);
    EXPECT_EQ(engine_entry_text(sample_entry()).find("nan"), std::string::npos);
}

TEST(EngineEntry, HasATableWithSigns) {
    const auto text = to_text(engine_entry_table(sample_entry()));
    for (const auto *part : {"17.50", "-2.5", "4011", "failed", "2.50"})
        EXPECT_NE(text.find(part), std::string::npos) << part << '\n' << text;
    EXPECT_EQ(text.find("nan"), std::string::npos) << text;
}

TEST(EngineEntry, TakesTheEscapesOfJson) {
    const auto entry = parse_engine_entry(
        R"({"engine": "a\u00b5\ud83d\ude00\n\/", "version": "", "problems": [], "settings": {"x": null, "y": [true]}})",
        "mine.json");
    EXPECT_EQ(entry.engine, "a\xc2\xb5\xf0\x9f\x98\x80\n/");
    EXPECT_EQ(entry.settings.dump(), R"({"x":null,"y":[true]})");
}

TEST(EngineEntry, SaysWhatIsWrongAndWhere) {
    const std::string head = R"({"engine": "a", "version": "1", "problems": [)";
    const std::string problem = R"({"body": "b", "load_case": "c", "kind": "rest", "outcome": "ok")";
    EXPECT_EQ(refusal_of(head + problem + "}]}"), "");
    const auto expect = [](const std::string &text, const std::string &part) {
        EXPECT_NE(refusal_of(text).find(part), std::string::npos) << text << '\n' << refusal_of(text);
    };
    expect("", "mine.json: this is not JSON of an entry: parse error at line 1");
    expect("[]", "it is no object");
    expect("{\n\"engine\": \"a\"\n\"version\"", "at line 3, column 9");
    expect(R"({"engine": "a)", "missing closing quote");
    expect(R"({"engine": "\ud83d"})", "surrogate");
    expect(R"({"engine": 1, "version": "1", "problems": []})", "'engine' has to be a text");
    expect(R"({"engine": "a", "problems": []})", "'version' is missing");
    expect(R"({"engine": "a", "version": "1"})", "'problems' is missing");
    expect(R"({"engine": "a", "engine": "b"})", "twice");
    expect(R"({"engine": nan})", "invalid literal");
    expect(R"({"engine": "a", "version": "1", "problems": [], "score": 3})", "'score' is no key");
    expect(head + "3]}", "problem 1: 'problems'");
    expect(head + problem + R"(, "relative_l2": "x"}]})", "problem 1: 'relative_l2' has to be a number");
    expect(head + problem + R"(, "tetrahedra": -3}]})", "'tetrahedra' has to be a whole number");
    expect(head + R"({"body": "b", "load_case": "c", "kind": "rest", "outcome": "good"}]})",
           "neither ok, cannot nor failed");
    expect(head + problem + "}]} {}", "expected end of input");
    expect(R"({"settings": )" + std::string(100000, '['), "too deep");
}

TEST(EngineEntry, OfEachFileThatShipsCanBeReadAndWritten) {
    int num_files = 0;
    for (const auto &file : std::filesystem::directory_iterator(support::root_folder() / "results" / "engines")) {
        if (file.path().extension() != ".json")
            continue;
        const auto entry = read_engine_entry(file.path());
        EXPECT_EQ(entry.engine, file.path().stem().string());
        EXPECT_FALSE(entry.problems.empty()) << file.path();
        EXPECT_EQ(engine_entry_text(entry), support::read_text(file.path()))
            << file.path() << " was not written by `livermark score --entry`";
        ++num_files;
    }
    EXPECT_GT(num_files, 0);
}

} // namespace
} // namespace livermark::results
