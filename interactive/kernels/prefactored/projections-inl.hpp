// The nearest rotation and the nearest matrix of determinant one, by the gradient H of displacements, F = 1 + H,
// without singular values: single precision keeps the digits of small strains. Written once for each vector unit: see
// prefactored_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_PROJECTIONS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_PROJECTIONS_INL_HPP
#undef LIVERMARK_INTERACTIVE_PROJECTIONS_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_PROJECTIONS_INL_HPP
#endif

#include "interactive/kernels/neo_hookean-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

HWY_INLINE V trace_of(const Matrix &a) {
    return hn::Add(a.x.x, hn::Add(a.y.y, a.z.z));
}

/// A : B
HWY_INLINE V dot(const Matrix &a, const Matrix &b) {
    return hn::Add(dot(a.x, b.x), hn::Add(dot(a.y, b.y), dot(a.z, b.z)));
}

/// 2 tr A + |A|^2, that is |1 + A|^2 - 3.
HWY_INLINE V excess_of(const Matrix &a, V square) {
    return hn::MulAdd(number(2.0F), trace_of(a), square);
}

HWY_INLINE Matrix chosen(hn::Mask<D> lanes, const Matrix &a, const Matrix &b) {
    return {chosen(lanes, a.x, b.x), chosen(lanes, a.y, b.y), chosen(lanes, a.z, b.z)};
}

/// Of sums of invariants, with few digits to spare.
/// @param square  |H|^2
HWY_INLINE V left_by_rounding(V square) {
    return hn::Mul(number(2e-7F), hn::MulAdd(number(4.0F), square, hn::Sqrt(square)));
}

/// l = s_1 + s_2 + s_3 - 3 of the singular values of F, the last of them negative where det F is: the largest root less
/// 3 of
///     p^4 - 2 |F|^2 p^2 - 8 J p + |F|^4 - 4 |cof F|^2 = 0,
/// by Newton's method from above, sqrt(3) |F|, where the polynomial is convex.
/// (B. K. P. Horn 1987, J. Opt. Soc. Am. A 4(4), whose 4 x 4 matrix has this characteristic polynomial)
/// @param a, b     |F|^2 - 3 and |cof F|^2 - 3
/// @param growth   J - 1
/// @param smallest what rounding leaves of the root
HWY_INLINE V stretch_of(V a, V b, V growth, V smallest) {
    constexpr int most_iterations = 20;
    constexpr float part = 2e-4F; // of a change; the next one changes its square
    const auto c0 =
        hn::Sub(hn::Mul(a, hn::Sub(a, number(12.0F))), hn::MulAdd(number(24.0F), growth, hn::Mul(number(4.0F), b)));
    const auto c1 = hn::Sub(number(64.0F), hn::MulAdd(number(12.0F), a, hn::Mul(number(8.0F), growth)));
    const auto c2 = hn::NegMulAdd(number(2.0F), a, number(48.0F));
    const auto square = hn::MulAdd(number(3.0F), a, number(9.0F));
    auto l = hn::Div(hn::Mul(number(3.0F), a), hn::Add(hn::Sqrt(hn::Max(square, hn::Zero(d))), number(3.0F)));
    auto is_moving = hn::Ge(square, square); // not what is no number; a lane stays where it is once it has converged
    for (int i = 0; i < most_iterations; ++i) {
        const auto l12 = hn::Add(l, number(12.0F));
        const auto value = hn::MulAdd(l, hn::MulAdd(l, hn::MulAdd(l, l12, c2), c1), c0);
        const auto slope =
            hn::MulAdd(l, hn::MulAdd(l, hn::MulAdd(l, number(4.0F), number(36.0F)), hn::Add(c2, c2)), c1);
        const auto change = hn::Div(value, slope);
        l = hn::IfThenElse(is_moving, hn::Sub(l, change), l);
        is_moving = hn::And(is_moving, hn::Gt(hn::Abs(change), hn::MulAdd(number(part), hn::Abs(l), smallest)));
        if (hn::AllFalse(d, is_moving))
            break;
    }
    return l;
}

/// F - R with R the nearest rotation, from the derivative of p = tr S by F, which R is: with C = F^T F = 1 + 2 E,
///     R = ((p^2 + |F|^2) F + 2 p cof F - 2 F C) / (p^3 - |F|^2 p - 2 J),
/// and all of F - R in terms of H. The denominator is twice the product of the sums of two singular values each.
/// @param change  cof F - 1
HWY_INLINE Matrix beyond_rotation(const Matrix &h, const Matrix &change, V growth, V square) {
    const auto a = excess_of(h, square), b = excess_of(change, dot(change, change));
    const auto l = stretch_of(a, b, growth, left_by_rounding(square));
    const auto l2 = hn::Mul(l, l);
    const auto al = hn::Mul(a, l);
    const auto cubic = hn::MulSub(l2, l, al);
    const auto two = number(2.0F);
    const auto twice_growth = hn::Add(growth, growth);
    const auto of_one = hn::MulAdd(
        number(16.0F), l, hn::Sub(hn::MulAdd(number(8.0F), l2, cubic), hn::MulAdd(number(4.0F), a, twice_growth)));
    const auto denominator = hn::MulAdd(number(24.0F), l,
                                        hn::Add(number(16.0F), hn::Sub(hn::MulAdd(number(9.0F), l2, cubic),
                                                                       hn::MulAdd(number(3.0F), a, twice_growth))));
    constexpr float smallest = 1e-4F; // where two singular values cancel, no rotation is the nearest
    const auto inverse = hn::Div(number(1.0F), hn::Max(denominator, number(smallest)));
    const auto two_p = hn::MulAdd(two, l, number(6.0F));
    // 2 E = H + H^T + H^T H
    const auto xx = hn::MulAdd(two, h.x.x, dot(h.x, h.x)), yy = hn::MulAdd(two, h.y.y, dot(h.y, h.y)),
               zz = hn::MulAdd(two, h.z.z, dot(h.z, h.z));
    const auto xy = hn::Add(hn::Add(h.y.x, h.x.y), dot(h.x, h.y)), yz = hn::Add(hn::Add(h.z.y, h.y.z), dot(h.y, h.z)),
               zx = hn::Add(hn::Add(h.x.z, h.z.x), dot(h.z, h.x));
    const Matrix e{{xx, xy, zx}, {xy, yy, yz}, {zx, yz, zz}};
    const auto of_h = hn::Add(of_one, two_p);
    const auto column = [&](const Vec3 &of, const Vec3 &of_change, const Vec3 &of_e) HWY_ATTR {
        const auto turned = of_e + combined(of_e.x, h.x, of_e.y, h.y, of_e.z, h.z); // F 2 E
        const auto entry = [&](V of_h_here, V of_change_here, V of_turned) HWY_ATTR {
            const auto rest = hn::MulSub(two, of_turned, hn::Mul(two_p, of_change_here));
            return hn::Mul(inverse, hn::MulAdd(of_h, of_h_here, rest));
        };
        return Vec3{entry(of.x, of_change.x, turned.x), entry(of.y, of_change.y, turned.y),
                    entry(of.z, of_change.z, turned.z)};
    };
    return plus_ones({column(h.x, change.x, e.x), column(h.y, change.y, e.y), column(h.z, change.z, e.z)},
                     hn::Mul(inverse, of_one));
}

/// F - D with D the nearest matrix of determinant one: D = F + n cof D, by the iterations of
/// nearest_of_unit_product(), which need no singular values in matrices.
/// @param change  cof F - 1
HWY_INLINE Matrix beyond_unit_determinant(const Matrix &h, Matrix change, V growth, V square) {
    constexpr int most_iterations = 100;
    constexpr float part = 1e-6F; // of n
    const auto smallest = left_by_rounding(square);
    const auto size_of = [](const Matrix &c) HWY_ATTR { return hn::Add(number(3.0F), excess_of(c, dot(c, c))); };
    auto n = hn::Neg(hn::Div(growth, size_of(change)));
    auto is_moving = hn::Ge(square, square);
    for (int i = 0; i < most_iterations; ++i) {
        const auto entry = [&](const Vec3 &of, const Vec3 &of_change)
                               HWY_ATTR { return plus_scaled(of, n, of_change); };
        const auto e = plus_ones({entry(h.x, change.x), entry(h.y, change.y), entry(h.z, change.z)}, n); // D - 1
        const auto cofactors = cofactors_of(e);
        const auto next_change = change_of_cofactors(e, cofactors);
        // cof D : cof D of the one before
        const auto product =
            hn::Add(number(3.0F), hn::Add(trace_of(change), hn::Add(trace_of(next_change), dot(change, next_change))));
        const auto next = hn::Div(hn::MulSub(n, product, growth_of(e, cofactors)), size_of(next_change));
        const auto difference = hn::Abs(hn::Sub(next, n));
        n = hn::IfThenElse(is_moving, next, n);
        change = chosen(is_moving, next_change, change);
        is_moving = hn::And(is_moving, hn::Gt(difference, hn::MulAdd(number(part), hn::Abs(n), smallest)));
        if (hn::AllFalse(d, is_moving))
            break;
    }
    const auto less = hn::Neg(n);
    return plus_ones({scaled(less, change.x), scaled(less, change.y), scaled(less, change.z)}, less);
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_PROJECTIONS_INL_HPP
