// Rotations of deformation gradients F = 1 + H as R = 1 + Q, so that single precision keeps the digits of small strains
// and turns. Written once for each vector unit: see explicit_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_ROTATIONS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_ROTATIONS_INL_HPP
#undef LIVERMARK_INTERACTIVE_ROTATIONS_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_ROTATIONS_INL_HPP
#endif

#include <array>

#include "interactive/kernels/corotational/corotational_rows.hpp"
#include "interactive/kernels/neo_hookean-inl.hpp"
#include "interactive/kernels/symmetric-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// A unit quaternion.
struct Rotation {
    V w;
    Vec3 v;
};

/// Q = 2 (w [v] + v v^T - |v|^2 1)
HWY_INLINE Matrix turn_of(const Rotation &q) {
    const auto two = scaled(number(2.0F), q.v);
    const auto xx = hn::Mul(two.x, q.v.x), yy = hn::Mul(two.y, q.v.y), zz = hn::Mul(two.z, q.v.z);
    const auto xy = hn::Mul(two.x, q.v.y), xz = hn::Mul(two.x, q.v.z), yz = hn::Mul(two.y, q.v.z);
    const auto w = scaled(q.w, two);
    return {{hn::Neg(hn::Add(yy, zz)), hn::Add(xy, w.z), hn::Sub(xz, w.y)},
            {hn::Sub(xy, w.z), hn::Neg(hn::Add(zz, xx)), hn::Add(yz, w.x)},
            {hn::Add(xz, w.y), hn::Sub(yz, w.x), hn::Neg(hn::Add(xx, yy))}};
}

/// R^T F - 1 = Q^T + H + Q^T H
HWY_INLINE Matrix turned_back(const Matrix &turn, const Matrix &h) {
    const auto column = [&](V x, V y, V z, const Vec3 &of_h) HWY_ATTR {
        return Vec3{hn::Add(x, hn::Add(of_h.x, dot(turn.x, of_h))), hn::Add(y, hn::Add(of_h.y, dot(turn.y, of_h))),
                    hn::Add(z, hn::Add(of_h.z, dot(turn.z, of_h)))};
    };
    return {column(turn.x.x, turn.y.x, turn.z.x, h.x), column(turn.x.y, turn.y.y, turn.z.y, h.y),
            column(turn.x.z, turn.y.z, turn.z.z, h.z)};
}

/// q times (1, half), of unit length.
HWY_INLINE Rotation turned_on(const Rotation &q, const Vec3 &half) {
    const auto w = hn::Sub(q.w, dot(q.v, half));
    const auto v = plus_scaled(q.v + cross(q.v, half), q.w, half);
    const auto size = hn::Div(number(1.0F), hn::Sqrt(hn::MulAdd(w, w, dot(v, v))));
    return {hn::Mul(w, size), scaled(size, v)};
}

/// What vectors leave, lane by lane.
HWY_INLINE Rotation with_nearest_rotations(hn::Mask<D> is_found, const Matrix &h, const Rotation &q) {
    constexpr std::size_t most = hn::MaxLanes(D());
    HWY_ALIGN float found[most], of_h[9][most], of_q[4][most];
    hn::Store(hn::IfThenElseZero(is_found, number(1.0F)), d, found);
    std::size_t k = 0;
    for (const auto *column : {&h.x, &h.y, &h.z})
        for (const auto *entry : {&column->x, &column->y, &column->z})
            hn::Store(*entry, d, of_h[k++]);
    hn::Store(q.w, d, of_q[0]);
    hn::Store(q.v.x, d, of_q[1]);
    hn::Store(q.v.y, d, of_q[2]);
    hn::Store(q.v.z, d, of_q[3]);
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
        if (found[lane] != 0.0F)
            continue;
        std::array<float, 9> gradient;
        for (std::size_t i = 0; i < 9; ++i)
            gradient[i] = of_h[i][lane];
        std::array<float, 4> quaternion{of_q[0][lane], of_q[1][lane], of_q[2][lane], of_q[3][lane]};
        find_nearest_rotation(gradient, quaternion);
        for (std::size_t i = 0; i < 4; ++i)
            of_q[i][lane] = quaternion[i];
    }
    return {hn::Load(d, of_q[0]), {hn::Load(d, of_q[1]), hn::Load(d, of_q[2]), hn::Load(d, of_q[3])}};
}

/// The rotation next to F, by Newton's method from one that is near, on tr R^T F, which has no maximum but the largest:
/// with S the symmetric part of R^T F and t twice the axial vector of its other part, R turns by (tr S 1 - S)^-1 t.
/// Errors fall at least with their square. What is not where its matrix is positive definite after all, as in a
/// tetrahedron that turned by more than a right angle, is left to singular values. A lane's answer does not depend on
/// its neighbours.
/// (Kugelstadt, Koschier, Bender 2018, Fast corotated FEM using operator splitting, CGF 37(8))
HWY_INLINE Rotation nearest_rotation_from(Rotation q, const Matrix &h) {
    constexpr int most_iterations = 8;
    const auto small = number(1e-6F); // square of a half turn t, after which about t^2 times the strain is left
    auto is_found = hn::Lt(number(1.0F), hn::Zero(d));
    for (int i = 0; i < most_iterations; ++i) {
        const auto m = turned_back(turn_of(q), h);
        const auto trace = hn::Add(number(2.0F), hn::Add(m.x.x, hn::Add(m.y.y, m.z.z)));
        const auto off = [](V a, V b) HWY_ATTR { return hn::Mul(number(-0.5F), hn::Add(a, b)); };
        const Symmetric matrix{hn::Sub(trace, m.x.x), off(m.y.x, m.x.y), off(m.z.x, m.x.z),
                               hn::Sub(trace, m.y.y), off(m.z.y, m.y.z), hn::Sub(trace, m.z.z)};
        const Vec3 axial{hn::Sub(m.y.z, m.z.y), hn::Sub(m.z.x, m.x.z), hn::Sub(m.x.y, m.y.x)};
        const auto [adjugate, determinant] = adjugate_of(matrix);
        const auto zero = hn::Zero(d);
        const auto is_definite =
            hn::And(hn::Gt(matrix.xx, zero), hn::And(hn::Gt(adjugate.zz, zero), hn::Gt(determinant, zero)));
        const auto half = scaled(hn::Div(number(0.5F), determinant), product(adjugate, axial));
        const auto next = turned_on(q, half);
        const auto moves = hn::AndNot(is_found, is_definite);
        q = {hn::IfThenElse(moves, next.w, q.w), chosen(moves, next.v, q.v)};
        is_found = hn::Or(is_found, hn::And(moves, hn::Lt(dot(half, half), small)));
        if (hn::AllTrue(d, hn::Or(is_found, hn::Not(is_definite))))
            break;
    }
    return HWY_LIKELY(hn::AllTrue(d, is_found)) ? q : with_nearest_rotations(is_found, h, q);
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_ROTATIONS_INL_HPP
