// The messages of a live page once more, by the same lines as in the page, compiled for this machine.
//   stdin: for each message its number of float64 as uint64, and the numbers; the first is the body
//   stdout: for each of the others the number of bytes of the solution as uint64, and the bytes
#include <cstdint>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "app/live/messages.hpp"

namespace {

bool read_message(std::istream &in, std::vector<double> &message) {
    std::uint64_t count = 0;
    if (!in.read(reinterpret_cast<char *>(&count), sizeof count))
        return false;
    message.resize(count);
    return static_cast<bool>(in.read(reinterpret_cast<char *>(message.data()), count * sizeof(double)));
}

} // namespace

int main() {
    try {
        std::unique_ptr<livermark::live::Scene> scene;
        for (std::vector<double> message; read_message(std::cin, message);) {
            if (!scene) {
                scene = livermark::live::scene_of(message);
                continue;
            }
            const auto answer = livermark::live::reply(*scene, message);
            const std::uint64_t size = answer.size();
            std::cout.write(reinterpret_cast<const char *>(&size), sizeof size);
            std::cout.write(answer.data(), static_cast<std::streamsize>(size));
        }
        std::cout.flush();
    } catch (const std::exception &error) {
        std::cerr << "live_replay: " << error.what() << '\n';
        return 2;
    }
}
