// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/descent/descent_steps.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h
#include <utility>

#include "core/support/vector_dispatch.hpp"
#include "interactive/colouring.hpp"
#include "interactive/kernels/descent/descent_rows.hpp"
#include "interactive/kernels/inertia-inl.hpp"
#include "interactive/kernels/symmetric-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// A neighbour as seen from the node that moves.
struct Neighbour {
    Vec3 rest, moved; ///< where it is at rest, and its displacement from there
};

HWY_INLINE Neighbour chosen(hn::Mask<D> is_first, const Neighbour &first, const Neighbour &second) {
    return {chosen(is_first, first.rest, second.rest), chosen(is_first, first.moved, second.moved)};
}

/// A step of Newton's method for the nodes of a batch. With p, q, r the corners of a facet opposite the node, from
/// there on, 6 V J is n . p with n = (q - p) x (r - p), and minus its gradient is n. What n and n . p are at rest is
/// taken away before it is lost in the rounding; the rest of the energy is a Laplacian, whose entries are constant.
HWY_INLINE void descend(DescentRows &rows, std::size_t batch, std::size_t lane, V inertia) {
    const std::size_t row = batch * slice_size + lane;
    const auto here = load_rows(rows.displacement, row);
    const auto stiffness = hn::Mul(inertia, hn::Load(d, rows.mass.data() + row));
    auto gradient = scaled(stiffness, here - load_rows(rows.predicted, row));
    const auto zero = hn::Zero(d), diagonal = hn::Add(stiffness, hn::Load(d, rows.laplacian.data() + row));
    Symmetric hessian{diagonal, zero, zero, diagonal, zero, diagonal};
    const Vec3 none{zero, zero, zero};
    Neighbour p{none, none}, q{none, none}, r{none, none};
    const std::int32_t *index = rows.neighbour.data() + rows.line_start[batch] * slice_size + lane;
    const float *numbers = rows.numbers.data() + rows.line_start[batch] * numbers_of_line * slice_size + lane;
    const std::size_t num_lines = rows.line_start[batch + 1] - rows.line_start[batch];
    for (std::size_t k = 0; k < num_lines; ++k, index += slice_size, numbers += numbers_of_line * slice_size) {
        const auto signed_modulus = hn::Load(d, numbers + 4 * slice_size);
        p = chosen(hn::Lt(signed_modulus, zero), p, q);
        q = r;
        r = {load3(numbers), fetch(rows.displacement.data(), index).v - here};
        const auto modulus = hn::Abs(signed_modulus);
        const auto rest1 = q.rest - p.rest, rest2 = r.rest - p.rest;
        const auto moved1 = q.moved - p.moved, moved2 = r.moved - p.moved;
        const auto at_rest = cross(rest1, rest2);
        const auto change = cross(rest1, moved2) + cross(moved1, rest2 + moved2);
        const auto growth = hn::Add(dot(at_rest, p.moved), dot(change, p.rest + p.moved));
        const auto normal = at_rest + change;
        gradient = plus_scaled(gradient, hn::Load(d, numbers + 3 * slice_size), r.moved);
        gradient = plus_scaled(gradient, hn::Load(d, numbers + 5 * slice_size), change);
        gradient = plus_scaled(gradient, hn::Neg(hn::Mul(modulus, growth)), normal);
        add_outer(hessian, modulus, normal);
    }
    // By the diagonal, so that nothing overflows.
    const auto scale = hn::Div(number(1.0F), diagonal);
    const auto [adjugate, determinant] = adjugate_of(scaled(scale, hessian));
    store_rows(plus_scaled(here, hn::Neg(hn::Div(scale, determinant)), product(adjugate, gradient)), rows.displacement,
               row);
}

HWY_NOINLINE void sweep(DescentRows &rows, float inertia) {
    for (std::size_t batch = 0; batch < rows.num_batches(); ++batch)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d))
            descend(rows, batch, lane, number(inertia));
}

/// As Inertia says, and where iterations begin.
HWY_NOINLINE void begin(DescentRows &rows, float step, float damping) {
    const auto h = number(step), h_squared = number(step * step), inverse_damping = number(1.0F / damping);
    const std::size_t num_free = slice_size * rows.num_batches();
    for (std::size_t row = 0; row < num_free; row += hn::Lanes(d)) {
        const auto inverse_mass = hn::Div(number(1.0F), hn::Load(d, rows.mass.data() + row));
        const auto was = load_rows(rows.displacement, row), velocity = load_rows(rows.velocity, row);
        const auto force = load_rows(rows.external, row);
        const auto push = scaled(inverse_mass, force);
        const auto last = velocity - load_rows(rows.last_velocity, row); // times h
        const auto squared = hn::Max(dot(push, push), number(1e-30F));
        const auto followed = hn::Div(dot(last, push), hn::Mul(h, squared));
        const auto part = hn::Min(hn::Max(followed, hn::Zero(d)), number(1.0F));
        const auto whole = plus_scaled(scaled(h, velocity), h_squared, push);
        store_rows(was, rows.before, row);
        store_rows(plus_scaled(was, inverse_damping, whole), rows.predicted, row);
        store_rows(plus_scaled(plus_scaled(was, h, velocity), hn::Mul(h_squared, part), push), rows.displacement, row);
    }
    const auto first = static_cast<std::ptrdiff_t>(4 * num_free);
    std::copy(rows.displacement.begin() + first, rows.displacement.end(), rows.before.begin() + first);
    std::copy(rows.predicted.begin() + first, rows.predicted.end(), rows.displacement.begin() + first);
}

/// x = omega (x - x'') + x''
HWY_NOINLINE void accelerate(DescentRows &rows, float weight) {
    const auto omega = number(weight);
    for (std::size_t at = 0; at < rows.displacement.size(); at += hn::Lanes(d)) {
        const auto older = hn::Load(d, rows.oldest.data() + at);
        const auto moved = hn::Sub(hn::Load(d, rows.displacement.data() + at), older);
        hn::Store(hn::MulAdd(omega, moved, older), d, rows.displacement.data() + at);
    }
}

void take_descent(DescentRows &rows, double time_step, double mass_damping, int iterations) {
    const double damping = 1.0 + mass_damping * time_step;
    begin(rows, static_cast<float>(time_step), static_cast<float>(damping));
    const auto inertia = static_cast<float>(damping / (time_step * time_step));
    const double rho = chebyshev_rho(iterations);
    double weight = 1.0;
    for (int i = 1; i <= iterations; ++i) {
        weight = chebyshev_weight(i, weight, rho);
        rows.oldest.swap(rows.older);
        if (i < iterations)
            std::ranges::copy(rows.displacement, rows.older.begin());
        sweep(rows, inertia);
        if (weight != 1.0)
            accelerate(rows, static_cast<float>(weight));
        if (rows.after_iteration)
            rows.after_iteration();
    }
    rows.last_velocity.swap(rows.velocity);
    find_velocities(rows, rows.before, static_cast<float>(1.0 / time_step));
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::interactive::kernels {

LIVERMARK_DISPATCH(void take_descent_step, take_descent,
                   (DescentRows & rows, double time_step, double mass_damping, int iterations),
                   (rows, time_step, mass_damping, iterations))

} // namespace livermark::interactive::kernels
#endif
