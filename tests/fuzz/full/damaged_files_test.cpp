#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <set>
#include <string>

#include "tests/fuzz/attempts.hpp"
#include "tests/fuzz/mutations.hpp"
#include "tests/fuzz/seed_files.hpp"
#include "tests/result_folder.hpp"

namespace livermark::tests {
namespace {

/// So that all take less than a minute; scripts/fuzz tries more.
constexpr std::uint64_t num_by_program = 4;

/// Fewer surfaces than others: what is open is wrapped, which takes a second.
std::uint64_t num_by_reader(const std::string &kind) {
    return kind == "stl" || kind == "ply" || kind == "obj_off" ? 25 : 80;
}

void expect_ends(const Attempts &attempts) {
    EXPECT_EQ(attempts.num_read + attempts.num_refused, attempts.num_tried);
    EXPECT_TRUE(attempts.faults.empty()) << fmt::format("{}", fmt::join(attempts.faults, "\n"));
}

class DamagedFiles : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        folder_ =
            std::filesystem::path(testing::TempDir()) / fmt::format("livermark_damaged_{}_{}", GetParam(), getpid());
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path folder_;
};

TEST_P(DamagedFiles, AreReadOrRefusedInASentence) {
    const Readers readers(GetParam(), folder_);
    auto attempts = readers.try_seeds();
    for (std::uint64_t number = 0; number < num_by_reader(GetParam()); ++number)
        attempts.add(readers.try_reader(number));
    expect_ends(attempts);
    // The damage is neither nothing nor everything.
    EXPECT_GT(attempts.num_read, 2);
    EXPECT_GT(attempts.num_refused, 8);
}

TEST_P(DamagedFiles, EndTheProgramWithAStatusAndLeaveNothing) {
    const Readers readers(GetParam(), folder_);
    Attempts attempts;
    for (std::uint64_t number = 0; number < num_by_program; ++number)
        attempts.add(readers.try_program(number));
    expect_ends(attempts);
}

INSTANTIATE_TEST_SUITE_P(EachKind, DamagedFiles, testing::ValuesIn(kinds_to_try()),
                         [](const auto &info) { return info.param; });

/// Values of https://burtleburtle.net/bob/c/lookup3.c.
TEST(Lookup3, IsThatOfItsAuthor) {
    EXPECT_EQ(fuzz::lookup3(""), 0xdeadbeefU);
    EXPECT_EQ(fuzz::lookup3("", 0xdeadbeef), 0xbd5b7ddeU);
    EXPECT_EQ(fuzz::lookup3("Four score and seven years ago", 0), 0x17770551U);
    EXPECT_EQ(fuzz::lookup3("Four score and seven years ago", 1), 0xcd628161U);
}

TEST(Damage, IsTheSameForTheSameNumber) {
    for (const auto &kind : fuzz::kinds_of_seeds()) {
        std::set<std::string> different;
        for (const auto &seed : fuzz::seeds_of(kind))
            for (std::uint64_t number = 0; number < 50; ++number) {
                const auto once = fuzz::damaged(kind, seed.bytes, number);
                EXPECT_EQ(once, fuzz::damaged(kind, seed.bytes, number));
                different.insert(once);
            }
        EXPECT_GT(different.size(), 50U) << kind;
    }
}

} // namespace
} // namespace livermark::tests
