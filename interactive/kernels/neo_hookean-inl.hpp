// Neo-Hookean tetrahedra by the gradient H of their displacements, F = 1 + H, so that single precision keeps the digits
// of small strains. Written once for each vector unit: see explicit_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_NEO_HOOKEAN_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_NEO_HOOKEAN_INL_HPP
#undef LIVERMARK_INTERACTIVE_NEO_HOOKEAN_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_NEO_HOOKEAN_INL_HPP
#endif

#include <limits>

#include "interactive/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Gradients of the shape functions of three nodes of a tetrahedron; that of the first one is minus their sum.
struct ShapeGradients {
    Vec3 b, r, s;

    explicit HWY_INLINE ShapeGradients(const float *at)
        : b(load3(at)), r(load3(at + 3 * slice_size)), s(load3(at + 6 * slice_size)) {}
    HWY_INLINE ShapeGradients(const Vec3 &of_b, const Vec3 &of_r, const Vec3 &of_s) : b(of_b), r(of_r), s(of_s) {}
};

/// A matrix, by columns.
struct Matrix {
    Vec3 x, y, z;
};

/// H from displacements less that of the first node.
HWY_INLINE Matrix displacement_gradient(const ShapeGradients &g, const Vec3 &b, const Vec3 &r, const Vec3 &s) {
    return {combined(g.b.x, b, g.r.x, r, g.s.x, s), combined(g.b.y, b, g.r.y, r, g.s.y, s),
            combined(g.b.z, b, g.r.z, r, g.s.z, s)};
}

HWY_INLINE Matrix cofactors_of(const Matrix &h) {
    return {cross(h.y, h.z), cross(h.z, h.x), cross(h.x, h.y)};
}

/// cof F - 1 of F = 1 + H, from cof H.
HWY_INLINE Matrix change_of_cofactors(const Matrix &h, const Matrix &cofactors) {
    const auto on_diagonal = [&](V other, V another, V cofactor)
                                 HWY_ATTR { return hn::Add(hn::Add(other, another), cofactor); };
    return {{on_diagonal(h.y.y, h.z.z, cofactors.x.x), hn::Sub(cofactors.x.y, h.y.x), hn::Sub(cofactors.x.z, h.z.x)},
            {hn::Sub(cofactors.y.x, h.x.y), on_diagonal(h.z.z, h.x.x, cofactors.y.y), hn::Sub(cofactors.y.z, h.z.y)},
            {hn::Sub(cofactors.z.x, h.x.z), hn::Sub(cofactors.z.y, h.y.z), on_diagonal(h.x.x, h.y.y, cofactors.z.z)}};
}

/// A + factor 1
HWY_INLINE Matrix plus_ones(Matrix a, V factor) {
    a.x.x = hn::Add(a.x.x, factor);
    a.y.y = hn::Add(a.y.y, factor);
    a.z.z = hn::Add(a.z.z, factor);
    return a;
}

/// r A + s B
HWY_INLINE Matrix combined(V r, const Matrix &a, V s, const Matrix &b) {
    const auto column = [&](const Vec3 &of_a, const Vec3 &of_b) HWY_ATTR {
        return Vec3{hn::MulAdd(r, of_a.x, hn::Mul(s, of_b.x)), hn::MulAdd(r, of_a.y, hn::Mul(s, of_b.y)),
                    hn::MulAdd(r, of_a.z, hn::Mul(s, of_b.z))};
    };
    return {column(a.x, b.x), column(a.y, b.y), column(a.z, b.z)};
}

/// J - 1 = tr H + tr cof H + det H.
HWY_INLINE V growth_of(const Matrix &h, const Matrix &cofactors) {
    const auto first = hn::Add(h.x.x, hn::Add(h.y.y, h.z.z));
    const auto second = hn::Add(cofactors.x.x, hn::Add(cofactors.y.y, cofactors.z.z));
    return hn::Add(first, hn::Add(second, dot(h.x, cofactors.x)));
}

/// ln J, to about the last digit, also where it is small; NaN unless J > 0. J = 2^e (1 + f), and the polynomial is that
/// of logf() in the Cephes library (S. L. Moshier 1992).
/// @param growth  J - 1
HWY_INLINE V log_of(V jacobian, V growth) {
    const hn::RebindToSigned<D> whole;
    const auto bits = hn::BitCast(whole, jacobian);
    const auto root_half = hn::Set(whole, 0x3F3504F3); // so that 1 + f is between sqrt(1/2) and sqrt(2)
    const auto shift = hn::ShiftRight<23>(hn::Sub(bits, root_half));
    const auto exponent = hn::ConvertTo(d, shift);
    const auto one_and_f = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(shift)));
    const auto f = hn::IfThenElse(hn::Eq(exponent, hn::Zero(d)), growth, hn::Sub(one_and_f, number(1.0F)));
    const auto f2 = hn::Mul(f, f);
    const auto of_f = [&](float c0, float c1, float c2)
                          HWY_ATTR { return hn::MulAdd(f2, number(c2), hn::MulAdd(f, number(c1), number(c0))); };
    const auto low = of_f(3.3333331174e-1F, -2.4999993993e-1F, 2.0000714765e-1F);
    const auto middle = of_f(-1.6668057665e-1F, 1.4249322787e-1F, -1.2420140846e-1F);
    const auto high = of_f(1.1676998740e-1F, -1.1514610310e-1F, 7.0376836292e-2F);
    const auto f3 = hn::Mul(f2, f);
    const auto polynomial = hn::MulAdd(f3, hn::MulAdd(f3, high, middle), low);
    const auto tail = hn::MulAdd(f3, polynomial, hn::Mul(f2, number(-0.5F)));
    const auto log = hn::MulAdd(exponent, number(0.693147180559945F), hn::Add(f, tail));
    return hn::IfThenElse(hn::Gt(jacobian, hn::Zero(d)), log, number(std::numeric_limits<float>::quiet_NaN()));
}

/// V P, with P = mu (F - F^-T) + p F^-T J the first Piola-Kirchhoff stress, as
///     mu (H + ((J - 1) 1 - C) / J) + p (1 + C),   1 + C = cof F,   C = tr H 1 - H^T + cof H,
/// where nothing but a rigid motion cancels.
/// @param pressure  V p
HWY_INLINE Matrix stress_of(const Matrix &h, const Matrix &cofactors, V growth, V inverse, V shear, V pressure) {
    const auto of_inverse = hn::Mul(shear, inverse);
    const auto diagonal = hn::MulAdd(of_inverse, growth, pressure); // times 1
    const auto of_c = hn::Sub(pressure, of_inverse);
    const auto entry = [&](V of_h, V c) HWY_ATTR { return hn::MulAdd(of_c, c, hn::Mul(shear, of_h)); };
    const auto on_diagonal = [&](V of_h, V other, V another, V cofactor) HWY_ATTR {
        return hn::MulAdd(of_c, hn::Add(hn::Add(other, another), cofactor), hn::MulAdd(shear, of_h, diagonal));
    };
    return {{on_diagonal(h.x.x, h.y.y, h.z.z, cofactors.x.x), entry(h.x.y, hn::Sub(cofactors.x.y, h.y.x)),
             entry(h.x.z, hn::Sub(cofactors.x.z, h.z.x))},
            {entry(h.y.x, hn::Sub(cofactors.y.x, h.x.y)), on_diagonal(h.y.y, h.z.z, h.x.x, cofactors.y.y),
             entry(h.y.z, hn::Sub(cofactors.y.z, h.z.y))},
            {entry(h.z.x, hn::Sub(cofactors.z.x, h.x.z)), entry(h.z.y, hn::Sub(cofactors.z.y, h.y.z)),
             on_diagonal(h.z.z, h.x.x, h.y.y, cofactors.z.z)}};
}

/// P g, what a stress pulls a node inwards with.
HWY_INLINE Vec3 pull_of(const Matrix &p, const Vec3 &g) {
    return combined(g.x, p.x, g.y, p.y, g.z, p.z);
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_NEO_HOOKEAN_INL_HPP
