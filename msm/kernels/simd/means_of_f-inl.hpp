// Means around nodes of the deformation gradient. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_MEANS_OF_F_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_MEANS_OF_F_INL_HPP
#undef LIVERMARK_MEANS_OF_F_INL_HPP
#else
#define LIVERMARK_MEANS_OF_F_INL_HPP
#endif

#include <algorithm>
#include <array>

#include "msm/kernels/simd/biquadratic_springs-inl.hpp"
#include "msm/kernels/simd/nodal_springs-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

template <class D> HWY_INLINE Columns<D> plus(const Columns<D> &a, const Columns<D> &b) {
    return {plus(a.x, b.x), plus(a.y, b.y), plus(a.z, b.z)};
}

/// Of a slice of control volumes, the means of F of neo-Hookean springs, and what becomes of their stresses. A mean is
/// a sum over the neighbours of a node (mean_gradients.hpp), so tetrahedra put down nothing but the volume that they
/// gain.
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
        f_ = mean_gradient(at_.rows[now_].data(), lane);
        return {twice_strain(D(), f_), of_volume(at_.gain, lane)};
    }
    /// beta times how fast both grow; called behind mean().
    HWY_INLINE SymmetricAndMore<D> rate(std::size_t lane) const {
        const auto beta = hn::Set(D(), static_cast<T>(at_.beta));
        const auto of_f = mean_gradient(at_.velocity_rows[now_].data(), lane);
        return {scaled<D>(beta, twice_strain_rate<D>(f_, of_f)), of_volume(at_.gain_rate, lane)};
    }

    /// @param stress  a quarter of the second stress of Piola and Kirchhoff; called behind mean()
    HWY_INLINE void store(const Symmetric<D> &stress, std::size_t first_volume, StepWorkspace<T> &at) const {
        const auto p = product<D>(f_, stress);
        store_column(p.x, first_volume, at.body, at.stress[0]);
        store_column(p.y, first_volume, at.body, at.stress[1]);
        store_column(p.z, first_volume, at.body, at.stress[2]);
    }

    // What the fans make of it.
    using Stress = Columns<D>;
    HWY_INLINE static Stress fetch_at(const StepWorkspace<T> &at, const std::int32_t *corner) {
        return {fetch_column(at.stress[0], corner), fetch_column(at.stress[1], corner),
                fetch_column(at.stress[2], corner)};
    }
    /// V P + mu F
    HWY_INLINE static Columns<D> first_stress(const Columns<D> &f, hn::Vec<D> rest_volume, const Stress &sum,
                                              hn::Vec<D> inside) {
        return {plus_scaled<D>(scaled<D>(rest_volume, sum.x), inside, f.x),
                plus_scaled<D>(scaled<D>(rest_volume, sum.y), inside, f.y),
                plus_scaled<D>(scaled<D>(rest_volume, sum.z), inside, f.z)};
    }

  private:
    HWY_INLINE Columns<D> mean_gradient(const T *rows, std::size_t lane) const {
        const auto &body = at_.body;
        const auto middle = fetch(D(), rows, middle_.data() + lane);
        const auto zero = hn::Zero(D());
        Columns<D> f{{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
        const std::size_t end = static_cast<std::size_t>(body.mean_start[volume_slice_ + 1]) * slice_size;
        for (std::size_t m = static_cast<std::size_t>(body.mean_start[volume_slice_]) * slice_size; m < end;
             m += slice_size) {
            const auto span = difference(fetch(D(), rows, body.mean_node.data() + m + lane), middle);
            const T *gradient = body.mean_gradient.data() + 3 * m + lane;
            f.x = plus_scaled<D>(f.x, hn::Load(D(), gradient), span);
            f.y = plus_scaled<D>(f.y, hn::Load(D(), gradient + slice_size), span);
            f.z = plus_scaled<D>(f.z, hn::Load(D(), gradient + 2 * slice_size), span);
        }
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

    HWY_INLINE static void store_column(const Vec3<D> &column, std::size_t first_volume, const SlicedBody<T> &body,
                                        Aligned<T> &to) {
        HWY_ALIGN std::array<T, 4 * slice_size> fours;
        hn::StoreInterleaved4(column.x, column.y, column.z, hn::Zero(D()), D(), fours.data());
        for (std::size_t i = 0; i < hn::Lanes(D()); ++i)
            std::copy_n(fours.data() + 4 * i, 4,
                        to.data() + 4 * static_cast<std::size_t>(body.volume_row[first_volume + i]));
    }
    HWY_INLINE static Vec3<D> fetch_column(const Aligned<T> &from, const std::int32_t *corner) {
        const auto column = fetch(D(), from.data(), corner);
        return {column.x, column.y, column.z};
    }

    const StepWorkspace<T> &at_;
    int now_, volume_slice_;
    alignas(64) std::array<std::int32_t, slice_size> middle_; ///< indices of the nodes in the middle
    Columns<D> f_;
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_MEANS_OF_F_INL_HPP
