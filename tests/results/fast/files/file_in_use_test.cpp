#include <array>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <string>
#include <sys/file.h>
#include <unistd.h>

#include "results/hdf5/result_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

class FileInUseElsewhere : public tests::ResultFolder {
  protected:
    void SetUp() override {
        ResultFolder::SetUp();
        write_result(path_, tests::sample_result());
        // Locks belong to what open() gives, so this one is another's.
        file_ = open(path_.c_str(), O_RDWR | O_CLOEXEC);
        ASSERT_EQ(flock(file_, LOCK_EX), 0);
    }
    void TearDown() override {
        close(file_);
        ResultFolder::TearDown();
    }
    int file_ = -1;
};

TEST_F(FileInUseElsewhere, IsNotCalledDamaged) {
    tests::expect_input_error([&] { read_result(path_); },
                              {path_.string(), "another program has the file open to write", "wait for it"});
    EXPECT_THROW(kind_of_file(path_), FileInUse);
    EXPECT_THROW(is_shown_on_page(path_), FileInUse) << "nobody can say whether it is one";
}

TEST_F(FileInUseElsewhere, IsNotMissingInItsFolder) {
    testing::internal::CaptureStderr();
    tests::expect_input_error([&] { read_results(std::array{directory_}); },
                              {"no result file here can be read", "the reasons stand above"});
    EXPECT_NE(testing::internal::GetCapturedStderr().find("another program has the file open"), std::string::npos);
}

TEST_F(FileInUseElsewhere, IsReadOnceItIsClosed) {
    flock(file_, LOCK_UN);
    EXPECT_TRUE(is_shown_on_page(path_));
    EXPECT_EQ(read_results(std::array{directory_}).size(), 1U);
}

} // namespace
} // namespace livermark::results
