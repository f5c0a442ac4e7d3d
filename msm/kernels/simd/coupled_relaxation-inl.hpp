// Stresses of coupled springs that relax. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_COUPLED_RELAXATION_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_COUPLED_RELAXATION_INL_HPP
#undef LIVERMARK_COUPLED_RELAXATION_INL_HPP
#else
#define LIVERMARK_COUPLED_RELAXATION_INL_HPP
#endif

#include "msm/kernels/simd/edges-inl.hpp"
#include "msm/kernels/simd/means-inl.hpp"
#include "msm/kernels/thread_pool.hpp"

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
        const std::size_t place = b * at.size + i;
        const auto before = hn::Load(d, at.high.data() + place);
        const auto way = hn::MulSub(hn::Set(d, static_cast<T>(shares.gain[b])), stress, before);
        const auto now = move_branch(d, at, place, before, hn::Mul(hn::Set(d, static_cast<T>(shares.share[b])), way));
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

/// The stress of a mean.
/// @param mean  number of the control volume or edge
template <class D, class T>
HWY_INLINE void relax_mean(D d, StepWorkspace<T> &at, std::size_t mean, const Symmetric<D> &stress) {
    auto &means = at.relaxation.means;
    const std::size_t first = first_of_six(mean);
    store_six(d, relax(d, at.relaxation.shares, means, first, stress), means.faded.data() + first);
}

template <template <class> class Energy, template <bool, class> class Means, class T>
HWY_NOINLINE void relax_means_around_nodes(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    Means<false, T> means(at, now, slice);
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(D())) {
        const std::size_t volume = static_cast<std::size_t>(slice) * slice_size + lane;
        const auto modulus = hn::Load(D(), at.body.coupled_modulus.data() + volume);
        const Energy<D> energy(D(), modulus, means.mean(lane).tensor, at.least_stretch);
        relax_mean(D(), at, volume, energy.isochoric_stress(D()));
    }
}

template <template <class> class Energy, template <class> class Means, class T>
HWY_NOINLINE void relax_means_around_edges(StepWorkspace<T> &at, int slice) {
    using D = Lanes<T>;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(D())) {
        const std::size_t edge = static_cast<std::size_t>(slice) * slice_size + lane;
        const auto mean = mean_around_edges<Means>(D(), at.body, at.tetrahedron_strain, slice, lane);
        const Energy<D> energy(D(), hn::Load(D(), at.body.edge_modulus.data() + edge),
                               Means<D>::OfTensor::twice_strain(mean), at.least_stretch);
        relax_mean(D(), at, edge, energy.isochoric_stress(D()));
    }
}

/// V g_i . R g_j of the edges of a tetrahedron, see RelaxationArrays::pull.
template <class D> HWY_INLINE Symmetric<D> pulls_of(const Symmetric<D> &faded, const OfCorners<D> &rest) {
    const auto pull_a = product<D>(faded, rest.a), pull_b = product<D>(faded, rest.b),
               pull_c = product<D>(faded, rest.c);
    const auto ab = dot(rest.a, pull_b), bc = dot(rest.b, pull_c), ca = dot(rest.c, pull_a);
    // The gradients sum to zero, and so do what they pull with.
    const auto from_start = [&](const hn::Vec<D> &own, const hn::Vec<D> &one, const hn::Vec<D> &other)
                                HWY_ATTR { return hn::Neg(hn::Add(own, hn::Add(one, other))); };
    return {from_start(dot(rest.a, pull_a), ab, ca),
            from_start(dot(rest.b, pull_b), ab, bc),
            from_start(dot(rest.c, pull_c), bc, ca),
            ab,
            bc,
            ca};
}

/// The stresses inside the tetrahedra of a slice of fans, and what they make nodes pull each other with.
template <template <class> class Energy, class T>
HWY_NOINLINE void relax_tetrahedra(StepWorkspace<T> &at, int now, int slice) {
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
            const Energy<D> energy(D(), hn::Load(d, body.inner_modulus.data() + t),
                                   twice_strain(D(), gradient<D>({axis, from, to}, rest)), at.least_stretch);
            const std::size_t first = first_of_six(t);
            const auto faded =
                relax(D(), at.relaxation.shares, at.relaxation.tetrahedra, first, energy.isochoric_stress(D()));
            if (has_pulls)
                store_six(D(), pulls_of<D>(faded, rest), at.relaxation.pull.data() + first);
            else
                store_six(D(), faded, at.relaxation.tetrahedra.faded.data() + first);
            from = to;
        }
    }
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
    const auto [first, last] = at.volume_slices[thread];
    const auto begin = static_cast<std::size_t>(body.mean_start[first]) * slice_size,
               end = static_cast<std::size_t>(body.mean_start[last]) * slice_size;
    for (std::size_t line = begin; line < end; line += slice_size)
        for (std::size_t lane = 0; lane < slice_size; ++lane)
            body.mean_gradient[4 * line + 3 * slice_size + lane] = stiffness_of_pair(at.relaxation, line + lane);
}

/// Moves the branches of springs around nodes or edges, with means of C or F: see StepFunctions::relax.
template <template <class> class Energy, class T>
void relax_coupled(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) {
    const auto &body = at.body;
    const auto &fans = at.fan_slices[thread], &volumes = at.volume_slices[thread];
    if (body.is_around_edges()) {
        const bool is_of_f = body.measure == StrainMeasure::deformation_gradient;
        const auto put_strains =
            is_of_f ? fan_strains<false, Energy, FanStrainsOfF, T> : fan_strains<false, Energy, FanStrainsOfC, T>;
        const auto relax_slice = is_of_f ? relax_means_around_edges<Energy, EdgeMeansOfF, T>
                                         : relax_means_around_edges<Energy, EdgeMeansOfC, T>;
        for (int slice = fans.first; slice < fans.last; ++slice)
            put_strains(at, now, slice);
        barrier.wait();
        for (int slice = at.edge_slices[thread].first; slice < at.edge_slices[thread].last; ++slice)
            relax_slice(at, slice);
    } else if (!body.mean_gradient.empty()) {
        for (int slice = volumes.first; slice < volumes.last; ++slice)
            relax_means_around_nodes<Energy, MeansOfF>(at, now, slice);
    } else {
        for (int slice = fans.first; slice < fans.last; ++slice)
            fan_strains<false, Energy, CornerStrains>(at, now, slice);
        barrier.wait();
        for (int slice = volumes.first; slice < volumes.last; ++slice)
            relax_means_around_nodes<Energy, MeansOfC>(at, now, slice);
    }
    for (int slice = fans.first; slice < fans.last; ++slice)
        relax_tetrahedra<Energy>(at, now, slice);
    if (at.relaxation.pull.empty())
        return;
    barrier.wait();
    add_pulls(at, thread);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_COUPLED_RELAXATION_INL_HPP
