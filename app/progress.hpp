#pragma once

#include <string>

namespace livermark::app {

/// Says on standard error how far long work is: on a terminal a line that is overwritten, elsewhere a plain line per
/// step.
class Progress {
  public:
    explicit Progress(int num_steps);
    ~Progress();
    Progress(const Progress &) = delete;
    Progress &operator=(const Progress &) = delete;

    /// Begins the next step.
    void next(const std::string &what);

  private:
    int num_steps_;
    int step_ = 0;
    bool is_terminal_;
};

} // namespace livermark::app
