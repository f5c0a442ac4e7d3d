#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/own_process.hpp"
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

namespace livermark {
namespace {

namespace fs = std::filesystem;

constexpr double gibibyte = 1024.0 * 1024.0 * 1024.0;
constexpr const char *version_2 = "30 20 0:26 / /sys/fs/cgroup rw,nosuid - cgroup2 cgroup2 rw,nsdelegate\n";
constexpr const char *version_1 = "31 20 0:27 / /sys/fs/cgroup/memory rw,nosuid - cgroup cgroup rw,memory\n"
                                  "32 20 0:28 / /sys/fs/cgroup/cpu,cpuacct rw,nosuid - cgroup cgroup rw,cpu,cpuacct\n"
                                  "33 20 0:29 / /sys/fs/cgroup/unified rw,nosuid - cgroup2 cgroup2 rw\n";

int cores_of_machine() {
    return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

/// Files like those of the kernel.
class ShareOfMachine : public testing::Test {
  protected:
    ShareOfMachine() : root_(fs::path(testing::TempDir()) / ("livermark_share_" + std::to_string(getpid()))) {
        write("proc/meminfo", "MemTotal:       66060288 kB\nMemAvailable:   33554432 kB\n"); // 32 GiB
    }
    ~ShareOfMachine() override { fs::remove_all(root_); }
    ShareOfMachine(const ShareOfMachine &) = delete;
    ShareOfMachine &operator=(const ShareOfMachine &) = delete;

    void write(const std::string &file, const std::string &text) const {
        fs::create_directories((root_ / file).parent_path());
        std::ofstream(root_ / file) << text;
    }
    void mount(const std::string &mounts, const std::string &groups) const {
        write("proc/self/mountinfo", "22 1 0:20 / /proc rw - proc proc rw\n" + mounts);
        write("proc/self/cgroup", groups);
    }
    double gibibytes() const { return support::share_of_machine(root_).bytes / gibibyte; }
    int cores() const { return support::share_of_machine(root_).cores; }

    fs::path root_;
};

TEST_F(ShareOfMachine, IsAllThatIsFreeWithoutControlGroups) {
    EXPECT_EQ(gibibytes(), 32.0);
    EXPECT_EQ(cores(), cores_of_machine());
    fs::remove_all(root_ / "proc");
    EXPECT_TRUE(std::isinf(gibibytes()));
}

TEST_F(ShareOfMachine, IsWhatTheGroupHasLeftOfItsMemoryInVersion2) {
    mount(version_2, "0::/jobs/mine\n");
    write("sys/fs/cgroup/jobs/mine/memory.max", "4294967296\n");
    write("sys/fs/cgroup/jobs/mine/memory.current", "3221225472\n");
    EXPECT_EQ(gibibytes(), 1.0);
    // A cache of files goes when somebody needs the room.
    write("sys/fs/cgroup/jobs/mine/memory.stat", "anon 5\nactive_file 7\ninactive_file 2147483648\n");
    EXPECT_EQ(gibibytes(), 3.0);
    write("sys/fs/cgroup/jobs/mine/memory.high", "3221225472\n"); // from there on the group is slowed down
    EXPECT_EQ(gibibytes(), 2.0);
    write("sys/fs/cgroup/jobs/mine/memory.high", "max\n");
    write("sys/fs/cgroup/jobs/mine/memory.max", "max\n");
    EXPECT_EQ(gibibytes(), 32.0);
    // A group above has the last word.
    write("sys/fs/cgroup/jobs/memory.max", "536870912\n");
    EXPECT_EQ(gibibytes(), 0.5);
    write("sys/fs/cgroup/jobs/memory.current", "1536870912\n");
    EXPECT_EQ(gibibytes(), 0.0);
}

TEST_F(ShareOfMachine, IsWhatTheGroupHasLeftOfItsMemoryInVersion1) {
    mount(version_1, "9:name=systemd:/\n4:memory:/docker/12ab\n1:cpu,cpuacct:/docker/12ab\n0::/\n");
    const std::string group = "sys/fs/cgroup/memory/docker/12ab/";
    write(group + "memory.limit_in_bytes", "9223372036854771712\n"); // none
    EXPECT_EQ(gibibytes(), 32.0);
    write(group + "memory.limit_in_bytes", "2147483648\n");
    write(group + "memory.usage_in_bytes", "1610612736\n");
    write(group + "memory.stat", "inactive_file 1\ntotal_inactive_file 1073741824\n");
    EXPECT_EQ(gibibytes(), 1.5);
}

TEST_F(ShareOfMachine, IsSeenInAContainerThatSeesItsOwnGroupAlone) {
    mount("31 20 0:27 /docker/12ab /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n", "4:memory:/docker/12ab\n");
    write("sys/fs/cgroup/memory/memory.limit_in_bytes", "1073741824\n");
    EXPECT_EQ(gibibytes(), 1.0);
    mount(version_2, "0::/../../elsewhere\n"); // of another name space
    write("sys/fs/cgroup/memory.max", "2147483648\n");
    EXPECT_EQ(gibibytes(), 2.0);
}

TEST_F(ShareOfMachine, HasWholeCoresOfAQuota) {
    mount(version_2, "0::/jobs/mine\n");
    write("sys/fs/cgroup/jobs/mine/cpu.max", "max 100000\n");
    EXPECT_EQ(cores(), cores_of_machine());
    write("sys/fs/cgroup/jobs/cpu.max", "190000 100000\n");
    EXPECT_EQ(cores(), 1);
    write("sys/fs/cgroup/jobs/cpu.max", "50000 100000\n");
    EXPECT_EQ(cores(), 1);
    write("sys/fs/cgroup/jobs/cpu.max", "900000000 100000\n");
    EXPECT_EQ(cores(), cores_of_machine());
    fs::remove_all(root_ / "sys");
    mount(version_1, "1:cpu,cpuacct:/docker/12ab\n");
    write("sys/fs/cgroup/cpu,cpuacct/docker/12ab/cpu.cfs_period_us", "100000\n");
    write("sys/fs/cgroup/cpu,cpuacct/docker/12ab/cpu.cfs_quota_us", "-1\n");
    EXPECT_EQ(cores(), cores_of_machine());
    write("sys/fs/cgroup/cpu,cpuacct/docker/12ab/cpu.cfs_quota_us", "100000\n");
    EXPECT_EQ(cores(), 1);
}

TEST_F(ShareOfMachine, SaysHowManyWorkersFit) {
    EXPECT_EQ(support::workers_that_fit(1e30), 1);
    EXPECT_EQ(support::workers_that_fit(1.0), support::share_of_machine().cores);
    EXPECT_EQ(support::workers_that_fit(2.0, {.cores = 16, .bytes = 9.0}), 4);
    EXPECT_EQ(support::workers_that_fit(2.0, {.cores = 3, .bytes = 9.0}), 3);
    EXPECT_EQ(support::workers_that_fit(2.0, {.cores = 3, .bytes = 0.0}), 1);
}

} // namespace
} // namespace livermark
