// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/simd/scaled_mass_parts.cpp"
#include <hwy/foreach_target.h> // has to come before highway.h
#include <stdexcept>

#include "core/support/vector_dispatch.hpp"
#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

template <class D, class T> HWY_INLINE Vec3<D> load(D d, const T *field, std::size_t size, std::size_t i) {
    return {hn::Load(d, field + i), hn::Load(d, field + size + i), hn::Load(d, field + 2 * size + i)};
}

template <class D, class T> HWY_INLINE void store(D d, const Vec3<D> &v, T *field, std::size_t size, std::size_t i) {
    hn::Store(v.x, d, field + i);
    hn::Store(v.y, d, field + size + i);
    hn::Store(v.z, d, field + 2 * size + i);
}

template <class D> HWY_INLINE Vec3<D> everywhere(D d, const core::Vector3 &v) {
    using T = hn::TFromD<D>;
    return {hn::Set(d, static_cast<T>(v.x())), hn::Set(d, static_cast<T>(v.y())), hn::Set(d, static_cast<T>(v.z()))};
}

/// Sum of the lanes, in one order on every machine with as many of them.
template <class D> HWY_INLINE double lane_sum(D d, hn::Vec<D> v) {
    HWY_ALIGN hn::TFromD<D> lanes[64 / sizeof(hn::TFromD<D>)];
    hn::Store(v, d, lanes);
    double sum = 0.0;
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane)
        sum += double{lanes[lane]};
    return sum;
}

template <class D> HWY_INLINE core::Vector3 lane_sums(D d, const Vec3<D> &v) {
    return {lane_sum(d, v.x), lane_sum(d, v.y), lane_sum(d, v.z)};
}

/// Rows of a sum of p q^T.
template <class D> struct Moment { Vec3<D> x, y, z; };

template <class D> HWY_INLINE void add_product(Moment<D> &moment, const Vec3<D> &p, const Vec3<D> &q) {
    moment.x = plus_scaled<D>(moment.x, p.x, q);
    moment.y = plus_scaled<D>(moment.y, p.y, q);
    moment.z = plus_scaled<D>(moment.z, p.z, q);
}

template <class D> HWY_INLINE Eigen::Matrix3d lane_sums(D d, const Moment<D> &moment) {
    Eigen::Matrix3d sums;
    sums.row(0) = lane_sums(d, moment.x);
    sums.row(1) = lane_sums(d, moment.y);
    sums.row(2) = lane_sums(d, moment.z);
    return sums;
}

/// A matrix times vectors.
template <class D> struct Turn {
    Vec3<D> x, y, z; ///< columns

    Turn(D d, const Eigen::Matrix3d &matrix)
        : x(everywhere(d, matrix.col(0))), y(everywhere(d, matrix.col(1))), z(everywhere(d, matrix.col(2))) {}
    HWY_INLINE Vec3<D> times(const Vec3<D> &v) const {
        return plus_scaled<D>(plus_scaled<D>(scaled<D>(v.x, x), v.y, y), v.z, z);
    }
};

template <class T> ScaledMassSums sums_of(const ScaledMassArrays<T> &part) {
    using D = Lanes<T>;
    constexpr D d;
    const auto none = everywhere(d, core::Vector3::Zero());
    auto sum_x = none, sum_v = none, sum_a = none, x_cross_a = none;
    Moment<D> x_and_x{none, none, none}, x_and_rest = x_and_x, x_and_v = x_and_x;
    for (std::size_t i = 0; i < part.size; i += hn::Lanes(d)) {
        const auto m = hn::Load(d, part.mass.data() + i);
        const auto x = load(d, part.x.data(), part.size, i), v = load(d, part.v.data(), part.size, i),
                   a = load(d, part.a.data(), part.size, i);
        const auto weighted = scaled<D>(m, x);
        sum_x = plus<D>(sum_x, weighted);
        sum_v = plus_scaled<D>(sum_v, m, v);
        sum_a = plus_scaled<D>(sum_a, m, a);
        x_cross_a = plus<D>(x_cross_a, cross<D>(weighted, a));
        add_product<D>(x_and_x, weighted, x);
        add_product<D>(x_and_rest, weighted, load(d, part.rest.data(), part.size, i));
        add_product<D>(x_and_v, weighted, v);
    }
    return {.sum_x = lane_sums(d, sum_x),
            .sum_v = lane_sums(d, sum_v),
            .sum_a = lane_sums(d, sum_a),
            .x_and_x = lane_sums(d, x_and_x),
            .x_and_rest = lane_sums(d, x_and_rest),
            .x_and_v = lane_sums(d, x_and_v),
            .x_cross_a = lane_sums(d, x_cross_a)};
}

/// sum of m slow_k . field of each; four at a time, so that the field is read less often.
template <class T> void weigh(const ScaledMassArrays<T> &part, const T *field, std::vector<double> &weights) {
    using D = Lanes<T>;
    constexpr D d;
    const std::size_t length = 3 * part.size;
    std::size_t k = 0;
    for (; k + 4 <= part.num_slow; k += 4) {
        const T *slow = part.slow.data() + k * length;
        auto first = hn::Zero(d), second = first, third = first, fourth = first;
        for (std::size_t i = 0; i < length; i += hn::Lanes(d)) {
            const auto value = hn::Load(d, field + i);
            first = hn::MulAdd(hn::Load(d, slow + i), value, first);
            second = hn::MulAdd(hn::Load(d, slow + length + i), value, second);
            third = hn::MulAdd(hn::Load(d, slow + 2 * length + i), value, third);
            fourth = hn::MulAdd(hn::Load(d, slow + 3 * length + i), value, fourth);
        }
        weights[k] = lane_sum(d, first);
        weights[k + 1] = lane_sum(d, second);
        weights[k + 2] = lane_sum(d, third);
        weights[k + 3] = lane_sum(d, fourth);
    }
    for (; k < part.num_slow; ++k) {
        auto sum = hn::Zero(d);
        for (std::size_t i = 0; i < length; i += hn::Lanes(d))
            sum = hn::MulAdd(hn::Load(d, part.slow.data() + k * length + i), hn::Load(d, field + i), sum);
        weights[k] = lane_sum(d, sum);
    }
}

template <class T>
void strays_of(ScaledMassArrays<T> &part, const ScaledMassMotion &motion, std::vector<double> &weights) {
    using D = Lanes<T>;
    constexpr D d;
    const auto centre = everywhere(d, motion.centre), velocity = everywhere(d, motion.velocity),
               rotation = everywhere(d, motion.rotation), acceleration = everywhere(d, motion.acceleration),
               spin_up = everywhere(d, motion.spin_up);
    const auto two = hn::Set(d, T(2));
    const Turn<D> back(d, motion.turn.transpose());
    for (std::size_t i = 0; i < part.size; i += hn::Lanes(d)) {
        const auto x = minus<D>(load(d, part.x.data(), part.size, i), centre);
        const auto relative = scaled<D>(two, minus<D>(load(d, part.v.data(), part.size, i), velocity));
        const auto turning = cross<D>(rotation, minus<D>(relative, cross<D>(rotation, x)));
        const auto rigid = plus<D>(acceleration, cross<D>(spin_up, x));
        const auto stray = minus<D>(load(d, part.a.data(), part.size, i), plus<D>(turning, rigid));
        store(d, x, part.x.data(), part.size, i);
        store(d, stray, part.stray.data(), part.size, i);
        // a is not looked at any more: its place is that of m turn^T stray.
        const auto m = hn::Load(d, part.mass.data() + i);
        if (part.num_slow > 0)
            store(d, scaled<D>(m, back.times(stray)), part.a.data(), part.size, i);
    }
    weigh(part, part.a.data(), weights);
}

template <class T>
SlowMomenta less_slow(ScaledMassArrays<T> &part, const Eigen::Matrix3d &turned_by, const std::vector<double> &weights) {
    using D = Lanes<T>;
    constexpr D d;
    const Turn<D> turn(d, turned_by);
    auto linear = everywhere(d, core::Vector3::Zero()), angular = linear;
    for (std::size_t i = 0; i < part.size; i += hn::Lanes(d)) {
        auto sum = everywhere(d, core::Vector3::Zero());
        const T *slow = part.slow.data();
        for (std::size_t k = 0; k < part.num_slow; ++k, slow += 3 * part.size)
            sum = plus_scaled<D>(sum, hn::Set(d, static_cast<T>(weights[k])), load(d, slow, part.size, i));
        const auto deforming = turn.times(sum);
        const auto weighted = scaled<D>(hn::Load(d, part.mass.data() + i), deforming);
        linear = plus<D>(linear, weighted);
        angular = plus<D>(angular, cross<D>(load(d, part.x.data(), part.size, i), weighted));
        store(d, minus<D>(load(d, part.stray.data(), part.size, i), deforming), part.stray.data(), part.size, i);
    }
    return {lane_sums(d, linear), lane_sums(d, angular)};
}

ScaledMassFunctions<float> functions_of_float() {
    return {sums_of<float>, strays_of<float>, less_slow<float>};
}
ScaledMassFunctions<double> functions_of_double() {
#if HWY_HAVE_FLOAT64
    return {sums_of<double>, strays_of<double>, less_slow<double>};
#else
    throw std::logic_error("masses in double precision need vectors of float64, which are not there");
#endif
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::msm {

LIVERMARK_DISPATCH(template <> ScaledMassFunctions<float> scaled_mass_functions, functions_of_float, (), ())
LIVERMARK_DISPATCH(template <> ScaledMassFunctions<double> scaled_mass_functions, functions_of_double, (), ())

} // namespace livermark::msm
#endif
