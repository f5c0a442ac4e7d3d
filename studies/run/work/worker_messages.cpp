#include "studies/run/work/worker_messages.hpp"

#include <fmt/format.h>
#include <sstream>

namespace livermark::studies {

std::string to_text(MessageKind kind, std::size_t problem, const std::string &about, double seconds) {
    return fmt::format("{} {} {} {}", static_cast<char>(kind), problem, seconds, about);
}

WorkerMessage::WorkerMessage(const std::string &text) {
    std::istringstream words(text);
    char letter = 0;
    words >> letter >> problem >> seconds;
    words.ignore();
    std::getline(words, about, '\0');
    kind = static_cast<MessageKind>(letter);
}

} // namespace livermark::studies
