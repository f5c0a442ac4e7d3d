#include "app/news.hpp"

#include <fmt/format.h>
#include <sstream>

namespace livermark::app {

std::string to_text(News news, std::size_t problem, const std::string &about, double seconds) {
    return fmt::format("{} {} {} {}", static_cast<char>(news), problem, seconds, about);
}

Told::Told(const std::string &text) {
    std::istringstream words(text);
    char letter = 0;
    words >> letter >> problem >> seconds;
    words.ignore();
    std::getline(words, about, '\0');
    news = static_cast<News>(letter);
}

} // namespace livermark::app
