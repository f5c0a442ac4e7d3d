#include "results/records/needle.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include "core/support/input_error.hpp"
#include "results/hdf5/result_file.hpp"
#include "results/records/result.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_needles.hpp"

namespace livermark::results {
namespace {

using NeedleFiles = tests::ResultFolder;

TEST_F(NeedleFiles, HoldWhatWasWritten) {
    auto written = tests::sample_needles();
    written.provenance = current_provenance("livermark needle");
    write_needles(path_, written);
    EXPECT_EQ(kind_of_file(path_), FileKind::needle);
    const auto read = read_needles_file(path_);
    EXPECT_EQ(read.provenance, written.provenance);
    EXPECT_EQ(read.load_case, "biopsy");
    ASSERT_EQ(read.needles.size(), 1U);
    const auto &study = read.needles.front(), &expected = written.needles.front();
    EXPECT_EQ(study.needle.target, expected.needle.target);
    EXPECT_EQ(study.needle.friction, 20.0);
    EXPECT_EQ(study.reference_force_change, 0.004);
    ASSERT_EQ(study.runs.size(), 2U);
    EXPECT_EQ(study.runs[0].model, "judge");
    EXPECT_EQ(study.runs[1].insertion.force, expected.runs[1].insertion.force);
    EXPECT_EQ(study.runs[1].insertion.target, expected.runs[1].insertion.target);
    EXPECT_EQ(study.runs[1].insertion.holding, expected.runs[1].insertion.holding);
    EXPECT_EQ(study.runs[1].insertion.puncture_depth, 0.01);
    EXPECT_EQ(study.runs[1].insertion.at_plan, 2);
    EXPECT_EQ(study.runs[1].insertion.stopped_at, 0.005);
    EXPECT_EQ(study.runs[1].solve_seconds, 7.0);
    EXPECT_EQ(read.regime, core::Regime::large);
}

TEST_F(NeedleFiles, AreRefusedWhereTheyCannotBe) {
    EXPECT_THROW(read_needles_file(directory_ / "none.h5"), support::InputError);
    auto wrong = tests::sample_needles();
    wrong.needles[0].runs[1].insertion.at_plan = 1;
    write_needles(path_, wrong);
    EXPECT_THROW(read_needles_file(path_), support::InputError);
    wrong = tests::sample_needles();
    wrong.needles[0].runs[0].insertion.force.pop_back();
    write_needles(path_, wrong);
    EXPECT_THROW(read_needles_file(path_), support::InputError);
}

/// Files of before what holding loses was written.
TEST_F(NeedleFiles, OfOlderVersionsAreRead) {
    write_needles(path_, tests::sample_needles());
    const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    for (const char *model : {"judge", "springs"})
        EXPECT_GE(H5Ldelete(file, fmt::format("/needles/0/models/{}/holding", model).c_str(), H5P_DEFAULT), 0);
    EXPECT_GE(H5Adelete(file, "regime"), 0);
    H5Fclose(file);
    const auto read = read_needles_file(path_);
    EXPECT_TRUE(read.needles.front().runs[1].insertion.holding.empty());
    EXPECT_EQ(read.needles.front().runs[1].insertion.tearing.size(), 5U);
    EXPECT_EQ(read.regime, core::Regime::small);
}

TEST_F(NeedleFiles, HoldAnArenaAlso) {
    auto written = tests::sample_needles();
    write_needles(path_, written);
    const auto arena = read_needles_file(path_).needles.front().arena, &expected = written.needles.front().arena;
    ASSERT_TRUE(arena.has_value());
    EXPECT_EQ(arena->runs, expected->runs);
    EXPECT_EQ(arena->left_out, expected->left_out);
    EXPECT_EQ(arena->depth, expected->depth);
    EXPECT_EQ(arena->at_plan, 2);
    EXPECT_EQ(arena->reference_forces, expected->reference_forces);
    EXPECT_EQ(arena->reference_changes, expected->reference_changes);
    EXPECT_EQ(arena->reference_target, expected->reference_target);

    written.needles.front().arena.reset(); // of `livermark needle`
    write_needles(path_, written);
    EXPECT_FALSE(read_needles_file(path_).needles.front().arena.has_value());

    written.needles.front().arena = tests::sample_needle_arena();
    written.needles.front().arena->at_plan = 5;
    write_needles(path_, written);
    EXPECT_THROW(read_needles_file(path_), support::InputError);
}

TEST_F(NeedleFiles, HaveATableOfMethodsUnderANeedle) {
    const auto study = tests::sample_needles().needles.front();
    const auto table = needle_arena_table(*study.arena);
    ASSERT_EQ(table.rows.size(), 2U);
    EXPECT_EQ(table.rows[0], (std::vector<std::string>{"100", "10.00", "iterations", "stable", "12", "1", "1.00",
                                                       "10.0", "2.200 (+10.0)", "110.0 (+10.0)", "0.600 (+20.0)",
                                                       "2.00", "4.00", "1.05", "ok"}));
    EXPECT_EQ(table.rows[1][2], "springs") << "the better target first";
    EXPECT_NE(needle_arena_note(study).find("left out: heavy, because its masses are scaled"), std::string::npos);
    EXPECT_NE(needle_arena_note(study).find("a peak of 2.000 N (0.0100 N)"), std::string::npos);
}

TEST_F(NeedleFiles, HaveATableOfWhereTheTargetIs) {
    const auto table = needle_table(tests::sample_needles());
    ASSERT_EQ(table.rows.size(), 2U);
    EXPECT_EQ(table.rows[0], (std::vector<std::string>{"to tumour 1", "judge (reference)", "5.00", "-", "4.00", "2.000",
                                                       "2.000", "-", "0.500", "-"}));
    EXPECT_EQ(table.rows[1], (std::vector<std::string>{"to tumour 1", "springs", "5.00", "0.00", "4.00", "2.200",
                                                       "2.200", "10.0", "0.550", "10.0"}));
    EXPECT_NE(needle_note(tests::sample_needles()).find("0.010 mm"), std::string::npos);
    EXPECT_NE(
        needle_note(tests::sample_needles()).find("springs finds no equilibrium with the tip at a depth of 5.0 mm"),
        std::string::npos);
}

TEST_F(NeedleFiles, SayWhereTheSmallRegimeIsLeft) {
    auto file = tests::sample_needles();
    EXPECT_EQ(needle_note(file).find("small regime"), std::string::npos);
    auto &run = file.needles.front().runs.back();
    run.insertion.moved = {0.0, 0.004, 0.009, 0.02, 0.02};
    run.note_limit(0.009);
    EXPECT_TRUE(std::isnan(run.left_regime_at)) << "on the way out it is too late";
    run.note_limit(0.003);
    EXPECT_EQ(run.left_regime_at, 0.01);
    EXPECT_NE(needle_note(file).find("to tumour 1: small regime left at 10.0 mm (springs)"), std::string::npos);
    EXPECT_NE(needle_note(file).find("use --regime large"), std::string::npos);
}

/// The force that the surface bears until it gives way is between two records.
TEST_F(NeedleFiles, HaveALargestForceNotBelowThatOfThePuncture) {
    const auto study = tests::sample_needles().needles.front();
    auto needle = study.needle;
    needle.puncture_force = 3.5;
    EXPECT_EQ(study.runs[0].largest_force(needle), 2.0) << "its surface holds";
    EXPECT_EQ(study.runs[1].largest_force(needle), 3.5);
    needle.puncture_force = 0.2;
    EXPECT_EQ(study.runs[1].largest_force(needle), 2.2);
}

TEST_F(NeedleFiles, SayWhoseWorkIsOutOfBalance) {
    auto file = tests::sample_needles();
    EXPECT_EQ(needle_note(file).find("miss"), std::string::npos);
    file.needles.front().runs.front().insertion.stored[2] += 0.02; // of 0.2 J
    EXPECT_NE(needle_note(file).find("energies of judge miss"), std::string::npos) << needle_note(file);
}

} // namespace
} // namespace livermark::results
