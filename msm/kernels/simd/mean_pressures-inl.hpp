// Means of changes of volume, and the pressures that they make. Written once for each vector unit: see take_steps.cpp.
#if defined(LIVERMARK_MEAN_PRESSURES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_MEAN_PRESSURES_INL_HPP
#undef LIVERMARK_MEAN_PRESSURES_INL_HPP
#else
#define LIVERMARK_MEAN_PRESSURES_INL_HPP
#endif

#include <algorithm>

#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Numbers at scattered indices.
template <class D, class T> HWY_INLINE hn::Vec<D> gather(D d, const T *values, const std::int32_t *index) {
    const auto indices = hn::Load(hn::Rebind<std::int32_t, D>(), index);
    if constexpr (sizeof(T) == 4)
        return hn::GatherIndex(d, values, indices);
    else
        return hn::GatherIndex(d, values, hn::PromoteTo(hn::RebindToSigned<D>(), indices));
}

/// Sixteen rows of a matrix times a vector.
template <class T>
HWY_INLINE void multiply(const SlicedMatrix<T> &matrix, const Aligned<T> &vector, int slice, T *result) {
    using D = Lanes<T>;
    constexpr D d;
    const std::size_t first = static_cast<std::size_t>(matrix.offset[slice]) * slice_size;
    const std::size_t end = static_cast<std::size_t>(matrix.offset[slice + 1]) * slice_size;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        auto sum = hn::Zero(d);
        for (std::size_t m = first + lane; m < end; m += slice_size)
            sum = hn::MulAdd(hn::Load(d, matrix.value.data() + m), gather(D(), vector.data(), matrix.column.data() + m),
                             sum);
        hn::Store(sum, d, result + lane);
    }
}

/// Puts the pressures of 16 control volumes into their rows.
template <class T> HWY_INLINE void set_pressures(StepWorkspace<T> &at, int now, int slice, const T *pressure) {
    const int *row = at.body.volume_row.data() + static_cast<std::ptrdiff_t>(slice) * slice_size;
    for (int i = 0; i < slice_size; ++i)
        at.rows[now][4 * static_cast<std::size_t>(row[i]) + 3] = pressure[i];
}

/// Makes a quarter of the pressures in 16 control volumes of what the tetrahedra there have gained, or keeps that where
/// a mean of it is resisted.
template <class T> HWY_INLINE void set_gains(StepWorkspace<T> &at, int now, int slice, const T *gain) {
    constexpr Lanes<T> d;
    const std::size_t first = static_cast<std::size_t>(slice) * slice_size;
    if (!at.change.empty()) {
        std::copy_n(gain, slice_size, at.change.begin() + static_cast<std::ptrdiff_t>(first));
        return;
    }
    HWY_ALIGN T pressure[slice_size];
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d))
        hn::Store(hn::Mul(hn::Mul(hn::Load(d, gain + lane), hn::Set(d, T(0.25))),
                          hn::Load(d, at.body.volume_stiffness.data() + first + lane)),
                  d, pressure + lane);
    set_pressures(at, now, slice, pressure);
}

/// Means of relative changes in 16 control volumes.
template <class T> HWY_INLINE void mean_changes(StepWorkspace<T> &at, int slice) {
    multiply(at.body.mean_change, at.change, slice,
             at.mean_change.data() + static_cast<std::size_t>(slice) * slice_size);
}

/// A quarter of the pressures that they make.
template <class T> HWY_INLINE void mean_pressures(StepWorkspace<T> &at, int now, int slice) {
    HWY_ALIGN T pressure[slice_size];
    multiply(at.body.mean_pressure, at.mean_change, slice, pressure);
    set_pressures(at, now, slice, pressure);
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_MEAN_PRESSURES_INL_HPP
