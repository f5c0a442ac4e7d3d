// Means around nodes, of the Cauchy-Green tensor and the deformation gradient. Written once for
// each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_MEANS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_MEANS_INL_HPP
#undef LIVERMARK_MEANS_INL_HPP
#else
#define LIVERMARK_MEANS_INL_HPP
#endif

#include <algorithm>
#include <array>

#include "msm/kernels/simd/fan_forces-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// A strain or a stress, and another number, from eight numbers behind each other.
template <class D> struct SymmetricAndMore {
    Symmetric<D> tensor;
    hn::Vec<D> more;
};
/// Puts stresses down in the rows of control volumes behind each other, where fetch_stress() finds them.
template <class D, class T>
HWY_INLINE void store_stress(D d, const Symmetric<D> &stress, std::size_t first_volume, StepWorkspace<T> &at) {
    HWY_ALIGN std::array<T, 4 * slice_size> first_four, other_two;
    const auto &[xx, yy, zz, xy, yz, zx] = stress;
    hn::StoreInterleaved4(xx, yy, zz, xy, d, first_four.data());
    hn::StoreInterleaved4(yz, zx, hn::Zero(d), hn::Zero(d), d, other_two.data());
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
        const auto row = 4 * static_cast<std::size_t>(at.body.volume_row[first_volume + i]);
        std::copy_n(first_four.data() + 4 * i, 4, at.stress[0].data() + row);
        std::copy_n(other_two.data() + 4 * i, 4, at.stress[1].data() + row);
    }
}

/// Stress at a node of a fan.
template <class D, class T>
HWY_INLINE Symmetric<D> fetch_stress(D d, const StepWorkspace<T> &at, const std::int32_t *corner) {
    const auto a = fetch(d, at.stress[0].data(), corner), b = fetch(d, at.stress[1].data(), corner);
    return {a.x, a.y, a.z, a.w, b.x, b.y};
}

/// Twice a strain, times a volume, and a volume gained. Sums of them over the tetrahedra at a corner of a fan.
template <class D> HWY_INLINE SymmetricAndMore<D> plus(const SymmetricAndMore<D> &a, const SymmetricAndMore<D> &b) {
    return {plus<D>(a.tensor, b.tensor), hn::Add(a.more, b.more)};
}
template <class D, class T>
HWY_INLINE void store(D d, const SymmetricAndMore<D> &value, std::array<Aligned<T>, 2> &at, std::size_t corner) {
    const auto &[xx, yy, zz, xy, yz, zx] = value.tensor;
    hn::StoreInterleaved4(xx, yy, zz, xy, d, at[0].data() + 4 * corner);
    hn::StoreInterleaved4(yz, zx, value.more, hn::Zero(d), d, at[1].data() + 4 * corner);
}

/// Values of the tetrahedra of a fan, put down at its corners as sums over those that meet there.
template <class D> struct CornerSums {
    SymmetricAndMore<D> before, sum;

    HWY_INLINE explicit CornerSums(D d)
        : before{{hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)}, hn::Zero(d)},
          sum(before) {}

    template <class T>
    HWY_INLINE void add(D d, const SymmetricAndMore<D> &value, std::array<Aligned<T>, 2> &at, std::size_t rim_corner) {
        store(d, plus<D>(before, value), at, rim_corner);
        sum = plus<D>(sum, value);
        before = value;
    }
    template <class T>
    HWY_INLINE void finish(D d, std::array<Aligned<T>, 2> &at, std::size_t first_corner,
                           std::size_t last_rim_corner) const {
        store(d, before, at, last_rim_corner);
        store(d, sum, at, first_corner);
        store(d, sum, at, first_corner + slice_size);
    }
};

/// Place of a tetrahedron on the lines, and of the node of the rim between it and the one before.
struct TetrahedronInFan {
    std::size_t tetrahedron, rim;
};

/// Strains of the tetrahedra of a fan at its corners, for the means around nodes, with the volumes that they gain.
template <bool is_damped, class T> class CornerStrains {
    using D = Lanes<T>;

  public:
    HWY_INLINE explicit CornerStrains(D d) : strains_(d), growth_(d) {}

    HWY_INLINE void add(StepWorkspace<T> &at, const TetrahedronInFan &place, const Columns<D> &f,
                        hn::Vec<D> rest_volume, hn::Vec<D> gained) {
        strains_.add(D(), {scaled<D>(rest_volume, twice_strain(D(), f)), gained}, at.corner_strain, place.rim);
    }
    /// @param factor  beta times the volume at rest
    HWY_INLINE void add_rates(StepWorkspace<T> &at, const TetrahedronInFan &place, const Columns<D> &f,
                              const Columns<D> &f_rate, hn::Vec<D> factor, hn::Vec<D> gained) {
        growth_.add(D(), {scaled<D>(factor, twice_strain_rate<D>(f, f_rate)), gained}, at.corner_rate, place.rim);
    }
    HWY_INLINE void finish(StepWorkspace<T> &at, std::size_t corner, std::size_t rim) const {
        strains_.finish(D(), at.corner_strain, corner, rim);
        if constexpr (is_damped)
            growth_.finish(D(), at.corner_rate, corner, rim);
    }

  private:
    CornerSums<D> strains_, growth_;
};

/// Strains of the fans of a slice, for the means, and the push of springs inside.
/// @tparam Strains  of a fan, CornerStrains or FanStrains: where they go
template <bool is_damped, template <class> class Energy, template <bool, class> class Strains, class T>
HWY_NOINLINE void fan_strains(StepWorkspace<T> &at, int now, int slice) {
    using D = Lanes<T>;
    constexpr D d;
    const auto &body = at.body;
    const auto sixth = hn::Set(d, T(1.0 / 6.0));
    LargestDeficit<D> largest{D()};
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const FanLines lines(body, slice, lane);
        FanWalk<is_damped, T> fan(at, now, body.corner.data() + lines.corner);
        std::size_t rim = lines.corner + 2 * slice_size;
        Strains<is_damped, T> strains(d);
        for (std::size_t t = lines.first; t < lines.end; t += slice_size, rim += slice_size) {
            fan.next();
            const auto rest = rest_gradients(D(), body, t, lane);
            const auto f = gradient<D>({fan.axis.direction, fan.from.arm, fan.to.arm}, rest);
            const auto rest_volume = hn::Load(d, body.rest_volume.data() + t);
            const auto share = hn::Load(d, body.volume_share.data() + t);
            const auto volume = hn::Mul(share, dot(fan.from.lever, fan.to.arm));
            put_push_inside<Energy>(D(), at, volume, t, largest);
            strains.add(at, {t, rim}, f, rest_volume, hn::MulSub(volume, sixth, rest_volume));
            if constexpr (is_damped) {
                const auto before = fan.rates;
                const auto damped = hn::Mul(share, fan.volume(at, now));
                const auto rate = gradient<D>({fan.rates.axis, before.arm, fan.rates.arm}, rest);
                const auto factor = hn::Mul(hn::Set(d, static_cast<T>(at.beta)), rest_volume);
                strains.add_rates(at, {t, rim}, f, rate, factor, hn::Mul(hn::Sub(damped, volume), sixth));
            }
        }
        strains.finish(at, lines.corner, rim);
    }
    largest.keep(D(), at, slice);
}

/// Sums over the corners of fans in 16 control volumes: eight numbers for each.
template <class T>
HWY_INLINE void sum_of_corners(const StepWorkspace<T> &at, const std::array<Aligned<T>, 2> &corners, int volume_slice,
                               T *first_four, T *other_four) {
    constexpr hn::CappedTag<T, 4> four;
    const auto &body = at.body;
    const std::size_t first = static_cast<std::size_t>(body.volume_start[volume_slice]) * slice_size;
    const std::size_t end = static_cast<std::size_t>(body.volume_start[volume_slice + 1]) * slice_size;
    // Four rows and both parts of them at once, because each sum has to wait for the one before.
    for (std::size_t row = 0; row < slice_size; row += 4)
        for (std::size_t part = 0; part < 4; part += hn::Lanes(four)) {
            const T *one = corners[0].data() + part, *other = corners[1].data() + part;
            const auto *member = body.member.data() + row;
            auto a = hn::Zero(four), b = a, c = a, e = a, p = a, q = a, r = a, s = a;
            for (std::size_t m = first; m < end; m += slice_size) {
                a = hn::Add(a, hn::LoadU(four, one + member[m]));
                p = hn::Add(p, hn::LoadU(four, other + member[m]));
                b = hn::Add(b, hn::LoadU(four, one + member[m + 1]));
                q = hn::Add(q, hn::LoadU(four, other + member[m + 1]));
                c = hn::Add(c, hn::LoadU(four, one + member[m + 2]));
                r = hn::Add(r, hn::LoadU(four, other + member[m + 2]));
                e = hn::Add(e, hn::LoadU(four, one + member[m + 3]));
                s = hn::Add(s, hn::LoadU(four, other + member[m + 3]));
            }
            T *sum = first_four + 4 * row + part, *other_sum = other_four + 4 * row + part;
            hn::StoreU(a, four, sum);
            hn::StoreU(b, four, sum + 4);
            hn::StoreU(c, four, sum + 8);
            hn::StoreU(e, four, sum + 12);
            hn::StoreU(p, four, other_sum);
            hn::StoreU(q, four, other_sum + 4);
            hn::StoreU(r, four, other_sum + 8);
            hn::StoreU(s, four, other_sum + 12);
        }
}

/// From two times four numbers of each of some nodes behind each other.
template <class D, class T> HWY_INLINE SymmetricAndMore<D> load_both(D d, const T *first_four, const T *other_four) {
    hn::Vec<D> xx, yy, zz, xy, yz, zx, more, nothing;
    hn::LoadInterleaved4(d, first_four, xx, yy, zz, xy);
    hn::LoadInterleaved4(d, other_four, yz, zx, more, nothing);
    return {{xx, yy, zz, xy, yz, zx}, more};
}

/// Means of C in a slice of control volumes, and what becomes of their stresses.
template <bool is_damped, class T> class MeansOfC {
    using D = Lanes<T>;

  public:
    HWY_INLINE MeansOfC(const StepWorkspace<T> &at, int /*now*/, int volume_slice)
        : inverse_volume_(at.body.inverse_volume.data() + static_cast<std::size_t>(volume_slice) * slice_size) {
        sum_of_corners(at, at.corner_strain, volume_slice, strain_[0].data(), strain_[1].data());
        if constexpr (is_damped)
            sum_of_corners(at, at.corner_rate, volume_slice, rate_[0].data(), rate_[1].data());
    }

    /// C - I, and the relative change of volume, of those from `lane` on.
    HWY_INLINE SymmetricAndMore<D> mean(std::size_t lane) { return over_volume(strain_, lane); }
    /// beta times how fast both grow; called behind mean().
    HWY_INLINE SymmetricAndMore<D> rate(std::size_t lane) { return over_volume(rate_, lane); }

    /// @param stress  a quarter of the second stress of Piola and Kirchhoff
    HWY_INLINE void store(const Symmetric<D> &stress, std::size_t first_volume, StepWorkspace<T> &at) const {
        store_stress(D(), stress, first_volume, at);
    }

    using Stress = Symmetric<D>;
    HWY_INLINE static Stress fetch_at(const StepWorkspace<T> &at, const std::int32_t *corner) {
        return fetch_stress(D(), at, corner);
    }
    /// The first stress of Piola and Kirchhoff times the volume, of a sum over the corners and a pressure mu inside:
    /// F (V S + mu I).
    /// @param faded  what has relaxed of the stress inside, times the volume; null if nothing does
    HWY_INLINE static Columns<D> first_stress(const Columns<D> &f, hn::Vec<D> rest_volume, Stress sum,
                                              hn::Vec<D> inside, const T *faded) {
        sum = plus_identity<D>(scaled<D>(rest_volume, sum), inside);
        if (faded)
            sum = minus<D>(sum, load_six(D(), faded));
        return product<D>(f, sum);
    }

  private:
    using Sums = std::array<std::array<T, 4 * slice_size>, 2>;

    HWY_INLINE SymmetricAndMore<D> over_volume(const Sums &sums, std::size_t lane) const {
        const auto sum = load_both(D(), sums[0].data() + 4 * lane, sums[1].data() + 4 * lane);
        const auto inverse_volume = hn::Load(D(), inverse_volume_ + lane);
        return {scaled<D>(inverse_volume, sum.tensor), hn::Mul(inverse_volume, sum.more)};
    }

    const T *inverse_volume_;
    alignas(64) Sums strain_, rate_;
};

// Means around nodes of the deformation gradient.

/// Means of F in a slice of control volumes, and what becomes of their stresses. Both a
/// mean and its forces are sums over the neighbours of a node (slicing.hpp), so tetrahedra put down nothing but
/// the volume that they gain, and fetch nothing but positions and pressures.
template <bool is_damped, class T> class MeansOfF {
    using D = Lanes<T>;

  public:
    HWY_INLINE MeansOfF(const StepWorkspace<T> &at, int now, int volume_slice)
        : at_(at), now_(now), volume_slice_(volume_slice) {
        const int *row = at.body.volume_row.data() + static_cast<std::ptrdiff_t>(volume_slice) * slice_size;
        for (int i = 0; i < slice_size; ++i)
            middle_[i] = 4 * row[i];
    }

    /// C - I of the mean of F, and the relative change of volume, of those from `lane` on.
    HWY_INLINE SymmetricAndMore<D> mean(std::size_t lane) {
        f_ = mean_gradient<true>(at_.rows[now_].data(), lane);
        return {twice_strain(D(), f_), relative_change(at_.gain, lane)};
    }
    /// beta times how fast both grow; called behind mean().
    HWY_INLINE SymmetricAndMore<D> rate(std::size_t lane) {
        const auto beta = hn::Set(D(), static_cast<T>(at_.beta));
        const auto f_rate = mean_gradient<false>(at_.velocity_rows[now_].data(), lane);
        return {scaled<D>(beta, twice_strain_rate<D>(f_, f_rate)), relative_change(at_.gain_rate, lane)};
    }

    /// Puts down the forces: -P b on each neighbour with P = F S, and what is left on the node in the middle, with the
    /// pull of springs inside tetrahedra.
    /// @param stress  the second stress of Piola and Kirchhoff times the volume; called behind mean()
    HWY_INLINE void store(const Symmetric<D> &stress, std::size_t first_volume, StepWorkspace<T> &at) const {
        const auto &body = at.body;
        const auto zero = hn::Zero(D());
        const Vec3<D> nothing{zero, zero, zero};
        const auto p = product<D>(f_, stress);
        const Columns<D> push{minus(nothing, p.x), minus(nothing, p.y), minus(nothing, p.z)};
        auto in_middle = pull_;
        const std::size_t lane = first_volume % slice_size;
        T *places = at.corner_force.data() + 4 * (static_cast<std::size_t>(body.first_pull) + lane);
        for (std::size_t m = first(); m < end(); m += slice_size) {
            const T *gradient = body.mean_gradient.data() + 4 * m + lane;
            const auto force = combined<D>(hn::Load(D(), gradient), push.x, hn::Load(D(), gradient + slice_size),
                                           push.y, hn::Load(D(), gradient + 2 * slice_size), push.z);
            in_middle = minus(in_middle, force);
            hn::StoreInterleaved4(force.x, force.y, force.z, zero, D(), places + 4 * m);
        }
        const std::size_t volume = first_volume - lane + body.mean_node.size();
        hn::StoreInterleaved4(in_middle.x, in_middle.y, in_middle.z, zero, D(), places + 4 * volume);
    }

  private:
    HWY_INLINE std::size_t first() const {
        return static_cast<std::size_t>(at_.body.mean_start[volume_slice_]) * slice_size;
    }
    HWY_INLINE std::size_t end() const {
        return static_cast<std::size_t>(at_.body.mean_start[volume_slice_ + 1]) * slice_size;
    }

    /// @tparam with_pull  whether the pull of springs inside tetrahedra on the node in the middle is found too
    template <bool with_pull> HWY_INLINE Columns<D> mean_gradient(const T *rows, std::size_t lane) {
        const auto &body = at_.body;
        const auto middle = fetch(D(), rows, middle_.data() + lane);
        const auto zero = hn::Zero(D());
        const Vec3<D> nothing{zero, zero, zero};
        Columns<D> f{nothing, nothing, nothing};
        auto pull = nothing;
        for (std::size_t m = first(); m < end(); m += slice_size) {
            const auto span = difference(fetch(D(), rows, body.mean_node.data() + m + lane), middle);
            const T *gradient = body.mean_gradient.data() + 4 * m + lane;
            f.x = plus_scaled<D>(f.x, hn::Load(D(), gradient), span);
            f.y = plus_scaled<D>(f.y, hn::Load(D(), gradient + slice_size), span);
            f.z = plus_scaled<D>(f.z, hn::Load(D(), gradient + 2 * slice_size), span);
            if constexpr (with_pull)
                pull = plus_scaled<D>(pull, hn::Load(D(), gradient + 3 * slice_size), span);
        }
        if constexpr (with_pull)
            pull_ = pull;
        return f;
    }

    /// @param values  of the corners of fans
    HWY_INLINE hn::Vec<D> relative_change(const Aligned<T> &values, std::size_t lane) const {
        if (at_.body.volume_stiffness.empty())
            return hn::Zero(D());
        const std::size_t first = static_cast<std::size_t>(volume_slice_) * slice_size + lane;
        return hn::Mul(hn::Load(D(), at_.body.inverse_volume.data() + first),
                       sum_at_corners(D(), at_.body, values, volume_slice_, lane));
    }

    const StepWorkspace<T> &at_;
    int now_, volume_slice_;
    alignas(64) std::array<std::int32_t, slice_size> middle_; ///< indices of the nodes in the middle
    Columns<D> f_;
    Vec3<D> pull_;
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_MEANS_INL_HPP
