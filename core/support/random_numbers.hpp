#pragma once

#include <cstdint>
#include <random>

namespace livermark::support {

/// Random numbers that are the same everywhere: the sequence of the engine is laid down in the standard, that of the
/// standard's distributions is not.
class RandomNumbers {
  public:
    explicit RandomNumbers(std::uint64_t seed) : engine_(seed) {}

    /// In [0, 1).
    double uniform() { return 0x1p-53 * static_cast<double>(engine_() >> 11U); }
    /// In [low, high).
    double uniform(double low, double high) { return low + (high - low) * uniform(); }
    /// 0 ... number - 1
    int below(int number) { return static_cast<int>(number * uniform()); }
    /// Close to the normal distribution, within six standard deviations: the sum of twelve uniform numbers, which takes
    /// additions alone.
    double normal(double mean, double standard_deviation) {
        double sum = -6.0;
        for (int i = 0; i < 12; ++i)
            sum += uniform();
        return mean + standard_deviation * sum;
    }

  private:
    std::mt19937_64 engine_;
};

} // namespace livermark::support
