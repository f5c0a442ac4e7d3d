// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/simd/take_steps.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h
#include <optional>
#include <stdexcept>
#include <type_traits>

#include "core/support/vector_dispatch.hpp"
#include "msm/kernels/simd/coupled_relaxation-inl.hpp"
#include "msm/kernels/simd/fan_forces-inl.hpp"
#include "msm/kernels/simd/schemes-inl.hpp"
#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"
#include "msm/kernels/thread_pool.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

// Forces of springs on pairs of slices of nodes.

/// Positions of nodes and, where stiffness damps, velocities.
template <bool is_damped, class D> struct Ends { Rows<D> position, velocity; };

template <bool is_damped, class T>
HWY_INLINE Ends<is_damped, Lanes<T>> fetch_ends(const StepWorkspace<T> &at, int now, const std::int32_t *index) {
    constexpr Lanes<T> d;
    Ends<is_damped, Lanes<T>> ends;
    ends.position = fetch(d, at.rows[now].data(), index);
    if constexpr (is_damped)
        ends.velocity = fetch(d, at.velocity_rows[now].data(), index);
    return ends;
}

/// The nodes of a slice, those from `lane` on.
template <bool is_damped, class T>
HWY_INLINE Ends<is_damped, Lanes<T>> own_ends(const StepWorkspace<T> &at, int now, int slice, std::size_t lane) {
    constexpr Lanes<T> d;
    const std::size_t own = (static_cast<std::size_t>(slice) * slice_size + lane) * 4;
    Ends<is_damped, Lanes<T>> ends;
    auto &x = ends.position;
    hn::LoadInterleaved4(d, at.rows[now].data() + own, x.x, x.y, x.z, x.w);
    auto &v = ends.velocity;
    if constexpr (is_damped)
        hn::LoadInterleaved4(d, at.velocity_rows[now].data() + own, v.x, v.y, v.z, v.w);
    return ends;
}

/// Factors of a line of springs that add up their forces: these are tension times span.
template <class D> struct Pull {
    hn::Vec<D> tension; ///< k (1 - l0/l + beta l'/l) [N/m]
    Vec3<D> span;
};

/// Tension of springs from here to there.
/// @param spring  k and, 16 further, k l0 / 2
template <bool is_damped, class T>
HWY_INLINE Pull<Lanes<T>> pull(const StepWorkspace<T> &at, const T *spring, const Ends<is_damped, Lanes<T>> &here,
                               const Ends<is_damped, Lanes<T>> &there) {
    constexpr Lanes<T> d;
    const auto three = hn::Set(d, T(3));
    const auto span = difference(there.position, here.position);
    const auto square = squared_length(d, span);
    const auto stiffness = hn::Load(d, spring);
    // The last step of Newton's method, 1 / l = guess (3 - l^2 guess^2) / 2, is part of the tension.
    const auto guess = guess_of_inverse_root(d, square);
    const auto correction = hn::NegMulAdd(hn::Mul(square, guess), guess, three);
    auto tension = hn::NegMulAdd(hn::Mul(hn::Load(d, spring + slice_size), guess), correction, stiffness);
    if constexpr (is_damped) {
        const auto inverse_length = hn::Mul(hn::Mul(guess, hn::Set(d, T(0.5))), correction);
        const auto rate = dot(span, difference(there.velocity, here.velocity));
        const auto beta = hn::Set(d, static_cast<T>(at.beta));
        tension = hn::MulAdd(hn::Mul(beta, stiffness), hn::Mul(rate, hn::Mul(inverse_length, inverse_length)), tension);
    }
    return {tension, span};
}

template <class D> HWY_INLINE void add(const Pull<D> &pull, Vec3<D> &force) {
    force.x = hn::MulAdd(pull.tension, pull.span.x, force.x);
    force.y = hn::MulAdd(pull.tension, pull.span.y, force.y);
    force.z = hn::MulAdd(pull.tension, pull.span.z, force.z);
}

/// Forces on the nodes of a pair of slices.
template <class D> struct PairForces { Vec3<D> first, second; };

/// k (l - l0 + beta l') n over the springs at nodes of a pair of slices, those from `lane` on.
template <bool is_damped, class T>
HWY_INLINE PairForces<Lanes<T>> spring_forces(const StepWorkspace<T> &at, int now, int pair, std::size_t lane) {
    constexpr Lanes<T> d;
    const auto zero = hn::Zero(d);
    PairForces<Lanes<T>> force{{zero, zero, zero}, {zero, zero, zero}};
    const auto &body = at.body;
    if (body.spring_lines.empty())
        return force;
    constexpr std::ptrdiff_t spring_line = 2 * slice_size;
    const SpringLines &lines = body.spring_lines[pair];
    const auto *index = body.neighbour.data() + static_cast<std::ptrdiff_t>(lines.first_neighbour) * slice_size + lane;
    const T *spring = body.spring.data() + lines.first_spring * spring_line + lane;
    const auto first = own_ends<is_damped>(at, now, 2 * pair, lane);
    const auto second = own_ends<is_damped>(at, now, 2 * pair + 1, lane);

    const auto between = pull<is_damped>(at, spring, first, second);
    force.first = scaled<Lanes<T>>(between.tension, between.span);
    force.second = minus(force.second, force.first);
    spring += spring_line;
    for (int line = 0; line < lines.count.shared; ++line, index += slice_size, spring += 2 * spring_line) {
        const auto there = fetch_ends<is_damped>(at, now, index);
        add(pull<is_damped>(at, spring, first, there), force.first);
        add(pull<is_damped>(at, spring + spring_line, second, there), force.second);
    }
    for (int line = 0; line < lines.count.alone[0]; ++line, index += slice_size, spring += spring_line)
        add(pull<is_damped>(at, spring, first, fetch_ends<is_damped>(at, now, index)), force.first);
    for (int line = 0; line < lines.count.alone[1]; ++line, index += slice_size, spring += spring_line)
        add(pull<is_damped>(at, spring, second, fetch_ends<is_damped>(at, now, index)), force.second);
    return force;
}

// Stresses that relax.

/// The tensions of a line of springs from here to there.
/// @param line  in units of 16
template <class T>
HWY_INLINE void relax_line(StepWorkspace<T> &at, int line, std::size_t lane, const Rows<Lanes<T>> &here,
                           const Rows<Lanes<T>> &there) {
    using D = Lanes<T>;
    constexpr D d;
    auto &relaxation = at.relaxation;
    const std::size_t place = static_cast<std::size_t>(line) * slice_size + lane;
    T *spring = at.body.spring.data() + static_cast<std::size_t>(line) * 2 * slice_size + lane;
    const auto length = hn::Sqrt(squared_length(d, difference(there, here)));
    const auto half_rest = hn::Load(d, relaxation.rest_tension.data() + place);
    const auto tension = hn::NegMulAdd(hn::Set(d, T(2)), half_rest, hn::Mul(hn::Load(d, spring), length));
    const auto faded = relax(D(), relaxation.shares, relaxation.springs, place, tension);
    hn::Store(hn::MulAdd(hn::Set(d, T(0.5)), faded, half_rest), d, spring + slice_size);
}

/// The springs at the nodes of a pair of slices, in the order of spring_forces().
template <class T> HWY_NOINLINE void relax_springs(StepWorkspace<T> &at, int now, int pair) {
    const SpringLines &lines = at.body.spring_lines[static_cast<std::size_t>(pair)];
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(Lanes<T>())) {
        const auto *index =
            at.body.neighbour.data() + static_cast<std::ptrdiff_t>(lines.first_neighbour) * slice_size + lane;
        int line = lines.first_spring;
        const auto first = own_ends<false>(at, now, 2 * pair, lane).position;
        const auto second = own_ends<false>(at, now, 2 * pair + 1, lane).position;
        relax_line(at, line++, lane, first, second);
        for (int n = 0; n < lines.count.shared; ++n, index += slice_size) {
            const auto there = fetch_ends<false>(at, now, index).position;
            relax_line(at, line++, lane, first, there);
            relax_line(at, line++, lane, second, there);
        }
        for (const int side : {0, 1})
            for (int n = 0; n < lines.count.alone[static_cast<std::size_t>(side)]; ++n, index += slice_size)
                relax_line(at, line++, lane, side == 0 ? first : second, fetch_ends<false>(at, now, index).position);
    }
}

/// Positions of the nodes of a slice, taken back along their velocities.
template <class T> void take_back(StepWorkspace<T> &at, int to, int slice) {
    const auto back = static_cast<T>(at.relaxation.shares.back);
    const auto &[position, velocity, free_per_mass] = at.nodes[static_cast<std::size_t>(slice)];
    T *rows = at.rows[to].data();
    for (std::size_t lane = 0; lane < slice_size; ++lane)
        for (std::size_t c = 0; c < 3; ++c)
            rows[4 * (static_cast<std::size_t>(slice) * slice_size + lane) + c] =
                position.high[c][lane] - back * velocity.high[c][lane];
    const auto &body = at.body;
    if (!body.copied_row.empty())
        for (int c = body.copy_start[slice]; c < body.copy_start[slice + 1]; ++c)
            std::copy_n(rows + 4 * static_cast<std::size_t>(body.copied_row[c]), 3,
                        rows + 4 * static_cast<std::size_t>(body.first_copy + c));
}

template <class T> void relax_all(StepWorkspace<T> &at, int thread, Barrier &barrier) {
    int now = at.now;
    if (at.relaxation.shares.back != 0.0) {
        now = 1 - at.now; // the next step writes these rows anew
        for (const int pair : at.pairs[thread].order)
            for (const int slice : {2 * pair, 2 * pair + 1})
                take_back(at, now, slice);
        barrier.wait();
    }
    if (!at.relaxation.springs.empty())
        for (const int pair : at.pairs[thread].order)
            relax_springs(at, now, pair);
    if (!at.relaxation.means.empty())
        at.coupled.relax(at, now, thread, barrier);
}

void relax_with_float(StepWorkspace<float> &at, int thread, Barrier &barrier) {
    relax_all(at, thread, barrier);
}
#if HWY_HAVE_FLOAT64
void relax_with_double(StepWorkspace<double> &at, int thread, Barrier &barrier) {
    relax_all(at, thread, barrier);
}
#else
void relax_with_double(StepWorkspace<double> & /*at*/, int /*thread*/, Barrier & /*barrier*/) {
    throw std::logic_error("stresses in double precision need vectors of float64, which are not there; ask for single");
}
#endif

// Steps.

/// The forces of all fans of a chunk on their corners. Not inlined, nor is nodal_states(): they are the same
/// for all schemes, and four copies of the longest code here would take most of the time that this file compiles.
template <bool is_damped, class T> HWY_NOINLINE void chunk_forces(StepWorkspace<T> &at, int now, int chunk) {
    const auto &body = at.body;
    std::fill(at.corner_force.begin() + 4 * static_cast<std::ptrdiff_t>(body.chunk_start[chunk]),
              at.corner_force.begin() + 4 * static_cast<std::ptrdiff_t>(body.chunk_start[chunk + 1]), T(0));
    const int end = body.chunk_fans[chunk + 1];
    if (at.coupled.fan_forces)
        for (int slice = body.chunk_fans[chunk]; slice < end; ++slice)
            at.coupled.fan_forces(at, now, slice);
    else
        for (int slice = body.chunk_fans[chunk]; slice < end; ++slice)
            fan_forces<is_damped>(at, now, slice);
}

/// Stresses and pressures around nodes or edges, which the fans need. All threads call it.
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
                    chunk_forces<is_damped>(at, now, chunk);
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
LIVERMARK_DISPATCH(template <> void relax_stresses, relax_with_float,
                   (StepWorkspace<float> & workspace, int thread, Barrier &barrier), (workspace, thread, barrier))
LIVERMARK_DISPATCH(template <> void relax_stresses, relax_with_double,
                   (StepWorkspace<double> & workspace, int thread, Barrier &barrier), (workspace, thread, barrier))

} // namespace livermark::msm
#endif
