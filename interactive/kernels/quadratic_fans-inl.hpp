// Fans of neo-Hookean tetrahedra with ten nodes, as QuadraticTetrahedron has them, one to a lane. Written once for each
// vector unit: see explicit_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_QUADRATIC_FANS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_QUADRATIC_FANS_INL_HPP
#undef LIVERMARK_INTERACTIVE_QUADRATIC_FANS_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_QUADRATIC_FANS_INL_HPP
#endif

#include "interactive/kernels/explicit_rows.hpp"
#include "interactive/kernels/neo_hookean-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Something at each corner or quadrature point of a tetrahedron: start and end of the axis, both nodes of the rim.
struct AtPoints {
    Matrix at[4];
};

/// factor a - b
HWY_INLINE Vec3 times_less(V factor, const Vec3 &a, const Vec3 &b) {
    return {hn::MulSub(factor, a.x, b.x), hn::MulSub(factor, a.y, b.y), hn::MulSub(factor, a.z, b.z)};
}

/// Corners to points or back: the matrix of barycentric coordinates at the points is symmetric.
HWY_INLINE void mix(AtPoints &of) {
    const auto far = number(0.138196601125010515F), near_less_far = number(0.447213595499957939F);
    const auto column = [&](Vec3 &a, Vec3 &b, Vec3 &r, Vec3 &s) HWY_ATTR {
        const auto shared = scaled(far, (a + b) + (r + s));
        a = plus_scaled(shared, near_less_far, a);
        b = plus_scaled(shared, near_less_far, b);
        r = plus_scaled(shared, near_less_far, r);
        s = plus_scaled(shared, near_less_far, s);
    };
    auto &[a, b, r, s] = of.at;
    column(a.x, b.x, r.x, s.x);
    column(a.y, b.y, r.y, s.y);
    column(a.z, b.z, r.z, s.z);
}

/// A node of the rim, and the middles between it and both ends of the axis.
struct RimNodes {
    Vec3 node, to_start, to_end;
};

HWY_INLINE RimNodes operator-(const RimNodes &a, const RimNodes &b) {
    return {a.node - b.node, a.to_start - b.to_start, a.to_end - b.to_end};
}

/// Nine of the ten nodes, from the start of the axis on.
struct TenNodes {
    Vec3 end, middle; ///< of the axis
    RimNodes from, to;
    Vec3 between; ///< both nodes of the rim

    /// The gradient of displacements at the corners before it is multiplied by those of the linear shape functions, by
    /// columns: those of end, from and to less that of start.
    HWY_INLINE AtPoints edges() const {
        const auto three = number(3.0F), four = number(4.0F);
        const auto at_start = [&](const Vec3 &to_middle) HWY_ATTR { return scaled(four, to_middle); };
        const auto start_middle = at_start(middle), from_middle = at_start(from.to_start),
                   to_middle = at_start(to.to_start);
        const auto end_from = scaled(four, from.to_end), end_to = scaled(four, to.to_end),
                   from_to = scaled(four, between);
        AtPoints e;
        e.at[0] = {start_middle - end, from_middle - from.node, to_middle - to.node};
        e.at[1] = {times_less(three, end, start_middle), (end_from - from.node) - start_middle,
                   (end_to - to.node) - start_middle};
        e.at[2] = {(end_from - end) - from_middle, times_less(three, from.node, from_middle),
                   (from_to - to.node) - from_middle};
        e.at[3] = {(end_to - end) - to_middle, (from_to - from.node) - to_middle,
                   times_less(three, to.node, to_middle)};
        return e;
    }
};

/// What ten nodes are pulled inwards with.
struct TenPulls {
    Vec3 start, end, middle;
    RimNodes from, to;
    Vec3 between;

    /// @param at  dW / d edges()
    explicit HWY_INLINE TenPulls(const AtPoints &at) {
        const auto three = number(3.0F), four = number(4.0F);
        const auto &[a, b, r, s] = at.at;
        const auto sum = [](const Matrix &m) HWY_ATTR { return m.x + (m.y + m.z); };
        const auto of_a = sum(a), of_b = sum(b), of_r = sum(r), of_s = sum(s); // of start, negative
        middle = scaled(four, a.x - of_b);
        from.to_start = scaled(four, a.y - of_r);
        to.to_start = scaled(four, a.z - of_s);
        from.to_end = scaled(four, b.y + r.x);
        to.to_end = scaled(four, b.z + s.x);
        between = scaled(four, r.z + s.y);
        start = times_less(three, minus(of_a), minus(of_b + (of_r + of_s)));
        end = times_less(three, b.x, a.x + (r.x + s.x));
        from.node = times_less(three, r.y, a.y + (b.y + s.y));
        to.node = times_less(three, s.z, a.z + (b.z + r.z));
    }
};

/// From edges() to its derivative of the energy.
HWY_INLINE void find_stresses(AtPoints &at, const ShapeGradients &g, V shear, V bulk) {
    mix(at);
    for (auto &point : at.at) {
        const auto h = displacement_gradient(g, point.x, point.y, point.z);
        const auto cofactors = cofactors_of(h);
        const auto growth = growth_of(h, cofactors);
        const auto jacobian = hn::Add(growth, number(1.0F));
        const auto inverse = hn::Div(number(1.0F), jacobian);
        const auto pressure = hn::Mul(hn::Mul(bulk, inverse), log_of(jacobian, growth));
        const auto p = stress_of(h, cofactors, growth, inverse, shear, pressure);
        point = {pull_of(p, g.b), pull_of(p, g.r), pull_of(p, g.s)};
    }
    mix(at);
}

/// Forces of tetrahedra into slots, summed at the nodes of fans.
inline HWY_NOINLINE void find_forces_of_quadratic_fans(ExplicitRows &rows) {
    constexpr std::size_t next = quadratic_lines.of_tetrahedron * slice_size;
    const Vec3 zero{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    const float *const nodes = rows.displacement.data();
    float *const forces = rows.force.data();
    const auto store_rim = [forces](const RimNodes &f, const std::int32_t *slot) HWY_ATTR {
        store(f.node, forces, slot);
        store(f.to_start, forces, slot + slice_size);
        store(f.to_end, forces, slot + 2 * slice_size);
    };
    for (std::size_t slice = 0; slice < rows.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const std::size_t first = rows.first_corner(slice) + lane;
            const std::int32_t *corner = rows.corner.data() + first, *const slot = rows.slot.data() + first,
                               *rim = slot + 3 * slice_size;
            const auto start = fetch(nodes, corner).v;
            const auto from_start = [nodes, start](const std::int32_t *at)
                                        HWY_ATTR { return fetch(nodes, at).v - start; };
            const auto rim_from_start = [&](const std::int32_t *at) HWY_ATTR {
                return RimNodes{from_start(at), from_start(at + slice_size), from_start(at + 2 * slice_size)};
            };
            TenNodes x;
            x.end = from_start(corner + slice_size);
            x.middle = from_start(corner + 2 * slice_size);
            corner += 3 * slice_size;
            x.from = rim_from_start(corner);
            corner += 3 * slice_size;
            auto at_start = zero, at_end = zero, at_middle = zero;
            RimNodes before{zero, zero, zero};
            for (std::size_t line = rows.line_start[slice]; line < rows.line_start[slice + 1]; ++line) {
                const float *numbers = rows.tetrahedra.data() + line * numbers_of_tetrahedron * slice_size + lane;
                x.to = rim_from_start(corner);
                x.between = from_start(corner + 3 * slice_size);
                auto points = x.edges();
                find_stresses(points, ShapeGradients(numbers), hn::Load(d, numbers + 9 * slice_size),
                              hn::Load(d, numbers + 10 * slice_size));
                const TenPulls pull(points);
                store_rim(before - pull.from, rim);
                rim += line == rows.line_start[slice] ? 3 * slice_size : next;
                store(minus(pull.between), forces, rim + 3 * slice_size);
                before = RimNodes{zero, zero, zero} - pull.to;
                at_start = at_start - pull.start;
                at_end = at_end - pull.end;
                at_middle = at_middle - pull.middle;
                x.from = x.to;
                corner += next;
            }
            store_rim(before, rim);
            store(at_start, forces, slot);
            store(at_end, forces, slot + slice_size);
            store(at_middle, forces, slot + 2 * slice_size);
        }
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_QUADRATIC_FANS_INL_HPP
