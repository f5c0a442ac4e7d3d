#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace livermark::studies {

/// Called before each step of long work: its number, from 1, how many steps there are, and what it is about.
using ProgressReport = std::function<void(int step, int num_steps, const std::string &about)>;

/// Numbers the steps of one piece of work.
class Steps {
  public:
    /// @param report  may be empty; it has to outlive this
    Steps(int num_steps, const ProgressReport &report) : num_steps_(num_steps), report_(report) {}

    /// Begins the next step.
    void next(const std::string &about);

  private:
    int num_steps_;
    int step_ = 0;
    const ProgressReport &report_;
};

/// A clock that is in one of several stages of the work, or stands still.
class TimeSpent {
  public:
    /// Ends the stage that it was in, if any. A stage that comes again goes on where it was.
    void begin(const std::string &stage);

    /// Ends the stage that it is in, if any, and begins no other.
    void stop();

    /// Adds what another clock measured [s].
    void add(const std::string &stage, double seconds);
    void add(const TimeSpent &other);

    /// In the order in which they began; with what they took [s], each when it has ended.
    const std::vector<std::pair<std::string, double>> &stages() const { return stages_; }

    /// A sentence, then a line for each stage that took a hundredth of the time or more, the longest first.
    std::string text() const;

  private:
    using Clock = std::chrono::steady_clock;

    std::vector<std::pair<std::string, double>> stages_; ///< [s]
    std::string current_;
    bool is_running_ = false;
    Clock::time_point start_;
};

} // namespace livermark::studies
