#include "support/processes/own_process.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "support/input_error.hpp"
#include "support/packed_bytes.hpp"
#include "tests/result_folder.hpp"

namespace livermark::support {
namespace {

/// A value that is worked out, so that no compiler leaves the work away.
volatile double spun = 0.0;

class OwnProcess : public tests::ResultFolder {
  protected:
    void SetUp() override {
        ResultFolder::SetUp();
        file_ = directory_ / "input.bin";
        std::ofstream(file_) << "input";
    }

    /// The sentence that it ends in.
    std::string refusal(const std::function<std::string()> &work, const ReaderLimits &limits = {}) const {
        try {
            in_own_process(file_, limits, work);
        } catch (const InputError &error) {
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
            return error.what();
        }
        return "none";
    }

    std::filesystem::path file_;
};

TEST_F(OwnProcess, SendsBackWhatTheWorkReturns) {
    const std::string large(5'000'000, 'x');
    int here = 0;
    EXPECT_EQ(in_own_process(file_, {},
                             [&] {
                                 ++here;
                                 return large;
                             }),
              large);
    EXPECT_EQ(here, 0) << "what the work does is not seen here";
}

TEST_F(OwnProcess, PassesRefusalsOnAsTheyAre) {
    EXPECT_EQ(refusal([]() -> std::string { throw InputError("input.bin: no liver"); }), "input.bin: no liver");
}

TEST_F(OwnProcess, SaysWhichFileEndedALibrary) {
    for (const int signal : {SIGSEGV, SIGABRT, SIGFPE}) {
        const auto text = refusal([signal]() -> std::string {
            std::raise(signal);
            return {};
        });
        EXPECT_NE(text.find("input.bin: it cannot be read (a library has broken off with "), std::string::npos) << text;
        EXPECT_NE(text.find("export it again"), std::string::npos) << text;
    }
    const auto text = refusal([]() -> std::string { throw std::runtime_error("in words\nfor programmers"); });
    EXPECT_NE(text.find("(in words)"), std::string::npos) << text;
}

TEST_F(OwnProcess, EndsWhatTakesTooLong) {
    const auto text = refusal(
        []() -> std::string {
            for (;;)
                spun = spun + 1.0;
        },
        {.seconds = 1});
    EXPECT_NE(text.find("it takes more than 1 s"), std::string::npos) << text;
}

#ifndef __SANITIZE_ADDRESS__
TEST_F(OwnProcess, EndsWhatTakesTooMuchMemory) {
    const auto text = refusal(
        [] {
            std::vector<char> much(std::size_t{1} << 30, 'x');
            return std::string(much.begin(), much.begin() + 10);
        },
        {.bytes = std::uint64_t{1} << 28});
    EXPECT_NE(text.find("it takes more than 256 MB of memory"), std::string::npos) << text;
}
#endif

TEST_F(OwnProcess, HasLimitsThatGrowWithTheFile) {
    const auto small = limits_for(file_, 1000.0);
    std::ofstream(file_) << std::string(3'000'000, 'x');
    const auto large = limits_for(file_, 1000.0), folder = limits_for(directory_, 1000.0);
    EXPECT_GT(large.seconds, small.seconds);
    EXPECT_GT(large.bytes, small.bytes);
    EXPECT_EQ(folder.bytes, large.bytes);
    EXPECT_LE(limits_for(file_, 1e9).bytes, std::uint64_t{16} << 30);
}

TEST(PackedBytes, ComeBackAsTheyWere) {
    Packer packer;
    packer.put(std::string("liver"));
    packer.put(std::vector<std::string>{"a", "", "b"});
    packer.put(std::vector<double>{1.5, -2.0});
    packer.put(7);
    const auto bytes = std::move(packer).bytes();
    Unpacker unpacker(bytes);
    std::string text;
    std::vector<std::string> texts;
    std::vector<double> numbers;
    int number = 0;
    unpacker.get(text);
    unpacker.get(texts);
    unpacker.get(numbers);
    unpacker.get(number);
    EXPECT_EQ(text, "liver");
    EXPECT_EQ(texts, (std::vector<std::string>{"a", "", "b"}));
    EXPECT_EQ(numbers, (std::vector<double>{1.5, -2.0}));
    EXPECT_EQ(number, 7);
    EXPECT_THROW(unpacker.get(number), std::runtime_error);
}

} // namespace
} // namespace livermark::support
