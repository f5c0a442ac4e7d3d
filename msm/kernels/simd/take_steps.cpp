// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/simd/take_steps.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h
#include <optional>
#include <stdexcept>
#include <type_traits>

#include "core/support/vector_dispatch.hpp"
#include "msm/kernels/simd/fan_forces-inl.hpp"
#include "msm/kernels/simd/schemes-inl.hpp"
#include "msm/kernels/simd/spring_forces-inl.hpp"
#include "msm/kernels/threads/thread_pool.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// The forces of all stars and fans of a chunk on their corners. Not inlined, nor is nodal_states(): they are the same
/// for all schemes, and four copies of the longest code here would take most of the time that this file compiles.
template <bool is_damped, class T>
HWY_NOINLINE void chunk_forces(StepWorkspace<T> &at, int now, int thread, int chunk) {
    const auto &body = at.body;
    std::fill(at.corner_force.begin() + 4 * static_cast<std::ptrdiff_t>(body.chunk_start[chunk]),
              at.corner_force.begin() + 4 * static_cast<std::ptrdiff_t>(body.chunk_start[chunk + 1]), T(0));
    const int end = body.chunk_fans[chunk + 1];
    if (at.coupled.star_forces)
        for (int slice = body.chunk_stars[chunk]; slice < body.chunk_stars[chunk + 1]; ++slice)
            at.coupled.star_forces(at, now, thread, slice);
    if (at.coupled.fan_forces)
        for (int slice = body.chunk_fans[chunk]; slice < end; ++slice)
            at.coupled.fan_forces(at, now, slice);
    else
        for (int slice = body.chunk_fans[chunk]; slice < end; ++slice)
            fan_forces<is_damped>(at, now, slice);
}

/// Stresses and pressures around nodes, which the fans need. All threads call it.
template <bool is_damped, class T>
HWY_NOINLINE void nodal_states(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    const auto [first_fan, last_fan] = at.fan_slices[thread];
    const auto [first, last] = at.volume_slices[thread];
    const auto put_means = at.coupled.put_means ? at.coupled.put_means : volume_gains<is_damped, NoEnergy, T>;
    for (int slice = first_fan; slice < last_fan; ++slice)
        put_means(at, now, slice);
    barrier.wait();
    if (at.coupled.stresses)
        return at.coupled.stresses(at, now, thread, barrier);
    for (int slice = first; slice < last; ++slice)
        pressures(at, now, slice);
    barrier.wait();
}

/// The nodes of a pair of slices to their rows of the next stage.
template <bool is_damped, class Scheme, class T>
HWY_INLINE void move_pair(const Scheme &scheme, StepWorkspace<T> &at, int now, int pair) {
    using D = Lanes<T>;
    constexpr D d;
    const bool has_tetrahedra = !at.body.rest_volume.empty();
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        auto force = spring_forces<is_damped>(at, now, pair, lane);
        if (has_tetrahedra) {
            force.first = plus_corner_forces(D(), at, 2 * pair, lane, force.first);
            force.second = plus_corner_forces(D(), at, 2 * pair + 1, lane, force.second);
        }
        advance<is_damped>(D(), scheme, at, now, 2 * pair, lane, force.first);
        advance<is_damped>(D(), scheme, at, now, 2 * pair + 1, lane, force.second);
    }
    if (!at.body.copied_row.empty())
        for (const int slice : {2 * pair, 2 * pair + 1})
            write_copies<is_damped>(at, 1 - now, slice);
}

/// Asks for cache lines of rows, some on the way of a thread through its pairs of slices.
/// @param way  pairs of slices since it began to ask
template <class T, int for_writing>
HWY_INLINE void ask_for(const Aligned<T> &rows, const CacheLines &lines, std::size_t way) {
    const std::size_t end = std::min(lines.index.size(), lines.at_once * (way + 1));
    for (std::size_t k = lines.at_once * way; k < end; ++k)
        __builtin_prefetch(rows.data() + lines.index[k], for_writing);
}

/// The nodes of a thread to their rows of the next stage: first those that do not need others. Half the way through
/// these it waits for the stage before, and asks for what others have written and read since: to get a cache line from
/// another core takes as long as to move a slice.
/// @param before  what to wait for, if anything
template <bool is_damped, class Scheme, class T>
HWY_INLINE void move_nodes(const Scheme &scheme, StepWorkspace<T> &at, int now, const PairPartition &pairs,
                           Barrier &barrier, std::optional<Barrier::Round> before) {
    const auto wait = [&]() HWY_ATTR {
        if (before)
            barrier.wait_for(*before);
    };
    if (pairs.order.empty())
        wait();
    const std::size_t half = pairs.num_interior / 2;
    for (std::size_t s = 0; s < pairs.order.size(); ++s) {
        if (s == half)
            wait();
        if (s >= half) {
            ask_for<T, 0>(at.rows[now], pairs.ghost, s - half);
            ask_for<T, 1>(at.rows[1 - now], pairs.shared, s - half);
        }
        move_pair<is_damped>(scheme, at, now, pairs.order[s]);
    }
}

template <class Scheme, bool is_damped, class T>
void run(StepWorkspace<T> &at, int thread, int num_steps, Barrier &barrier) {
    const auto &pairs = at.pairs[thread];
    const auto [first_chunk, last_chunk] = at.chunks[thread];
    const bool has_states = !at.body.member.empty(), has_tetrahedra = !at.body.rest_volume.empty();
    const int num_stages = at.scheme.num_stages();
    int now = at.now;
    std::optional<Barrier::Round> before; // the last stage, at which others may still be
    for (int step = 0; step < num_steps; ++step)
        for (int stage = 0; stage < num_stages; ++stage) {
            if (has_tetrahedra && before)
                barrier.wait_for(*before);
            if (has_states)
                nodal_states<is_damped>(at, now, thread, barrier);
            if (has_tetrahedra) {
                for (int chunk = first_chunk; chunk < last_chunk; ++chunk)
                    chunk_forces<is_damped>(at, now, thread, chunk);
                barrier.wait();
            }
            move_nodes<is_damped>(Scheme(at.scheme, stage, at.time_step), at, now, pairs, barrier, before);
            if (step + 1 < num_steps || stage + 1 < num_stages)
                before = barrier.arrive(); // the pool waits for the last step
            now = 1 - now;
        }
}

template <class T> void take(StepWorkspace<T> &at, int thread, int num_steps, Barrier &barrier) {
    const auto with = [&]<class Scheme>(std::type_identity<Scheme> /*scheme*/) {
        if (at.beta != 0.0)
            run<Scheme, true>(at, thread, num_steps, barrier);
        else
            run<Scheme, false>(at, thread, num_steps, barrier);
    };
    switch (at.scheme.kind) {
    case StepScheme::Kind::symplectic_euler:
        return with(std::type_identity<SymplecticEuler<T>>());
    case StepScheme::Kind::velocity_verlet:
        return with(std::type_identity<VelocityVerlet<T>>());
    case StepScheme::Kind::runge_kutta:
        return with(std::type_identity<RungeKutta<T>>());
    case StepScheme::Kind::runge_kutta_chebyshev:
        return with(std::type_identity<RungeKuttaChebyshev<T>>());
    }
}

void take_with_float(StepWorkspace<float> &at, int thread, int num_steps, Barrier &barrier) {
    take(at, thread, num_steps, barrier);
}
#if HWY_HAVE_FLOAT64
void take_with_double(StepWorkspace<double> &at, int thread, int num_steps, Barrier &barrier) {
    take(at, thread, num_steps, barrier);
}
#else
void take_with_double(StepWorkspace<double> & /*at*/, int /*thread*/, int /*num_steps*/, Barrier & /*barrier*/) {
    throw std::logic_error("forces in double precision need vectors of float64, which are not there; ask for single");
}
#endif

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::msm {

LIVERMARK_DISPATCH(template <> void take_steps, take_with_float,
                   (StepWorkspace<float> & workspace, int thread, int num_steps, Barrier &barrier),
                   (workspace, thread, num_steps, barrier))
LIVERMARK_DISPATCH(template <> void take_steps, take_with_double,
                   (StepWorkspace<double> & workspace, int thread, int num_steps, Barrier &barrier),
                   (workspace, thread, num_steps, barrier))

} // namespace livermark::msm
#endif
