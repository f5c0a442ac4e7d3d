#include "app/live_springs.hpp"

#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "app/live_body.hpp"
#include "core/input_error.hpp"
#include "live/messages.hpp"

namespace livermark::app {

server::Conversation live_springs(const std::filesystem::path &folder, const server::Fields &query) {
    const auto opened = open_live_body(folder, query);
    std::vector<bool> is_held;
    for (const int constraint : opened.held.constraint)
        is_held.push_back(constraint >= 0);
    return [scene = std::make_shared<live::Scene>(*opened.body, is_held)](const server::Message &message) {
        if (!message.is_binary)
            return server::Message{.is_binary = false, .bytes = live::spring_law_names()};
        std::vector<double> numbers(message.bytes.size() / sizeof(double));
        if (numbers.size() * sizeof(double) != message.bytes.size())
            throw core::InputError("the message is not made of float64; load the page again");
        if (!numbers.empty())
            std::memcpy(numbers.data(), message.bytes.data(), message.bytes.size());
        return server::Message{.is_binary = true, .bytes = live::reply(*scene, numbers)};
    };
}

} // namespace livermark::app
