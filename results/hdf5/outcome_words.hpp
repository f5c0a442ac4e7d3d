#pragma once

#include <array>

#include "results/hdf5/io/words.hpp"
#include "results/records/arena.hpp"

namespace livermark::results::hdf5 {

template <> struct Words<ArenaOutcome> {
    static constexpr std::array all{ArenaOutcome::ok, ArenaOutcome::too_slow, ArenaOutcome::diverged};
};

} // namespace livermark::results::hdf5
