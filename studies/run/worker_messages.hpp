#pragma once

#include <cstddef>
#include <string>

namespace livermark::studies {

/// What a worker tells of the problems that it is at: a letter, the number of the problem, seconds, and what it is
/// about.
enum class MessageKind : char { step = 's', time = 't', result = 'r', failure = 'f' };

std::string to_text(MessageKind news, std::size_t problem, const std::string &about, double seconds = 0.0);

/// What came home.
struct WorkerMessage {
    explicit WorkerMessage(const std::string &text);

    MessageKind news;
    std::size_t problem = 0;
    double seconds = 0.0;
    std::string about;
};

} // namespace livermark::studies
