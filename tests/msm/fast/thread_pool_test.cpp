#include <atomic>
#include <csignal>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include "msm/kernels/thread_pool.hpp"

namespace livermark {
namespace {

int sum_of_numbers(msm::ThreadPool &pool) {
    std::atomic<int> sum = 0;
    pool.run([&](int thread, msm::Barrier &barrier) {
        sum += thread;
        barrier.wait();
        sum += 100;
    });
    return sum;
}

class ThreadPools : public testing::TestWithParam<int> {};

TEST_P(ThreadPools, WorkInAProcessThatWasForkedBetweenTwoRuns) {
    const int size = GetParam(), expected = 100 * size + size * (size - 1) / 2;
    msm::ThreadPool pool(size);
    EXPECT_EQ(sum_of_numbers(pool), expected);
    const auto child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        alarm(60); // ends what waits for threads that are not there
        bool is_right = true;
        for (int run = 0; run < 100; ++run)
            is_right = is_right && sum_of_numbers(pool) == expected;
        { msm::ThreadPool another(size); }
        _exit(is_right ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status)) << strsignal(WTERMSIG(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_EQ(sum_of_numbers(pool), expected);
}

TEST_P(ThreadPools, EndInAProcessThatWasForkedWhileTheyRan) {
    auto pool = std::make_unique<msm::ThreadPool>(GetParam());
    std::atomic<pid_t> child = 0;
    pool->run([&](int thread, msm::Barrier &) {
        if (thread == 0)
            child = fork();
        if (child == 0 && thread == 0) { // the other threads are not there
            alarm(60);
            pool.reset();
            _exit(0);
        }
    });
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status)) << strsignal(WTERMSIG(status));
}

INSTANTIATE_TEST_SUITE_P(Sizes, ThreadPools, testing::Values(1, 2, 5));

} // namespace
} // namespace livermark

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
