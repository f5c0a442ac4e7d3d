#include "msm/kernels/threads/thread_pool.hpp"

#include <atomic>
#include <csignal>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

namespace livermark::msm {
namespace {

TEST(ThreadPool, DoesItsWorkOnceInEachThread) {
    ThreadPool pool(3);
    for (int round = 0; round < 100; ++round) {
        std::atomic<int> sum = 0;
        pool.run([&](int thread, Barrier &) { sum += 1 + thread; });
        ASSERT_EQ(sum, 6);
    }
}

#ifndef __SANITIZE_ADDRESS__
/// In a process of its own, whose memory is not enough for the stacks of so many.
TEST(ThreadPool, SaysWhenThereAreNoMoreThreads) {
    const pid_t child = fork();
    if (child == 0) {
        alarm(30);
        std::uint64_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        const auto room = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + (std::uint64_t{100} << 20);
        const rlimit limit{room, room};
        setrlimit(RLIMIT_AS, &limit);
        try {
            const ThreadPool pool(500);
        } catch (const std::system_error &) {
            _exit(3);
        }
        _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status)) << "it waited for threads that are told nothing";
    EXPECT_EQ(WEXITSTATUS(status), 3);
}
#endif

} // namespace
} // namespace livermark::msm
