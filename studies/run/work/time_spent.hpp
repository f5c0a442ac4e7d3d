#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace livermark::studies {

/// The stage of all that is not done by a model.
inline constexpr auto other_work = "loads, comparisons, files";

/// Where the time goes: a clock that is always in one of several stages.
class TimeSpent {
  public:
    /// Ends the stage that it was in, if any. A stage that comes again goes on where it was.
    void begin(const std::string &stage);

    /// Ends the stage that it is in, if any, and begins no other.
    void stop();

    /// Adds what another clock measured.
    void add(const std::string &stage, double seconds);

    /// In the order in which they began; with what they took [s]. The clock stops.
    const std::vector<std::pair<std::string, double>> &stages();

    /// A sentence, then a line for each stage that took a hundredth of the time or more, the longest first. The clock
    /// stops.
    std::string text();

  private:
    using Clock = std::chrono::steady_clock;

    std::vector<std::pair<std::string, double>> stages_; ///< [s]
    std::string current_;
    bool is_running_ = false;
    Clock::time_point start_;
};

} // namespace livermark::studies
