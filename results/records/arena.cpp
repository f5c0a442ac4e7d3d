#include "results/records/arena.hpp"

#include <fmt/format.h>

namespace livermark::results {

const char *to_string(ArenaOutcome outcome) {
    switch (outcome) {
    case ArenaOutcome::too_slow:
        return "too slow";
    case ArenaOutcome::diverged:
        return "diverged";
    case ArenaOutcome::ok:
        break;
    }
    return "ok";
}

std::string iterations_of(int iterations, int stops_early) {
    return fmt::format("{}{}", stops_early != 0 ? "up to " : "", iterations);
}

} // namespace livermark::results
