// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/corotational_steps.cpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <hwy/foreach_target.h> // has to come before highway.h

#include "core/support/vector_dispatch.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/kernels/point_springs-inl.hpp"
#include "interactive/kernels/tetrahedra-inl.hpp"

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
    const auto column = [&](V x, V y, V z, const Vec3 &h_column) HWY_ATTR {
        return Vec3{hn::Add(x, hn::Add(h_column.x, dot(turn.x, h_column))),
                    hn::Add(y, hn::Add(h_column.y, dot(turn.y, h_column))),
                    hn::Add(z, hn::Add(h_column.z, dot(turn.z, h_column)))};
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

/// Rotations that vectors have not found, lane by lane.
HWY_INLINE Rotation with_nearest_rotations(hn::Mask<D> is_found, const Matrix &h, const Rotation &q) {
    constexpr std::size_t most = hn::MaxLanes(D());
    HWY_ALIGN float found[most], gradients[9][most], quaternions[4][most];
    hn::Store(hn::IfThenElseZero(is_found, number(1.0F)), d, found);
    std::size_t k = 0;
    for (const auto *column : {&h.x, &h.y, &h.z})
        for (const auto *entry : {&column->x, &column->y, &column->z})
            hn::Store(*entry, d, gradients[k++]);
    hn::Store(q.w, d, quaternions[0]);
    hn::Store(q.v.x, d, quaternions[1]);
    hn::Store(q.v.y, d, quaternions[2]);
    hn::Store(q.v.z, d, quaternions[3]);
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
        if (found[lane] != 0.0F)
            continue;
        std::array<float, 9> gradient;
        for (std::size_t i = 0; i < 9; ++i)
            gradient[i] = gradients[i][lane];
        std::array<float, 4> quaternion{quaternions[0][lane], quaternions[1][lane], quaternions[2][lane],
                                        quaternions[3][lane]};
        find_nearest_rotation(gradient, quaternion);
        for (std::size_t i = 0; i < 4; ++i)
            quaternions[i][lane] = quaternion[i];
    }
    return {hn::Load(d, quaternions[0]),
            {hn::Load(d, quaternions[1]), hn::Load(d, quaternions[2]), hn::Load(d, quaternions[3])}};
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

/// A sum in single precision by lanes of a whole slice, so that it is the same on vectors of any width.
class LaneSums {
  public:
    HWY_INLINE void put(V sum, std::size_t lane) { hn::Store(sum, d, lanes_ + lane); }
    double total() const {
        double total = 0.0;
        for (const float lane : lanes_)
            total += lane;
        return total;
    }

  private:
    alignas(64) float lanes_[slice_size];
};

/// A + A^T, times shear, plus volume tr A on the diagonal.
HWY_INLINE Matrix linear_stress(const Matrix &a, V shear, V volume) {
    const auto trace = hn::Mul(volume, hn::Add(a.x.x, hn::Add(a.y.y, a.z.z)));
    const auto twice = hn::Add(shear, shear);
    const auto xy = hn::Mul(shear, hn::Add(a.y.x, a.x.y)), xz = hn::Mul(shear, hn::Add(a.z.x, a.x.z)),
               yz = hn::Mul(shear, hn::Add(a.z.y, a.y.z));
    return {{hn::MulAdd(twice, a.x.x, trace), xy, xz},
            {xy, hn::MulAdd(twice, a.y.y, trace), yz},
            {xz, yz, hn::MulAdd(twice, a.z.z, trace)}};
}

/// (F - R) R^T = E + E Q^T with E = H - Q: symmetric, since F = V R with V symmetric.
HWY_INLINE Matrix stretch_of(const Matrix &h, const Matrix &turn) {
    const Matrix e{h.x - turn.x, h.y - turn.y, h.z - turn.z};
    return {e.x + combined(turn.x.x, e.x, turn.y.x, e.y, turn.z.x, e.z),
            e.y + combined(turn.x.y, e.x, turn.y.y, e.y, turn.z.y, e.z),
            e.z + combined(turn.x.z, e.x, turn.y.z, e.y, turn.z.z, e.z)};
}

HWY_INLINE Matrix sum_of(const Matrix &a, V factor, const Matrix &b) {
    return {plus_scaled(a.x, factor, b.x), plus_scaled(a.y, factor, b.y), plus_scaled(a.z, factor, b.z)};
}

HWY_INLINE ShapeGradients turned(const Matrix &turn, const ShapeGradients &g) {
    return {g.b + pull_of(turn, g.b), g.r + pull_of(turn, g.r), g.s + pull_of(turn, g.s)};
}

/// Rotations and turned gradients of tetrahedra; into slots of forces f - h K v, with the stress of the stretch and of
/// the rate in one, and those of blocks.
HWY_NOINLINE void linearise(CorotationalRows &rows, float step) {
    const auto &body = rows.body;
    for (std::size_t slice = 0; slice < body.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const std::int32_t *slot = body.slot.data() + body.first_corner(slice) + lane;
            FanSums forces(rows.body.force, slot), first(rows.block_slots[0], slot), second(rows.block_slots[1], slot);
            Fans fans(body, body.displacement, body.tetrahedra, slice, lane);
            Fans rates(body, body.velocity, body.tetrahedra, slice, lane);
            const auto axis = fans.axis(), axis_rate = rates.axis();
            float *out = rows.turned.data() + body.line_start[slice] * numbers_of_tetrahedron * slice_size + lane;
            float *kept = rows.rotation.data() + body.line_start[slice] * numbers_of_rotation * slice_size + lane;
            for (; !fans.is_at_end(); fans.go_on(), rates.go_on(), out += numbers_of_tetrahedron * slice_size,
                                      kept += numbers_of_rotation * slice_size) {
                const auto at_rest = fans.gradients();
                const auto h = displacement_gradient(at_rest, axis, fans.from().v, fans.to().v);
                const auto q = nearest_rotation_from({hn::Load(d, kept), load3(kept + slice_size)}, h);
                hn::Store(q.w, d, kept);
                store3(q.v, kept + slice_size);
                const auto turn = turn_of(q);
                const auto g = turned(turn, at_rest);
                store3(g.b, out);
                store3(g.r, out + 3 * slice_size);
                store3(g.s, out + 6 * slice_size);
                const auto rate = displacement_gradient(g, axis_rate, rates.from().v, rates.to().v);
                const auto shear = fans.number_of_tetrahedron(9), volume = fans.number_of_tetrahedron(10);
                const auto stress = linear_stress(sum_of(stretch_of(h, turn), number(step), rate), shear, volume);
                forces.add_forces(stress, g);
                const auto modulus = hn::Add(shear, volume);
                const auto a = g.b + g.r + g.s; // of the start, but for its sign
                const auto row = [&](V factor, const Vec3 &v) HWY_ATTR { return scaled(hn::Mul(modulus, factor), v); };
                first.add(row(a.x, a), row(g.b.x, g.b), row(g.r.x, g.r), row(g.s.x, g.s));
                const auto rest = [&](const Vec3 &v) HWY_ATTR {
                    const auto y = hn::Mul(modulus, v.y);
                    return Vec3{hn::Mul(y, v.y), hn::Mul(y, v.z), hn::Mul(modulus, hn::Mul(v.z, v.z))};
                };
                second.add(rest(a), rest(g.b), rest(g.r), rest(g.s));
            }
            forces.finish();
            first.finish();
            second.finish();
        }
}

/// Tangent of a spring: K v = across v + more (n . v) n.
struct SpringTangent {
    Vec3 n;
    V across, more;

    HWY_INLINE SpringTangent(const StretchedSpring &spring, V stiffness)
        : n(scaled(hn::Div(number(1.0F), spring.length), spring.now)),
          across(hn::Mul(stiffness, hn::Max(hn::Div(spring.change, spring.length), hn::Zero(d)))),
          more(hn::Sub(stiffness, across)) {}
    explicit HWY_INLINE SpringTangent(const float *at)
        : n(load3(at)), across(hn::Load(d, at + 3 * slice_size)), more(hn::Load(d, at + 4 * slice_size)) {}

    HWY_INLINE void store_at(float *at) const {
        store3(n, at);
        hn::Store(across, d, at + 3 * slice_size);
        hn::Store(more, d, at + 4 * slice_size);
    }
    HWY_INLINE Vec3 times(const Vec3 &v) const { return plus_scaled(scaled(across, v), hn::Mul(more, dot(n, v)), n); }
};

/// Tangents of springs; into their slots forces f - h K v, and blocks.
HWY_NOINLINE void linearise_springs(CorotationalRows &rows, float step) {
    auto &springs = rows.body.springs;
    for (std::size_t s = 0; s < springs.sets.size(); ++s)
        for (std::size_t batch = 0; batch < springs.sets[s].num_batches(); ++batch)
            for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
                const PointSpringLanes lanes(springs.sets[s], batch, lane);
                const auto spring = lanes.stretched(rows.body.displacement);
                const SpringTangent tangent(spring, lanes.stiffness());
                tangent.store_at(rows.spring_tangent[s].data() + batch * numbers_of_tangent * slice_size + lane);
                const auto later = scaled(number(step), tangent.times(lanes.span(rows.body.velocity)));
                const auto pull = plus_scaled(later, hn::Mul(lanes.stiffness(), spring.change), tangent.n);
                const auto &n = tangent.n;
                const auto more = scaled(tangent.more, n);
                const Vec3 first{hn::MulAdd(more.x, n.x, tangent.across), hn::Mul(more.x, n.y), hn::Mul(more.x, n.z)},
                    second{hn::MulAdd(more.y, n.y, tangent.across), hn::Mul(more.y, n.z),
                           hn::MulAdd(more.z, n.z, tangent.across)};
                lanes.put(springs.force, [&](V weight) HWY_ATTR { return scaled(hn::Neg(weight), pull); });
                lanes.put(rows.spring_block_slots[0],
                          [&](V weight) HWY_ATTR { return scaled(hn::Mul(weight, weight), first); });
                lanes.put(rows.spring_block_slots[1],
                          [&](V weight) HWY_ATTR { return scaled(hn::Mul(weight, weight), second); });
            }
}

/// Sums of the slots of tetrahedra and springs.
HWY_NOINLINE void sum_at_nodes(const ExplicitRows &body, const Aligned<float> &slots,
                               const Aligned<float> &spring_slots, Aligned<float> &nodes) {
    constexpr std::size_t width = 4 * nodes_at_once;
    for (std::size_t four = 0; four + 1 < body.slot_start.size(); ++four)
        for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
            const auto elements = summed_slots(body, slots, four, lane, hn::Zero(d));
            hn::Store(summed_slots(body.springs, spring_slots, four, lane, elements), d,
                      nodes.data() + four * width + lane);
        }
}

HWY_INLINE Symmetric inverse_block(const CorotationalRows &rows, std::size_t row) {
    const float *at = rows.inverse_block.data() + row / slice_size * 6 * slice_size + row % slice_size;
    const auto entry = [&](std::size_t k) HWY_ATTR { return hn::Load(d, at + k * slice_size); };
    return {entry(0), entry(1), entry(2), entry(3), entry(4), entry(5)};
}

/// Inverses of the blocks m (1 + alpha h) 1 + h^2 K of nodes.
HWY_NOINLINE void invert_blocks(CorotationalRows &rows, float step, float damping) {
    const auto h_squared = number(step * step);
    for (std::size_t row = 0; row < rows.body.num_rows; row += hn::Lanes(d)) {
        V mass, same, same_too, laplacian, inverse_mass, x, y, z;
        hn::LoadInterleaved4(d, rows.mass.data() + 4 * row, mass, same, same_too, laplacian);
        hn::LoadInterleaved4(d, rows.body.inverse_mass.data() + 4 * row, inverse_mass, x, y, z);
        const auto first = load_rows(rows.block[0], row), second = load_rows(rows.block[1], row);
        // Over the mass, so that nothing overflows.
        const auto factor = hn::Mul(h_squared, inverse_mass);
        const auto of = [&](V entry) HWY_ATTR { return hn::Mul(factor, entry); };
        const auto diagonal = hn::MulAdd(factor, laplacian, number(damping));
        const auto [adjugate, determinant] =
            adjugate_of({hn::Add(diagonal, of(first.x)), of(first.y), of(first.z), hn::Add(diagonal, of(second.x)),
                         of(second.y), hn::Add(diagonal, of(second.z))});
        const auto inverse = scaled(hn::Div(inverse_mass, determinant), adjugate);
        float *at = rows.inverse_block.data() + row / slice_size * 6 * slice_size + row % slice_size;
        for (const auto &entry : {inverse.xx, inverse.xy, inverse.xz, inverse.yy, inverse.yz, inverse.zz}) {
            hn::Store(entry, d, at);
            at += slice_size;
        }
    }
}

/// r = h (f - h K v + f_ext - alpha m v), what the velocity leaves, and the first direction.
/// @return r . M^-1 r
HWY_NOINLINE double begin_solve(CorotationalRows &rows, float step, float mass_damping) {
    const auto &body = rows.body;
    const auto h = number(step), alpha = number(mass_damping);
    LaneSums sums;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        auto sum = hn::Zero(d);
        for (std::size_t row = lane; row < body.num_rows; row += slice_size) {
            const auto drag = hn::Mul(alpha, load_rows(rows.mass, row).x);
            const auto force = load_rows(rows.product, row) + load_rows(body.external, row);
            const auto residual = scaled(h, plus_scaled(force, hn::Neg(drag), load_rows(body.velocity, row)));
            const auto preconditioned = product(inverse_block(rows, row), residual);
            store_rows(residual, rows.residual, row);
            store_rows(preconditioned, rows.direction, row);
            sum = hn::Add(sum, dot(residual, preconditioned));
        }
        sums.put(sum, lane);
    }
    return sums.total();
}

/// K times the direction, into slots of forces.
HWY_NOINLINE void multiply_tetrahedra(CorotationalRows &rows) {
    const auto &body = rows.body;
    for (std::size_t slice = 0; slice < body.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            FanSums sums(rows.body.force, body.slot.data() + body.first_corner(slice) + lane);
            Fans fans(body, rows.direction, rows.turned, slice, lane);
            const auto axis = fans.axis();
            for (; !fans.is_at_end(); fans.go_on()) {
                const auto g = fans.gradients();
                const auto rate = displacement_gradient(g, axis, fans.from().v, fans.to().v);
                const auto stress = linear_stress(rate, fans.number_of_tetrahedron(9), fans.number_of_tetrahedron(10));
                const auto at_end = pull_of(stress, g.b), at_from = pull_of(stress, g.r), at_to = pull_of(stress, g.s);
                sums.add(minus(at_from + at_to + at_end), at_end, at_from, at_to);
            }
            sums.finish();
        }
}

/// K times the direction, into slots of springs.
HWY_NOINLINE void multiply_springs(CorotationalRows &rows) {
    auto &springs = rows.body.springs;
    for (std::size_t s = 0; s < springs.sets.size(); ++s)
        for (std::size_t batch = 0; batch < springs.sets[s].num_batches(); ++batch)
            for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
                const PointSpringLanes lanes(springs.sets[s], batch, lane);
                const SpringTangent tangent(rows.spring_tangent[s].data() + batch * numbers_of_tangent * slice_size +
                                            lane);
                const auto pull = tangent.times(lanes.span(rows.direction));
                lanes.put(springs.force, [&](V weight) HWY_ATTR { return scaled(weight, pull); });
            }
}

/// A p = m (1 + alpha h) p + h^2 K p at nodes.
/// @return p . A p
HWY_NOINLINE double finish_product(CorotationalRows &rows, float step, float damping) {
    constexpr std::size_t width = 4 * nodes_at_once;
    const auto &body = rows.body;
    const auto h_squared = number(step * step), factor = number(damping);
    LaneSums sums;
    for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
        auto sum = hn::Zero(d);
        for (std::size_t four = 0; four + 1 < body.slot_start.size(); ++four) {
            const std::size_t at = four * width + lane;
            const auto direction = hn::Load(d, rows.direction.data() + at);
            const auto inert = hn::Mul(hn::Mul(factor, hn::Load(d, rows.mass.data() + at)), direction);
            const auto elements = summed_slots(body, body.force, four, lane, hn::Zero(d));
            const auto elastic = summed_slots(body.springs, body.springs.force, four, lane, elements);
            const auto product = hn::MulAdd(h_squared, elastic, inert);
            hn::Store(product, d, rows.product.data() + at);
            sum = hn::MulAdd(direction, product, sum);
        }
        sums.put(sum, lane);
    }
    return sums.total();
}

/// v += a p, r -= a A p
/// @return r . M^-1 r
HWY_NOINLINE double go_along(CorotationalRows &rows, float length) {
    const auto by = number(length), less = number(-length);
    LaneSums sums;
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        auto sum = hn::Zero(d);
        for (std::size_t row = lane; row < rows.body.num_rows; row += slice_size) {
            store_rows(plus_scaled(load_rows(rows.body.velocity, row), by, load_rows(rows.direction, row)),
                       rows.body.velocity, row);
            const auto residual = plus_scaled(load_rows(rows.residual, row), less, load_rows(rows.product, row));
            const auto preconditioned = product(inverse_block(rows, row), residual);
            store_rows(residual, rows.residual, row);
            store_rows(preconditioned, rows.preconditioned, row);
            sum = hn::Add(sum, dot(residual, preconditioned));
        }
        sums.put(sum, lane);
    }
    return sums.total();
}

/// a = b + factor a
HWY_NOINLINE void combine_rows(Aligned<float> &a, float factor, const Aligned<float> &b) {
    for (std::size_t at = 0; at < a.size(); at += hn::Lanes(d))
        hn::Store(hn::MulAdd(number(factor), hn::Load(d, a.data() + at), hn::Load(d, b.data() + at)), d, a.data() + at);
}

/// a += factor b
HWY_NOINLINE void add_rows(Aligned<float> &a, float factor, const Aligned<float> &b) {
    for (std::size_t at = 0; at < a.size(); at += hn::Lanes(d))
        hn::Store(hn::MulAdd(number(factor), hn::Load(d, b.data() + at), hn::Load(d, a.data() + at)), d, a.data() + at);
}

/// sum of shape_k v_k
HWY_INLINE std::array<float, 3> value_at(const TouchedRows &point, const Aligned<float> &nodes) {
    std::array<float, 3> value{};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c)
            value[c] += point.shape[k] * nodes[4 * static_cast<std::size_t>(point.rows[k]) + c];
    return value;
}

HWY_INLINE std::array<float, 3> pull_at(const TouchedRows &point, const std::array<float, 3> &v) {
    const auto &[xx, xy, xz, yy, yz, zz] = point.stiffness;
    return {xx * v[0] + xy * v[1] + xz * v[2], xy * v[0] + yy * v[1] + yz * v[2], xz * v[0] + yz * v[1] + zz * v[2]};
}

HWY_INLINE void give_to_nodes(const TouchedRows &point, float factor, const std::array<float, 3> &force,
                              Aligned<float> &nodes) {
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c)
            nodes[4 * static_cast<std::size_t>(point.rows[k]) + c] += factor * point.shape[k] * force[c];
}

/// Blocks of nodes, and forces f - h K v, of what a ball touches.
HWY_NOINLINE void linearise_touched(CorotationalRows &rows, float step) {
    for (const auto &point : rows.touched) {
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t entry = 0; entry < 6; ++entry)
                rows.block[entry / 3][4 * static_cast<std::size_t>(point.rows[k]) + entry % 3] +=
                    point.shape[k] * point.shape[k] * point.stiffness[entry];
        auto force = pull_at(point, value_at(point, rows.body.velocity));
        for (std::size_t c = 0; c < 3; ++c)
            force[c] = point.force[c] - step * force[c];
        give_to_nodes(point, 1.0F, force, rows.product);
    }
}

/// Adds h^2 K p to the product.
/// @return p . h^2 K p
HWY_NOINLINE double multiply_touched(CorotationalRows &rows, float step) {
    double sum = 0.0;
    for (const auto &point : rows.touched) {
        const auto direction = value_at(point, rows.direction), pull = pull_at(point, direction);
        give_to_nodes(point, step * step, pull, rows.product);
        for (std::size_t c = 0; c < 3; ++c)
            sum += static_cast<double>(step) * step * direction[c] * pull[c];
    }
    return sum;
}

void take_corotational(CorotationalRows &rows, double time_step, double mass_damping, int iterations) {
    constexpr double rounding = 1e-14; // of squares: what is left then is not known
    const auto h = static_cast<float>(time_step), damping = static_cast<float>(1.0 + mass_damping * time_step);
    linearise(rows, h);
    linearise_springs(rows, h);
    for (std::size_t k = 0; k < 2; ++k)
        sum_at_nodes(rows.body, rows.block_slots[k], rows.spring_block_slots[k], rows.block[k]);
    sum_at_nodes(rows.body, rows.body.force, rows.body.springs.force, rows.product);
    linearise_touched(rows, h);
    invert_blocks(rows, h, damping);
    double squared = begin_solve(rows, h, static_cast<float>(mass_damping));
    const double enough = rounding * squared;
    for (int i = 0; i < iterations && squared > enough; ++i) {
        multiply_tetrahedra(rows);
        multiply_springs(rows);
        double curvature = finish_product(rows, h, damping);
        curvature += multiply_touched(rows, h);
        const double next = go_along(rows, static_cast<float>(squared / curvature));
        combine_rows(rows.direction, static_cast<float>(next / squared), rows.preconditioned);
        squared = next;
    }
    add_rows(rows.body.displacement, h, rows.body.velocity);
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::interactive::kernels {

CorotationalRows corotational_rows(const Scene &scene, std::span<const PointSpring> springs) {
    CorotationalRows rows;
    rows.body = explicit_rows(scene, Pressure::of_tetrahedra, springs);
    rows.turned = rows.body.tetrahedra;
    const std::size_t num_lines = rows.body.line_start.back();
    rows.rotation.assign(num_lines * numbers_of_rotation * slice_size, 0.0F);
    for (std::size_t line = 0; line < num_lines; ++line)
        std::fill_n(rows.rotation.begin() + static_cast<std::ptrdiff_t>(line * numbers_of_rotation * slice_size),
                    slice_size, 1.0F);
    for (auto &slots : rows.block_slots)
        slots.assign(rows.body.force.size(), 0.0F);
    for (auto &slots : rows.spring_block_slots)
        slots.assign(rows.body.springs.force.size(), 0.0F);
    for (const auto &set : rows.body.springs.sets)
        rows.spring_tangent.emplace_back(set.num_batches() * numbers_of_tangent * slice_size, 0.0F);
    for (auto *field : {&rows.block[0], &rows.block[1], &rows.mass, &rows.residual, &rows.direction, &rows.product,
                        &rows.preconditioned})
        field->assign(4 * rows.body.num_rows, 0.0F);
    rows.inverse_block.assign(6 * rows.body.num_rows, 0.0F);

    std::vector<double> laplacian(scene.node_mass.size(), 0.0);
    for (const auto &t : tetrahedra_at_rest(*scene.body)) {
        const auto gradients = t.shape_gradients();
        for (int c = 0; c < 4; ++c)
            laplacian[t.nodes[c]] += t.volume * t.mu * gradients.row(c).squaredNorm();
    }
    for (std::size_t row = 0; row < rows.body.num_rows; ++row) // what fills up has some mass
        std::fill_n(rows.mass.begin() + static_cast<std::ptrdiff_t>(4 * row), 3, 1.0F);
    for (std::size_t i = 0; i < laplacian.size(); ++i) {
        const auto at = rows.mass.begin() + std::ptrdiff_t{4} * rows.body.row_of_node[i];
        std::fill_n(at, 3, static_cast<float>(scene.node_mass[i]));
        at[3] = static_cast<float>(laplacian[i]);
    }
    return rows;
}

std::size_t CorotationalRows::bytes() const {
    std::size_t bytes = body.bytes() + bytes_of(turned, rotation, block_slots[0], block_slots[1], block[0], block[1],
                                                mass, residual, direction, product, preconditioned, inverse_block,
                                                spring_block_slots[0], spring_block_slots[1]);
    for (const auto &tangent : spring_tangent)
        bytes += bytes_of(tangent);
    return bytes;
}

void find_nearest_rotation(const std::array<float, 9> &h, std::array<float, 4> &q) {
    const Matrix3 f = Eigen::Map<const Eigen::Matrix3f>(h.data()).cast<double>() + Matrix3::Identity();
    if (!f.allFinite())
        return;
    const Eigen::Quaterniond found(densities::nearest_rotation(f));
    q = {static_cast<float>(found.w()), static_cast<float>(found.x()), static_cast<float>(found.y()),
         static_cast<float>(found.z())};
}

LIVERMARK_DISPATCH(void take_corotational_step, take_corotational,
                   (CorotationalRows & rows, double time_step, double mass_damping, int iterations),
                   (rows, time_step, mass_damping, iterations))

} // namespace livermark::interactive::kernels
#endif
