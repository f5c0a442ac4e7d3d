#pragma once

#include <cstdio>

namespace livermark::support {

/// While it lives, writing to standard error always succeeds: what nobody can read, because the terminal has gone, the
/// disk is full or the stream is closed, is dropped, and the work goes on.
class UnfailingStandardError {
  public:
    UnfailingStandardError();
    ~UnfailingStandardError();
    UnfailingStandardError(const UnfailingStandardError &) = delete;
    UnfailingStandardError &operator=(const UnfailingStandardError &) = delete;

  private:
    std::FILE *before_;
};

} // namespace livermark::support
