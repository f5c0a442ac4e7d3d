// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/simd/relax_stresses.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h
#include <stdexcept>

#include "core/support/vector_dispatch.hpp"
#include "msm/kernels/simd/means-inl.hpp"
#include "msm/kernels/simd/neo_hookean_law-inl.hpp"
#include "msm/kernels/simd/spring_forces-inl.hpp"
#include "msm/kernels/simd/stars-inl.hpp"
#include "msm/kernels/threads/thread_pool.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// r + change of a branch, of which both parts of a float are kept: their sum, and what it lacks (Knuth 1969, The Art
/// of Computer Programming, vol. 2, section 4.2.2).
template <class D, class T>
HWY_INLINE hn::Vec<D> move_branch(D d, RelaxingStresses<T> &at, std::size_t i, hn::Vec<D> before, hn::Vec<D> change) {
    if constexpr (sizeof(T) == sizeof(float)) {
        change = hn::Add(change, hn::Load(d, at.low.data() + i));
        const auto sum = hn::Add(before, change);
        const auto added = hn::Sub(sum, before);
        const auto lost = hn::Add(hn::Sub(before, hn::Sub(sum, added)), hn::Sub(change, added));
        hn::Store(lost, d, at.low.data() + i);
        hn::Store(sum, d, at.high.data() + i);
        return sum;
    } else {
        const auto sum = hn::Add(before, change);
        hn::Store(sum, d, at.high.data() + i);
        return sum;
    }
}

/// Moves the branches of one stress, those from `i` on. @return what they take off it
template <class D, class T>
HWY_INLINE hn::Vec<D> relax(D d, const RelaxationShares &shares, RelaxingStresses<T> &at, std::size_t i,
                            hn::Vec<D> stress) {
    auto faded = hn::Mul(hn::Set(d, static_cast<T>(shares.at_once)), stress);
    for (std::size_t b = 0; b < shares.share.size(); ++b) {
        const std::size_t of_branch = b * at.size + i;
        const auto before = hn::Load(d, at.high.data() + of_branch);
        const auto way = hn::MulSub(hn::Set(d, static_cast<T>(shares.gain[b])), stress, before);
        const auto now =
            move_branch(d, at, of_branch, before, hn::Mul(hn::Set(d, static_cast<T>(shares.share[b])), way));
        faded = hn::Add(faded, shares.takes_former ? before : now);
    }
    return faded;
}

template <class D, class T>
HWY_INLINE Symmetric<D> relax(D d, const RelaxationShares &shares, RelaxingStresses<T> &at, std::size_t i,
                              const Symmetric<D> &stress) {
    const auto one = [&](std::size_t k, const hn::Vec<D> &component)
                         HWY_ATTR { return relax(d, shares, at, i + k * slice_size, component); };
    return {one(0, stress.xx), one(1, stress.yy), one(2, stress.zz),
            one(3, stress.xy), one(4, stress.yz), one(5, stress.zx)};
}

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

/// The stress of a mean.
/// @param mean  number of the control volume or star
template <class D, class T>
HWY_INLINE void relax_mean(D d, StepWorkspace<T> &at, std::size_t mean, const Symmetric<D> &stress) {
    auto &means = at.relaxation.means;
    const std::size_t first = first_of_six(mean);
    store_six(d, relax(d, at.relaxation.shares, means, first, stress), means.faded.data() + first);
}

template <template <bool, class> class Means, class T>
HWY_NOINLINE void relax_means_around_nodes(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    Means<false, T> means(at, now, slice);
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(D())) {
        const std::size_t volume = static_cast<std::size_t>(slice) * slice_size + lane;
        const auto modulus = hn::Load(D(), at.body.coupled_modulus.data() + volume);
        relax_mean(D(), at, volume, isochoric_stress(D(), modulus, means.mean(lane).tensor, at.least_stretch));
    }
}

template <template <bool, class> class Stars, class T>
HWY_NOINLINE void relax_stars(StepWorkspace<T> &at, int now, int thread, int slice) {
    using D = Lanes<T>;
    const auto &body = at.body;
    T *kept = at.star_scratch[static_cast<std::size_t>(thread)].data();
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(D())) {
        const StarPlaces places(body, slice, lane);
        const std::size_t star = static_cast<std::size_t>(slice) * slice_size + lane;
        const StarFetch<false, T> fetch(at, now, places);
        const Stars<false, T> means(at, fetch, places, hn::Load(D(), body.star_inverse_volume.data() + star), kept);
        const auto modulus = hn::Load(D(), body.star_modulus.data() + star);
        relax_mean(D(), at, star, isochoric_stress(D(), modulus, means.mean(), at.least_stretch));
    }
}

/// V g_i . R g_j of the edges of a tetrahedron, see RelaxationArrays::pull.
template <class D> HWY_INLINE Symmetric<D> pulls_of(const Symmetric<D> &faded, const OfCorners<D> &rest) {
    const auto of_a = product<D>(faded, rest.a), of_b = product<D>(faded, rest.b), of_c = product<D>(faded, rest.c);
    const auto ab = dot(rest.a, of_b), bc = dot(rest.b, of_c), ca = dot(rest.c, of_a);
    // The gradients sum to zero, and so do what they pull with.
    const auto from_start = [&](const hn::Vec<D> &own, const hn::Vec<D> &one, const hn::Vec<D> &other)
                                HWY_ATTR { return hn::Neg(hn::Add(own, hn::Add(one, other))); };
    return {from_start(dot(rest.a, of_a), ab, ca),
            from_start(dot(rest.b, of_b), ab, bc),
            from_start(dot(rest.c, of_c), bc, ca),
            ab,
            bc,
            ca};
}

/// The stresses inside the tetrahedra of a slice of fans, and what they make nodes pull each other with.
template <class T> HWY_NOINLINE void relax_tetrahedra(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const T *rows = at.rows[now].data();
    const bool has_pulls = !at.relaxation.pull.empty();
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        const auto *corner = body.corner.data() + lines.corner;
        const auto start = fetch(d, rows, corner);
        const auto arm = [&]() HWY_ATTR {
            corner += slice_size;
            return difference(fetch(d, rows, corner), start);
        };
        const auto axis = arm();
        auto from = arm();
        for (std::size_t t = lines.first; t < lines.end; t += slice_size) {
            const auto to = arm();
            const auto rest = rest_gradients(D(), body, t, lane);
            const auto stress =
                isochoric_stress(D(), hn::Load(d, body.inner_modulus.data() + t),
                                 twice_strain(D(), gradient<D>({axis, from, to}, rest)), at.least_stretch);
            const std::size_t first = first_of_six(t);
            const auto faded = relax(D(), at.relaxation.shares, at.relaxation.tetrahedra, first, stress);
            if (has_pulls)
                store_six(D(), pulls_of<D>(faded, rest), at.relaxation.pull.data() + first);
            else
                store_six(D(), faded, at.relaxation.tetrahedra.faded.data() + first);
            from = to;
        }
    }
}

/// The means of Hooke's springs around nodes, from what nodal_strains() has put down.
template <class T> HWY_NOINLINE void relax_nodal_springs(StepWorkspace<T> &at, int volume_slice) {
    using D = Lanes<T>;
    HWY_ALIGN T sums[slice_size * 8];
    sum_of_strains(at, volume_slice, sums);
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(D())) {
        const std::size_t volume = static_cast<std::size_t>(volume_slice) * slice_size + lane;
        const auto modulus = hn::Load(D(), at.body.coupled_modulus.data() + volume);
        relax_mean(D(), at, volume, deviatoric_stress(D(), modulus, load_eight(D(), sums + 8 * lane).tensor));
    }
}

/// Those inside the tetrahedra of a slice of fans, from the same.
template <class T> HWY_NOINLINE void relax_inner_springs(StepWorkspace<T> &at, int slice) {
    using D = Lanes<T>;
    auto &inside = at.relaxation.tetrahedra;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(D())) {
        const FanLines lines(at.body, slice, lane);
        for (std::size_t t = lines.first; t < lines.end; t += slice_size) {
            const auto stress = deviatoric_stress(D(), hn::Load(D(), at.body.inner_modulus.data() + t),
                                                  load_eight(D(), at.strain.data() + 8 * t).tensor);
            const std::size_t first = first_of_six(t);
            store_six(D(), relax(D(), at.relaxation.shares, inside, first, stress), inside.faded.data() + first);
        }
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

/// The elastic stiffness of a pair of nodes and the pulls of the tetrahedra there.
template <class T> T stiffness_of_pair(const RelaxationArrays<T> &relaxation, std::size_t pair) {
    T sum = relaxation.rest_stiffness[pair];
    for (int p = relaxation.pull_start[pair]; p < relaxation.pull_start[pair + 1]; ++p)
        sum += relaxation.pull[static_cast<std::size_t>(relaxation.pull_place[p])];
    return sum;
}

/// Puts these sums where steps find them.
template <class T> void add_pulls(StepWorkspace<T> &at, int thread) {
    auto &body = at.body;
    if (body.is_around_edges()) {
        const auto [first, last] = at.chunks[thread];
        const auto begin = static_cast<std::size_t>(body.chunk_stars[first]) * slice_size,
                   end = static_cast<std::size_t>(body.chunk_stars[last]) * slice_size;
        for (std::size_t star = begin; star < end; ++star)
            body.star_stiffness[star] = stiffness_of_pair(at.relaxation, star);
        return;
    }
    const auto [first, last] = at.volume_slices[thread];
    const auto begin = static_cast<std::size_t>(body.mean_start[first]) * slice_size,
               end = static_cast<std::size_t>(body.mean_start[last]) * slice_size;
    for (std::size_t line = begin; line < end; line += slice_size)
        for (std::size_t lane = 0; lane < slice_size; ++lane)
            body.mean_gradient[4 * line + 3 * slice_size + lane] = stiffness_of_pair(at.relaxation, line + lane);
}

/// Of Hooke's springs that are coupled around nodes: see relax_all().
template <class T> void relax_hooke(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    const auto &fans = at.fan_slices[thread], &volumes = at.volume_slices[thread];
    for (int slice = fans.first; slice < fans.last; ++slice)
        nodal_strains<false>(at, now, slice);
    barrier.wait();
    for (int slice = volumes.first; slice < volumes.last; ++slice)
        relax_nodal_springs(at, slice);
    for (int slice = fans.first; slice < fans.last; ++slice)
        relax_inner_springs(at, slice);
}

/// Of neo-Hookean springs that are coupled: see relax_all().
template <class T> void relax_neo_hookean(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    const auto &body = at.body;
    const auto &fans = at.fan_slices[thread], &volumes = at.volume_slices[thread];
    if (body.is_around_edges()) {
        const auto [first, last] = at.chunks[thread];
        const auto relax_slice =
            body.measure == StrainMeasure::deformation_gradient ? relax_stars<StarsOfF, T> : relax_stars<StarsOfC, T>;
        for (int slice = body.chunk_stars[first]; slice < body.chunk_stars[last]; ++slice)
            relax_slice(at, now, thread, slice);
    } else if (!body.mean_gradient.empty()) {
        for (int slice = volumes.first; slice < volumes.last; ++slice)
            relax_means_around_nodes<MeansOfF>(at, now, slice);
    } else {
        for (int slice = fans.first; slice < fans.last; ++slice)
            corner_strains<false>(at, now, slice);
        barrier.wait();
        for (int slice = volumes.first; slice < volumes.last; ++slice)
            relax_means_around_nodes<MeansOfC>(at, now, slice);
    }
    for (int slice = fans.first; slice < fans.last; ++slice)
        relax_tetrahedra(at, now, slice);
    if (at.relaxation.pull.empty())
        return;
    barrier.wait();
    add_pulls(at, thread);
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
    if (at.relaxation.means.empty())
        return;
    if (at.body.inverse_volume.empty())
        relax_hooke(at, now, thread, barrier);
    else
        relax_neo_hookean(at, now, thread, barrier);
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
