/// Tests that take minutes and have siblings which would find the same faults take turns, a day each.
#pragma once

#include <chrono>
#include <cstdlib>

namespace livermark::tests {

/// Whether number `index` of `num_turns` runs today (UTC). All do where the environment has LIVERMARK_EVERY_TURN.
inline bool has_its_turn(int index, int num_turns) {
    const auto days = std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now()).time_since_epoch();
    return std::getenv("LIVERMARK_EVERY_TURN") != nullptr || days.count() % num_turns == index;
}

constexpr const char *not_its_turn = "runs on another day; LIVERMARK_EVERY_TURN=1 runs it today";

} // namespace livermark::tests
