#pragma once

#include <cstdint>

namespace livermark::interactive {

/// The number format of the steps of a method that has two. Its energy, and the forces that it is asked for, are those
/// of the slow one.
enum class Precision : std::uint8_t {
    single_precision, ///< on the vectors of the machine
    double_precision  ///< plain loops, what the other is compared with
};

} // namespace livermark::interactive
