#pragma once

#include <string>

#include "support/processes/child_process.hpp"

namespace livermark::cli {

/// Whether somebody sits in front of this: standard output is a terminal, and there is a screen.
bool has_screen();

/// Shows an address in the browser of the desktop (`xdg-open`), which goes on when this program ends.
///
/// Every user of the machine may read the words that a program is started with, and the address has the token: what
/// `xdg-open` is given is a file for this user alone, which leads there.
class OpenedBrowser {
  public:
    /// @param address  http://...
    /// @throws support::InputError if no temporary file can be made
    explicit OpenedBrowser(const std::string &address);

    /// False where there is no `xdg-open`.
    bool was_started() const { return was_started_; }

  private:
    support::ScratchFolder folder_; ///< with the file; it goes with this object
    bool was_started_ = false;
};

} // namespace livermark::cli
