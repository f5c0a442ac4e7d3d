// Means around nodes of the deformation gradient. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_MEANS_OF_F_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_MEANS_OF_F_INL_HPP
#undef LIVERMARK_MEANS_OF_F_INL_HPP
#else
#define LIVERMARK_MEANS_OF_F_INL_HPP
#endif

#include <algorithm>
#include <array>

#include "msm/kernels/simd/green_strain-inl.hpp"
#include "msm/kernels/simd/nodal_springs-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

template <class D> HWY_INLINE Columns<D> plus(const Columns<D> &a, const Columns<D> &b) {
    return {plus(a.x, b.x), plus(a.y, b.y), plus(a.z, b.z)};
}

/// Of a slice of control volumes, the means of F of neo-Hookean springs, and what becomes of their stresses. Both a
/// mean and its forces are sums over the neighbours of a node (mean_gradients.hpp), so tetrahedra put down nothing but
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
        return {twice_strain(D(), f_), of_volume(at_.gain, lane)};
    }
    /// beta times how fast both grow; called behind mean().
    HWY_INLINE SymmetricAndMore<D> rate(std::size_t lane) {
        const auto beta = hn::Set(D(), static_cast<T>(at_.beta));
        const auto of_f = mean_gradient<false>(at_.velocity_rows[now_].data(), lane);
        return {scaled<D>(beta, twice_strain_rate<D>(f_, of_f)), of_volume(at_.gain_rate, lane)};
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

    static constexpr bool act_in_fans = false;

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
    HWY_INLINE hn::Vec<D> of_volume(const Aligned<T> &values, std::size_t lane) const {
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

#endif // LIVERMARK_MEANS_OF_F_INL_HPP
