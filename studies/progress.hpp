#pragma once

#include <algorithm>
#include <functional>
#include <string>

namespace livermark::studies {

/// Called before each step of long work: its number, from 1, how many steps there are, and what it is about.
using ProgressReport = std::function<void(int step, int num_steps, const std::string &about)>;

/// Numbers the steps of one piece of work.
class Steps {
  public:
    /// @param report  may be empty; it has to outlive this
    Steps(int num_steps, const ProgressReport &report) : num_steps_(num_steps), report_(report) {}

    /// Begins the next step.
    void next(const std::string &about) {
        ++step_;
        if (report_)
            report_(std::min(step_, num_steps_), num_steps_, about); // what is solved again is no step more
    }

  private:
    int num_steps_;
    int step_ = 0;
    const ProgressReport &report_;
};

} // namespace livermark::studies
