#pragma once

#include <stdexcept>

namespace livermark::core {

/// Something that came in from outside is wrong: the message says what, where and the remedy in one sentence, and the
/// command ends with exit status 2. Every other exception is a fault of ours or of the machine.
class InputError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

} // namespace livermark::core
