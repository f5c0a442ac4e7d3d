#include <array>
#include <csignal>
#include <memory>
#include <sys/wait.h>
#include <unistd.h>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

namespace livermark::support {
namespace {

/// Whether another process gets a file.
bool another_gets(const std::filesystem::path &file) {
    const int child = fork();
    if (child == 0) {
        int status = 0;
        try {
            const FileClaim claim(file);
        } catch (const InputError &) {
            status = 1;
        }
        _exit(status);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Another process that has claimed a file, until it is killed.
class Claimant {
  public:
    explicit Claimant(const std::filesystem::path &file) {
        std::array<int, 2> ready{};
        EXPECT_EQ(pipe(ready.data()), 0);
        child_ = fork();
        if (child_ == 0) {
            const FileClaim claim(file);
            const char done = 1;
            if (write(ready[1], &done, 1) == 1)
                pause();
            _exit(0);
        }
        char done = 0;
        EXPECT_EQ(read(ready[0], &done, 1), 1);
        close(ready[0]);
        close(ready[1]);
    }
    ~Claimant() { kill_it(); }
    Claimant(const Claimant &) = delete;
    Claimant &operator=(const Claimant &) = delete;

    int number() const { return child_; }
    void kill_it() {
        if (child_ <= 0)
            return;
        kill(child_, SIGKILL);
        waitpid(child_, nullptr, 0);
        child_ = 0;
    }

  private:
    int child_ = 0;
};

using FileClaims = tests::ResultFolder;

TEST_F(FileClaims, KeepOtherProcessesFromOneFileAndNotFromOthers) {
    auto claim = std::make_unique<FileClaim>(path_);
    EXPECT_FALSE(another_gets(path_));
    EXPECT_TRUE(another_gets(directory_ / "other.h5"));
    EXPECT_FALSE(another_gets(path_)) << "given back with the other";
    auto second = std::make_unique<FileClaim>(directory_ / "other.h5");
    claim.reset();
    EXPECT_TRUE(another_gets(path_));
    EXPECT_FALSE(another_gets(directory_ / "other.h5"));
    second.reset();
    EXPECT_TRUE(files().empty()) << "something was left in the folder";
}

TEST_F(FileClaims, NameTheProcessThatHasTheFileAndEndWithIt) {
    Claimant other(path_);
    tests::expect_input_error([&] { const FileClaim refused(path_); },
                              {path_.string(), fmt::format("(process {})", other.number()), "wait for its end"});
    const FileClaim claim_of_another(directory_ / "other.h5");
    other.kill_it();
    const FileClaim mine(path_);
    EXPECT_FALSE(another_gets(path_));
}

TEST_F(FileClaims, AreNoneWhereThereIsNoFolder) {
    const FileClaim nowhere(directory_ / "none" / "result.h5");
    EXPECT_TRUE(files().empty());
}

} // namespace
} // namespace livermark::support
