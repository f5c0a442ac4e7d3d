#pragma once

#include <cstddef>
#include <string>

namespace livermark::studies {

/// A message of a worker about the problems that it is at: a letter, the number of the problem, seconds, and what it is
/// about.
enum class MessageKind : char { step = 's', time = 't', result = 'r', failure = 'f' };

std::string to_text(MessageKind kind, std::size_t problem, const std::string &about, double seconds = 0.0);

/// A message as it arrives.
struct WorkerMessage {
    explicit WorkerMessage(const std::string &text);

    MessageKind kind;
    std::size_t problem = 0;
    double seconds = 0.0;
    std::string about;
};

} // namespace livermark::studies
