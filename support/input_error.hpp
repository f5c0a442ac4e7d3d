#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace livermark::support {

/// Something that came in from outside is wrong: the message says what, where and the remedy in one sentence, and the
/// command ends with exit status 2. Every other exception is a fault of ours or of the machine.
class InputError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A piece of a damaged file as a message can show it: printable, and not longer than a few words.
std::string shown(std::string_view text);

} // namespace livermark::support
