#include "app/server/sessions/live_springs.hpp"

#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "app/live/messages.hpp"
#include "app/server/sessions/live_body.hpp"
#include "core/support/input_error.hpp"

namespace livermark::server {

Session live_springs(const std::filesystem::path &folder, const Fields &query) {
    const auto opened = open_live_body(folder, query);
    std::vector<bool> is_constrained;
    for (const int condition : opened.constrained.condition_on)
        is_constrained.push_back(condition >= 0);
    return [scene = std::make_shared<live::Scene>(*opened.body, is_constrained, opened.constrained.foundation)](
               const Message &message) {
        if (!message.is_binary)
            return Message{.is_binary = false, .bytes = live::joined_spring_names()};
        std::vector<double> numbers(message.bytes.size() / sizeof(double));
        if (numbers.size() * sizeof(double) != message.bytes.size())
            throw support::InputError("the message is not made of float64; load the page again");
        if (!numbers.empty())
            std::memcpy(numbers.data(), message.bytes.data(), message.bytes.size());
        return Message{.is_binary = true, .bytes = live::reply(*scene, numbers)};
    };
}

} // namespace livermark::server
