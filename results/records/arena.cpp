#include "results/records/arena.hpp"

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

} // namespace livermark::results
