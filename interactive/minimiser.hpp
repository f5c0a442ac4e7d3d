#pragma once

#include <cstdint>
#include <vector>

#include "interactive/energy.hpp"
#include "interactive/inertia.hpp"

namespace livermark::interactive {

/// Where Newton's method came to.
struct Minimum {
    Field positions; ///< shape (3, N) [m]
    bool converged = false;
    int iterations = 0;    ///< of Newton's method
    double residual = 0.0; ///< force out of balance at free nodes, over what is balanced [N/N]
    double press = 0.0;    ///< what f is multiplied by where Loads::press, else 1
};

/// How forces are given.
enum class Loads : std::uint8_t {
    known,
    press ///< f . x stays as it is, and f is multiplied by what that takes
};

/// How Newton's method goes on.
struct NewtonSettings {
    double tolerance = 1e-10; ///< of the residual
    int max_iterations = 200;
    Loads loads = Loads::known;
};

/// The least of
///     W(x) - f . x + sum over the nodes of k_i / 2 |x_i - y_i|^2
/// over the positions of the free nodes, by Newton's method with CHOLMOD. The second derivatives of elements are made
/// positive semidefinite where the whole is not positive definite; a step goes as far as the sum becomes less.
///
/// Under Loads::press it is the least of W among the positions with this f . x.
///
/// It shares nothing with the steps of methods but their energy, so that what these converge to can be checked.
///
/// @param forces   f, shape (3, N) [N]
/// @param inertia  k and y; nullptr for the static solution, k = 0
/// @param start    shape (3, N); constrained nodes stay where they are
Minimum minimise(const Energy &energy, const std::vector<bool> &is_free, const Field &forces, const Inertia *inertia,
                 const Field &start, const NewtonSettings &settings = {});

/// Where the free nodes go, as far as the tangent at x knows, when constrained nodes move and forces change.
/// @param x            shape (3, N), where the free nodes are in balance
/// @param moved_to     the same, with constrained nodes elsewhere
/// @param more_forces  shape (3, N) [N]
Field predict(const Energy &energy, const std::vector<bool> &is_free, const Field &x, const Field &moved_to,
              const Field &more_forces);

} // namespace livermark::interactive
