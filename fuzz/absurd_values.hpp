#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "support/random_numbers.hpp"

/// What no program should have written, and some will have. Internal to fuzz/.
namespace livermark::fuzz {

inline constexpr std::array<std::string_view, 26> absurd_numbers{"nan",
                                                                 "-nan",
                                                                 "inf",
                                                                 "-inf",
                                                                 "0",
                                                                 "-0",
                                                                 "-1",
                                                                 "1e308",
                                                                 "-1e308",
                                                                 "1e400",
                                                                 "1e-320",
                                                                 "1e-4000",
                                                                 "2147483647",
                                                                 "2147483648",
                                                                 "-2147483648",
                                                                 "4294967295",
                                                                 "4294967296",
                                                                 "9223372036854775807",
                                                                 "-9223372036854775808",
                                                                 "18446744073709551615",
                                                                 "99999999999999999999999999",
                                                                 "0x10",
                                                                 "1,5",
                                                                 "+1",
                                                                 "%s%n",
                                                                 ""};
inline constexpr std::array<std::uint64_t, 14> absurd_integers{0,
                                                               1,
                                                               0x7f,
                                                               0x80,
                                                               0xff,
                                                               0x7fff,
                                                               0x8000,
                                                               0xffff,
                                                               0x7fffffff,
                                                               0x80000000,
                                                               0xffffffff,
                                                               0x7fffffffffffffff,
                                                               0x8000000000000000,
                                                               0xffffffffffffffff};
inline constexpr std::array<float, 10> absurd_floats{std::numeric_limits<float>::quiet_NaN(),
                                                     std::numeric_limits<float>::infinity(),
                                                     -std::numeric_limits<float>::infinity(),
                                                     std::numeric_limits<float>::max(),
                                                     std::numeric_limits<float>::lowest(),
                                                     std::numeric_limits<float>::denorm_min(),
                                                     0.0F,
                                                     -1.0F,
                                                     1e9F,
                                                     1e-9F};

template <class Values> auto one_of(const Values &values, support::RandomNumbers &random) {
    return values.at(static_cast<std::size_t>(random.below(static_cast<int>(values.size()))));
}

/// 0 ... number - 1, 0 of none.
inline std::size_t some_of(std::size_t number, support::RandomNumbers &random) {
    return number == 0 ? 0 : static_cast<std::size_t>(random.below(static_cast<int>(number)));
}

} // namespace livermark::fuzz
