// A reckless user of the live page, for as many steps as somebody likes.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <exception>
#include <fmt/format.h>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "tests/app/live/rough_trial.hpp"

namespace {

/// As live_replay reads them.
void write_messages(const std::string &path, const std::vector<std::vector<double>> &messages) {
    std::ofstream file(path, std::ios::binary);
    for (const auto &message : messages) {
        const std::uint64_t count = message.size();
        file.write(reinterpret_cast<const char *>(&count), sizeof count);
        file.write(reinterpret_cast<const char *>(message.data()),
                   static_cast<std::streamsize>(count * sizeof(double)));
    }
}

} // namespace

int main(int argc, char **argv) {
    std::vector<std::string> bodies{"liver_healthy", "liver_tumours", "beam"};
    int num_steps = 700;
    std::uint32_t seed = 1;
    double lowest_poisson_ratio = 0.25;
    std::string messages;
    CLI::App app("Handles the springs of the live page as roughly as it can, and says what was lost");
    app.add_option("--body", bodies,
                   "liver_healthy, liver_tumours, liver_with_capsule, beam, small_beam (63 nodes), lump or covered");
    app.add_option("--steps", num_steps, "of each body")->check(CLI::PositiveNumber);
    app.add_option("--seed", seed, "of the random numbers");
    app.add_option("--lowest-poisson-ratio", lowest_poisson_ratio, "of the materials that are chosen")
        ->check(CLI::Range(0.0, 0.49));
    app.add_option("--messages", messages, "a file to write what was done to, as live_replay reads it; of one body");
    CLI11_PARSE(app, argc, argv);
    try {
        bool is_sound = true;
        for (const auto &body : bodies) {
            const auto found = livermark::live::take_trial(body, num_steps, seed, lowest_poisson_ratio);
            fmt::print("{}: {} steps, {} tools, {} choices of springs; {} motions lost, {} of them in small pokes; "
                       "{} frames not finite; back to rest {} fresh; up to {:.1f} N and {:.0f} mm, smallest volume "
                       "{:.2f}\n",
                       body, found.num_steps, found.num_tools, found.num_choices, found.num_restarts,
                       found.num_small_lost, found.num_not_finite, found.is_fresh ? "is" : "IS NOT", found.strongest,
                       1e3 * found.furthest, found.smallest_volume);
            is_sound = is_sound && found.num_restarts == 0 && found.num_not_finite == 0 && found.is_fresh;
            if (!messages.empty())
                write_messages(messages, found.messages);
        }
        return is_sound ? 0 : 1;
    } catch (const std::exception &error) {
        std::cerr << "live_trial: " << error.what() << '\n';
        return 2;
    }
}
