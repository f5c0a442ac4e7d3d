#pragma once

/// Factors from SI units to those that people read; what computes knows SI alone.
namespace livermark::core {

inline constexpr double millijoules = 1e3;
inline constexpr double percent = 100.0;
inline constexpr double millimetres = 1e3;
inline constexpr double milliseconds = 1e3;
inline constexpr double microseconds = 1e6;

} // namespace livermark::core
