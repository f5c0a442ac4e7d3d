#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "app/live/messages.hpp"
#include "meshes/generators/box_generator.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace {

using Numbers = std::vector<double>;

Numbers as_numbers(std::span<const std::uint8_t> bytes) {
    Numbers numbers(bytes.size() / sizeof(double));
    if (!numbers.empty())
        std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(double));
    return numbers;
}

/// A box that is constrained on one side.
std::unique_ptr<livermark::live::Scene> box() {
    using namespace livermark;
    core::Body body;
    body.mesh = meshes::generate_box({0.1, 0.1, 0.1}, 0.06, meshes::BoxTopology::kuhn);
    body.materials = {{1060.0, 5e3, 0.45}};
    std::vector<bool> constrained;
    for (const int patch : body.mesh.boundary_patch)
        constrained.push_back(patch == 0);
    return std::make_unique<live::Scene>(std::move(body), constrained);
}

} // namespace

/// The first byte says whether a body follows, or messages to a box: of each the number of its numbers, and these.
void livermark::fuzz::read(Input input) {
    if (input.empty())
        return;
    const bool is_body = input.front() == 0;
    input = input.subspan(1);
    if (is_body) {
        const auto scene = live::scene_of(as_numbers(input));
        reply(*scene, Numbers{1, 1, 1, 5e3, 0.45, 10.0, 0.0, 0.0});
        reply(*scene, Numbers{2, 1, 0.0, 0.0, 0.0, 0.02, 0, 5});
        return;
    }
    const auto scene = box();
    while (!input.empty()) {
        const std::size_t length = std::min<std::size_t>(sizeof(double) * (input.front() % 16), input.size() - 1);
        auto message = as_numbers(input.subspan(1, length));
        input = input.subspan(1 + length);
        if (message.size() == 8 && message.front() == 2.0)
            message.back() = std::min(message.back(), 20.0); // more of them teach nothing else
        try {
            reply(*scene, message);
        } catch (const support::InputError &) { // and the next message is heard
        }
    }
}
