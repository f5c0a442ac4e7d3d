// Neo-Hookean tetrahedra by the gradient H of their displacements, F = 1 + H, so that single precision keeps the digits
// of small strains; fans of tetrahedra, and sums at their corners. Written once for each vector unit: see
// explicit_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_TETRAHEDRA_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_TETRAHEDRA_INL_HPP
#undef LIVERMARK_INTERACTIVE_TETRAHEDRA_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_TETRAHEDRA_INL_HPP
#endif

#include <limits>

#include "interactive/kernels/method_steps.hpp"
#include "interactive/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Gradients of the shape functions of three nodes of a tetrahedron; that of the first one is minus their sum.
struct ShapeGradients {
    Vec3 b, r, s;

    explicit HWY_INLINE ShapeGradients(const float *at)
        : b(load3(at)), r(load3(at + 3 * slice_size)), s(load3(at + 6 * slice_size)) {}
    HWY_INLINE ShapeGradients(const Vec3 &at_b, const Vec3 &at_r, const Vec3 &at_s) : b(at_b), r(at_r), s(at_s) {}
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
    const auto column = [&](const Vec3 &a_column, const Vec3 &b_column) HWY_ATTR {
        return Vec3{hn::MulAdd(r, a_column.x, hn::Mul(s, b_column.x)),
                    hn::MulAdd(r, a_column.y, hn::Mul(s, b_column.y)),
                    hn::MulAdd(r, a_column.z, hn::Mul(s, b_column.z))};
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
    const auto polynomial_of = [&](float c0, float c1, float c2) HWY_ATTR {
        return hn::MulAdd(f2, number(c2), hn::MulAdd(f, number(c1), number(c0)));
    };
    const auto low = polynomial_of(3.3333331174e-1F, -2.4999993993e-1F, 2.0000714765e-1F);
    const auto middle = polynomial_of(-1.6668057665e-1F, 1.4249322787e-1F, -1.2420140846e-1F);
    const auto high = polynomial_of(1.1676998740e-1F, -1.1514610310e-1F, 7.0376836292e-2F);
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
    const auto inverse_part = hn::Mul(shear, inverse);
    const auto diagonal = hn::MulAdd(inverse_part, growth, pressure); // times 1
    const auto c_part = hn::Sub(pressure, inverse_part);
    const auto entry = [&](V h_entry, V c) HWY_ATTR { return hn::MulAdd(c_part, c, hn::Mul(shear, h_entry)); };
    const auto on_diagonal = [&](V h_entry, V other, V another, V cofactor) HWY_ATTR {
        return hn::MulAdd(c_part, hn::Add(hn::Add(other, another), cofactor), hn::MulAdd(shear, h_entry, diagonal));
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

/// Fans of a slice, one to a lane, on the way along their tetrahedra. Values of the rim are from the start of the axis
/// on.
class Fans {
  public:
    /// @param nodes    rows of four, as ExplicitRows::displacement
    /// @param numbers  of the tetrahedra, as ExplicitRows::tetrahedra
    HWY_INLINE Fans(const ExplicitRows &rows, const Aligned<float> &nodes, const Aligned<float> &numbers,
                    std::size_t slice, std::size_t lane)
        : nodes_(nodes.data()), corner_(rows.corner.data() + rows.first_corner(slice) + lane),
          start_(fetch(nodes_, corner_)), end_(fetch(nodes_, corner_ + slice_size)),
          numbers_(numbers.data() + rows.line_start[slice] * numbers_of_tetrahedron * slice_size + lane),
          last_(numbers_ +
                (rows.line_start[slice + 1] - rows.line_start[slice]) * numbers_of_tetrahedron * slice_size) {
        corner_ += 2 * slice_size;
        from_ = from_start(fetch(nodes_, corner_));
        corner_ += slice_size;
        to_ = from_start(fetch(nodes_, corner_));
    }

    HWY_INLINE bool is_at_end() const { return numbers_ == last_; }
    HWY_INLINE void go_on() {
        numbers_ += numbers_of_tetrahedron * slice_size;
        from_ = to_;
        if (is_at_end())
            return;
        corner_ += slice_size;
        to_ = from_start(fetch(nodes_, corner_));
    }

    HWY_INLINE V number_of_tetrahedron(std::size_t k) const { return hn::Load(d, numbers_ + k * slice_size); }
    HWY_INLINE ShapeGradients gradients() const { return ShapeGradients(numbers_); }
    HWY_INLINE Vec3 axis() const { return end_.v - start_.v; }
    HWY_INLINE V pressures() const { return hn::Add(hn::Add(start_.w, end_.w), hn::Add(from_.w, to_.w)); } ///< sum
    HWY_INLINE const Row &from() const { return from_; }
    HWY_INLINE const Row &to() const { return to_; }

  private:
    HWY_INLINE Row from_start(const Row &node) const { return {node.v - start_.v, node.w}; }

    const float *nodes_;
    const std::int32_t *corner_;
    Row start_, end_;
    const float *numbers_, *last_;
    Row from_, to_;
};

/// Sums over tetrahedra of fans at their corners, put into the slots of the fans.
class FanSums {
  public:
    /// @param slots   as ExplicitRows::force
    /// @param corner  the slot of the start of the axis, in ExplicitRows::slot
    HWY_INLINE FanSums(Aligned<float> &slots, const std::int32_t *corner)
        : slots_(slots.data()), axis_(corner), rim_(corner + 2 * slice_size), start_(zero()), end_(zero()),
          from_(zero()) {}

    /// Adds the next tetrahedron.
    HWY_INLINE void add(const Vec3 &start, const Vec3 &end, const Vec3 &from, const Vec3 &to) {
        start_ = start_ + start;
        end_ = end_ + end;
        store(from_ + from, slots_, rim_);
        from_ = to;
        rim_ += slice_size;
    }
    /// Adds the forces of the next tetrahedron.
    /// @param stress  V P
    HWY_INLINE void add_forces(const Matrix &stress, const ShapeGradients &g) {
        const auto at_end = pull_of(stress, g.b), at_from = pull_of(stress, g.r), at_to = pull_of(stress, g.s);
        add(at_from + at_to + at_end, minus(at_end), minus(at_from), minus(at_to));
    }
    HWY_INLINE void finish() const {
        store(from_, slots_, rim_);
        store(end_, slots_, axis_ + slice_size);
        store(start_, slots_, axis_);
    }

  private:
    static HWY_INLINE Vec3 zero() { return {hn::Zero(d), hn::Zero(d), hn::Zero(d)}; }

    float *slots_;
    const std::int32_t *axis_, *rim_;
    Vec3 start_, end_, from_;
};

/// Forces of tetrahedra, summed at the corners of fans.
/// @param stress  of fans and the gradient H of their displacements: V P
template <class Stress> HWY_INLINE void find_forces_of_fans(ExplicitRows &rows, const Stress &stress) {
    for (std::size_t slice = 0; slice < rows.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            FanSums sums(rows.force, rows.slot.data() + rows.first_corner(slice) + lane);
            Fans fans(rows, rows.displacement, rows.tetrahedra, slice, lane);
            const auto axis = fans.axis();
            for (; !fans.is_at_end(); fans.go_on()) {
                const auto g = fans.gradients();
                const auto h = displacement_gradient(g, axis, fans.from().v, fans.to().v);
                sums.add_forces(stress(fans, h), g);
            }
            sums.finish();
        }
}

/// Sums of the slots of four nodes side by side, in their order.
/// @param rows  with slot_start, as ExplicitRows and PointSpringRows have it
template <class Rows>
HWY_INLINE V summed_slots(const Rows &rows, const Aligned<float> &slots, std::size_t four, std::size_t lane, V sum) {
    for (std::size_t k = rows.slot_start[four]; k < rows.slot_start[four + 1]; ++k)
        sum = hn::Add(sum, hn::Load(d, slots.data() + k * 4 * nodes_at_once + lane));
    return sum;
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_TETRAHEDRA_INL_HPP
