// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/simd/relax_stresses.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h
#include <stdexcept>

#include "core/support/vector_dispatch.hpp"
#include "msm/kernels/simd/coupled_relaxation-inl.hpp"
#include "msm/kernels/simd/spring_forces-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

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

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::msm {

LIVERMARK_DISPATCH(template <> void relax_stresses, relax_with_float,
                   (StepWorkspace<float> & workspace, int thread, Barrier &barrier), (workspace, thread, barrier))
LIVERMARK_DISPATCH(template <> void relax_stresses, relax_with_double,
                   (StepWorkspace<double> & workspace, int thread, Barrier &barrier), (workspace, thread, barrier))

} // namespace livermark::msm
#endif
