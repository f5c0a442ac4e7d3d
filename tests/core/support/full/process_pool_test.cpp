#include "core/support/processes/process_pool.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <functional>
#include <map>
#include <new>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>

#include "core/support/input_error.hpp"
#include "tests/bad_input.hpp"

namespace livermark {
namespace {

/// @return shape (I) the process that did each item
std::vector<std::string> processes(const std::vector<int> &group, int num_workers) {
    std::vector<std::string> process(group.size());
    support::run_in_process_pool(
        group, num_workers, [](int, const support::SendMessage &tell) { tell(std::to_string(getpid())); },
        [&](int item, const std::string &text) {
            EXPECT_TRUE(process[item].empty()) << "item " << item << " is done twice";
            process[item] = text;
        });
    return process;
}

TEST(SideBySide, DoesEachItemOnce) {
    const std::vector<int> group{0, 0, 2, 0, 2, 2, 1, 0, 2};
    for (const int num_workers : {1, 2, 3, 40})
        for (const auto &process : processes(group, num_workers))
            EXPECT_FALSE(process.empty());
    EXPECT_TRUE(processes({}, 2).empty());
}

TEST(SideBySide, OneWorkerGoesGroupByGroupInThisProcess) {
    const std::vector<int> group{1, 0, 1, 0};
    std::vector<int> order;
    support::run_in_process_pool(group, 1, [&](int item, const support::SendMessage &) { order.push_back(item); }, {});
    EXPECT_EQ(order, (std::vector<int>{1, 3, 0, 2}));
}

TEST(SideBySide, WorkersBeginGroupsOfTheirOwnAndThenHelp) {
    const auto two_groups = processes({0, 0, 0, 1, 1, 1}, 2);
    EXPECT_NE(two_groups[0], two_groups[3]);
    EXPECT_NE(two_groups[0], std::to_string(getpid()));
    const auto one_group = processes({0, 0}, 2);
    EXPECT_NE(one_group[0], one_group[1]);
}

/// An item of the last group has to see what those have left that it waits for; one of them waits for nobody.
TEST(SideBySide, ItemsWaitForOthers) {
    const std::vector<int> group{0, 0, 1, 2, 3, 3, 3};
    const std::vector<std::vector<int>> waits_for{{}, {}, {}, {}, {0, 1, 2}, {1}};
    for (const int num_workers : {1, 2, 3, 7}) {
        std::vector<int> begun, done;
        support::run_in_process_pool(
            group, num_workers,
            [](int item, const support::SendMessage &tell) {
                tell("begun");
                std::this_thread::sleep_for(std::chrono::milliseconds(item < 3 ? 20 : 0));
                tell("done");
            },
            [&](int item, const std::string &text) { (text == "begun" ? begun : done).push_back(item); }, waits_for);
        ASSERT_EQ(done.size(), group.size()) << num_workers;
        std::ranges::sort(begun);
        EXPECT_EQ(begun, (std::vector{0, 1, 2, 3, 4, 5, 6}));
        for (std::size_t first = 0; first < done.size(); ++first)
            for (std::size_t second = first + 1; second < done.size(); ++second)
                EXPECT_FALSE(static_cast<std::size_t>(done[first]) < waits_for.size() &&
                             std::ranges::count(waits_for[done[first]], done[second]) > 0)
                    << num_workers;
    }
}

TEST(SideBySide, TextsComeInTheirOrderAndWhole) {
    const std::vector<int> group{0, 1, 2};
    const std::string large(300'000, 'x'); // more than a pipe holds
    std::vector<std::vector<std::string>> told(group.size());
    support::run_in_process_pool(
        group, 3,
        [&](int item, const support::SendMessage &tell) {
            tell("");
            tell(large + std::to_string(item));
            tell("end");
        },
        [&](int item, const std::string &text) { told[item].push_back(text); });
    for (std::size_t item = 0; item < group.size(); ++item)
        EXPECT_EQ(told[item], (std::vector<std::string>{"", large + std::to_string(item), "end"}));
}

/// @return what the message is if the fourth item of many ends like this
template <class Fault> std::string message(int num_workers, const std::function<void()> &fault) {
    try {
        support::run_in_process_pool(std::vector<int>(50, 0), num_workers,
                                     [&](int item, const support::SendMessage &) {
                                         if (item == 3)
                                             fault();
                                     },
                                     {});
    } catch (const Fault &error) {
        return error.what();
    }
    return "no fault";
}

TEST(SideBySide, AFaultEndsTheWork) {
    for (const int num_workers : {1, 2}) {
        EXPECT_EQ(message<support::InputError>(num_workers, [] { throw support::InputError("no room"); }), "no room");
        EXPECT_EQ(message<std::runtime_error>(num_workers, [] { throw std::range_error("wrong"); }), "wrong");
    }
}

TEST(SideBySide, AWorkerThatIsKilledIsMissed) {
    const auto text = message<std::runtime_error>(2, [] { std::raise(SIGKILL); });
    tests::expect_part(text, "a worker ended before its work did (Killed), on item ");
}

/// The fourth of twelve items ends its process and the eighth finds no memory; the last one waits for both.
TEST(SideBySide, ALostWorkerCostsItsItemAlone) {
    const std::vector<int> group{0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 3};
    std::vector<std::vector<int>> waits_for(group.size());
    waits_for.back() = {3, 7};
    for (const int num_workers : {1, 2, 3}) {
        SCOPED_TRACE(num_workers);
        std::vector<int> done;
        std::map<int, std::string> lost;
        support::run_in_process_pool(
            group, num_workers,
            [&](int item, const support::SendMessage &tell) {
                if (item == 3 && num_workers > 1)
                    std::raise(SIGKILL);
                if (item == 7)
                    throw std::bad_alloc();
                tell("done");
            },
            [&](int item, const std::string &) {
                done.push_back(item);
                EXPECT_TRUE(item != 11 || lost.contains(7)) << "it has to wait";
            },
            waits_for, [&](int item, const std::string &how) { EXPECT_TRUE(lost.emplace(item, how).second); });
        std::map<int, std::string> expected{{7, "out of memory"}};
        if (num_workers > 1)
            expected.emplace(3, "Killed");
        EXPECT_EQ(lost, expected);
        EXPECT_EQ(done.size() + lost.size(), group.size());
        EXPECT_NE(std::ranges::find(done, 11), done.end());
    }
}

TEST(SideBySide, GoesOnWhereEveryItemEndsItsProcess) {
    int num_lost = 0;
    support::run_in_process_pool(
        std::vector<int>(20, 0), 3, [](int, const support::SendMessage &) { std::raise(SIGSEGV); }, {}, {},
        [&](int, const std::string &how) {
            EXPECT_EQ(how, "Segmentation fault");
            ++num_lost;
        });
    EXPECT_EQ(num_lost, 20);
}

} // namespace
} // namespace livermark
