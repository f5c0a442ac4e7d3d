#pragma once

namespace livermark::meshes {

/// Newton's iteration, because std::cbrt may round differently elsewhere.
inline double cube_root(double value) {
    double root = 1.0;
    for (int iteration = 0; iteration < 60; ++iteration)
        root -= (root - value / (root * root)) / 3.0;
    return root;
}

} // namespace livermark::meshes
