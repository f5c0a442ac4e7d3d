// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/prefactored_steps.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h

#include <Eigen/Dense>
#include <utility>

#include "core/support/vector_dispatch.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/kernels/point_springs-inl.hpp"
#include "interactive/kernels/tetrahedra-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Vectors that a block of rows takes.
constexpr std::size_t num_groups = slice_size / hn::MaxLanes(D());

/// Rows += B own, of so many blocks side by side that have the same columns: each number of own is read once for them.
template <int num_blocks>
HWY_INLINE void add_products(FactorRows &rows, const Panel &panel, std::size_t block, const float *values) {
    const std::size_t num_columns = panel.columns_of_block(block);
    for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
        const std::int32_t *row = rows.row.data() + (panel.first_block + block) * slice_size + lane;
        Vec3 sum[num_blocks];
        for (int b = 0; b < num_blocks; ++b)
            sum[b] = fetch(rows.x.data(), row + b * slice_size).v;
        const float *column = values + lane, *own = rows.own.data();
        for (std::size_t j = 0; j < num_columns; ++j, column += slice_size, own += 4) {
            const Vec3 right{number(own[0]), number(own[1]), number(own[2])};
            for (int b = 0; b < num_blocks; ++b) {
                const auto entry = hn::Load(d, column + b * num_columns * slice_size);
                sum[b] = plus_scaled(sum[b], entry, right);
            }
        }
        for (int b = 0; b < num_blocks; ++b)
            store(sum[b], rows.x.data(), row + b * slice_size);
    }
}

HWY_INLINE void go_forwards(FactorRows &rows, const Panel &panel) {
    float *own = rows.x.data() + 4 * panel.first_column;
    std::copy_n(own, 4 * panel.num_columns, rows.own.data());
    std::fill(rows.own.data() + 4 * panel.num_columns, rows.own.data() + 4 * panel.stored_columns(), 0.0F);
    std::fill_n(own, 4 * panel.num_columns, 0.0F);
    const float *values = rows.values.data() + panel.first_value;
    const auto go_on = [&](std::size_t block, std::size_t num_blocks)
                           HWY_ATTR { values += num_blocks * panel.columns_of_block(block) * slice_size; };
    std::size_t block = 0;
    for (; block < panel.num_blocks && panel.columns_of_block(block) < panel.stored_columns(); ++block) {
        add_products<1>(rows, panel, block, values);
        go_on(block, 1);
    }
    for (; block + 4 <= panel.num_blocks; block += 4) {
        add_products<4>(rows, panel, block, values);
        go_on(block, 4);
    }
    if (block + 2 <= panel.num_blocks) {
        add_products<2>(rows, panel, block, values);
        go_on(block, 2);
        block += 2;
    }
    if (block < panel.num_blocks)
        add_products<1>(rows, panel, block, values);
}

/// Sums that lanes of a block have in each component.
struct BlockSums {
    Vec3 group[num_groups];
};

#if HWY_TARGET == HWY_SCALAR

/// A row of the sums over all lanes, in the order that all vectors have.
HWY_INLINE void store_sums(const BlockSums &sums, float *at) {
    const auto sum = [&](V Vec3::*component) {
        float fours[4];
        for (std::size_t b = 0; b < 4; ++b) {
            const auto lane = [&](std::size_t i) { return hn::GetLane(sums.group[4 * b + i].*component); };
            fours[b] = (lane(0) + lane(1)) + (lane(2) + lane(3));
        }
        return (fours[0] + fours[2]) + (fours[1] + fours[3]);
    };
    at[0] = sum(&Vec3::x);
    at[1] = sum(&Vec3::y);
    at[2] = sum(&Vec3::z);
}

#else

/// The sum of all blocks of 16 bytes: halves first.
template <class Tag> HWY_INLINE hn::Vec<hn::Full128<float>> sum_of_blocks(Tag tag, hn::Vec<Tag> blocks) {
    if constexpr (hn::MaxLanes(tag) == 4) {
        return blocks;
    } else {
        const hn::Half<Tag> half;
        return sum_of_blocks(half, hn::Add(hn::LowerHalf(half, blocks), hn::UpperHalf(half, blocks)));
    }
}

HWY_INLINE void store_sums(const BlockSums &sums, float *at) {
    V blocks[num_groups];
    for (std::size_t g = 0; g < num_groups; ++g) {
        const auto &[x, y, z] = sums.group[g];
        const auto t = FourByFour{x, y, z, hn::Zero(d)}.transposed();
        blocks[g] = hn::Add(hn::Add(t.r0, t.r1), hn::Add(t.r2, t.r3));
    }
    for (std::size_t n = num_groups / 2; n > 0; n /= 2)
        for (std::size_t g = 0; g < n; ++g)
            blocks[g] = hn::Add(blocks[g], blocks[g + n]);
    hn::Store(sum_of_blocks(d, blocks[0]), hn::Full128<float>(), at);
}

#endif

HWY_INLINE void go_backwards(FactorRows &rows, const Panel &panel) {
    // As many at once as there are registers for.
    constexpr std::size_t at_once = num_groups == 1 ? Panel::columns_at_once : num_groups == 2 ? 2 : 1;
    float *const fetched = rows.fetched.data();
    for (std::size_t block = 0; block < panel.num_blocks; ++block)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const auto v = fetch(rows.x.data(), rows.row.data() + (panel.first_block + block) * slice_size + lane).v;
            store3(v, fetched + 3 * slice_size * block + lane);
        }
    const auto zero = hn::Zero(d);
    const float *values = rows.values.data() + panel.first_value; // of the first block that has the columns
    for (std::size_t column = 0; column < panel.stored_columns(); column += at_once) {
        if (column > 0 && column % slice_size == 0)
            values += panel.columns_of_block(column / slice_size - 1) * slice_size;
        BlockSums sums[at_once];
        for (auto &column_sums : sums)
            for (auto &group : column_sums.group)
                group = {zero, zero, zero};
        const float *entries = values + column * slice_size;
        for (std::size_t block = column / slice_size; block < panel.num_blocks; ++block) {
            for (std::size_t g = 0; g < num_groups; ++g) {
                const std::size_t lane = g * hn::Lanes(d);
                const auto v = load3(fetched + 3 * slice_size * block + lane);
                for (std::size_t c = 0; c < at_once; ++c) {
                    const auto entry = hn::Load(d, entries + c * slice_size + lane);
                    sums[c].group[g] = plus_scaled(sums[c].group[g], entry, v);
                }
            }
            entries += panel.columns_of_block(block) * slice_size;
        }
        for (std::size_t c = 0; c < at_once && column + c < panel.num_columns; ++c)
            store_sums(sums[c], rows.x.data() + 4 * (panel.first_column + column + c));
    }
}

/// x <- (P A P^T)^-1 x
inline HWY_NOINLINE void solve(FactorRows &rows) {
    for (const auto &panel : rows.panels)
        go_forwards(rows, panel);
    for (std::size_t p = rows.panels.size(); p-- > 0;)
        go_backwards(rows, rows.panels[p]);
}

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

/// Rounding of sums of invariants, with few digits to spare.
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
    const auto one_part = hn::MulAdd(
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
    const auto h_part = hn::Add(one_part, two_p);
    const auto column = [&](const Vec3 &h_column, const Vec3 &change_column, const Vec3 &e_column) HWY_ATTR {
        const auto turned = e_column + combined(e_column.x, h.x, e_column.y, h.y, e_column.z, h.z); // F 2 E
        const auto entry = [&](V h_entry, V change_entry, V turned_entry) HWY_ATTR {
            const auto rest = hn::MulSub(two, turned_entry, hn::Mul(two_p, change_entry));
            return hn::Mul(inverse, hn::MulAdd(h_part, h_entry, rest));
        };
        return Vec3{entry(h_column.x, change_column.x, turned.x), entry(h_column.y, change_column.y, turned.y),
                    entry(h_column.z, change_column.z, turned.z)};
    };
    return plus_ones({column(h.x, change.x, e.x), column(h.y, change.y, e.y), column(h.z, change.z, e.z)},
                     hn::Mul(inverse, one_part));
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
        const auto entry = [&](const Vec3 &column, const Vec3 &change_column)
                               HWY_ATTR { return plus_scaled(column, n, change_column); };
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

/// V (2 mu (F - R) + 3 lambda (F - D))
struct ProjectiveStress {
    HWY_INLINE Matrix operator()(const Fans &fans, const Matrix &h) const {
        const auto cofactors = cofactors_of(h);
        const auto growth = growth_of(h, cofactors);
        const auto change = change_of_cofactors(h, cofactors);
        const auto square = dot(h, h);
        const auto shape = hn::Mul(number(2.0F), fans.number_of_tetrahedron(9)),
                   volume = hn::Mul(number(3.0F), fans.number_of_tetrahedron(10));
        return combined(shape, beyond_rotation(h, change, growth, square), volume,
                        beyond_unit_determinant(h, change, growth, square));
    }
};

/// Right-hand sides m (1 + alpha h) / h^2 (y - x) - dW/dx: what inertia adds to forces.
HWY_INLINE V with_inertia(V force, const PrefactoredRows &rows, const NodeRows &nodes, std::size_t at) {
    const auto behind = hn::Sub(hn::Load(d, rows.predicted.data() + at), hn::Load(d, nodes.displacement.data() + at));
    return hn::MulAdd(hn::Load(d, rows.stiffness.data() + at), behind, force);
}

HWY_NOINLINE void find_right(PrefactoredRows &rows, ExplicitRows &body) {
    find_forces_of_fans(body, ProjectiveStress());
    find_forces_of_springs(body.springs, body.displacement);
    constexpr std::size_t width = 4 * nodes_at_once;
    for (std::size_t four = 0; four + 1 < body.slot_start.size(); ++four)
        for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
            const std::size_t at = four * width + lane;
            const auto elements = summed_slots(body, body.force, four, lane, hn::Zero(d));
            const auto force = summed_slots(body.springs, body.springs.force, four, lane, elements);
            hn::Store(with_inertia(force, rows, body, at), d, rows.right.data() + at);
        }
}

HWY_NOINLINE void find_right(PrefactoredRows &rows, SpringRows &body) {
    const float *const nodes = body.displacement.data();
    const auto zero = hn::Zero(d);
    for (std::size_t slice = 0; slice + 1 < body.item_start.size(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const std::int32_t *const self = body.self.data() + slice * slice_size + lane;
            const auto here = fetch(nodes, self).v;
            Vec3 force{zero, zero, zero};
            for (std::size_t item = body.item_start[slice]; item < body.item_start[slice + 1]; ++item) {
                const float *const numbers = body.numbers.data() + item * numbers_of_spring * slice_size + lane;
                const auto other = fetch(nodes, body.other.data() + item * slice_size + lane).v;
                const StretchedSpring spring(load3(numbers), other - here, hn::Load(d, numbers + 3 * slice_size));
                const auto tension = hn::Mul(hn::Load(d, numbers + 4 * slice_size), spring.change);
                force = plus_scaled(force, hn::Div(tension, spring.length), spring.now);
            }
            store(force, body.force.data(), self);
        }
    find_forces_of_springs(body.beside, body.displacement);
    constexpr std::size_t width = 4 * nodes_at_once;
    for (std::size_t four = 0; four + 1 < body.beside.slot_start.size(); ++four)
        for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
            const std::size_t at = four * width + lane;
            const auto on_edges = hn::Load(d, body.force.data() + at);
            const auto force = summed_slots(body.beside, body.beside.force, four, lane, on_edges);
            hn::Store(with_inertia(force, rows, body, at), d, rows.right.data() + at);
        }
}

void take_step(PrefactoredRows &rows, double time_step, double mass_damping, int iterations) {
    auto &nodes = rows.nodes();
    predict(nodes, rows.before, static_cast<float>(time_step), static_cast<float>(1.0 + mass_damping * time_step));
    rows.predicted = nodes.displacement;
    float *const x = rows.factor.x.data();
    for (int i = 0; i < iterations && rows.factor.num_unknowns > 0; ++i) {
        std::visit([&](auto &body) { find_right(rows, body); }, rows.elements);
        for (std::size_t row = 0; row < rows.place.size(); ++row)
            std::copy_n(rows.right.data() + 4 * row, 4, x + rows.place[row]);
        std::fill_n(x + 4 * rows.factor.num_unknowns, 4, 0.0F);
        solve(rows.factor);
        for (std::size_t row = 0; row < rows.place.size(); ++row)
            for (std::size_t c = 0; c < 4; ++c)
                nodes.displacement[4 * row + c] += x[rows.place[row] + c];
        if (rows.after_iteration)
            rows.after_iteration();
    }
    find_velocities(nodes, rows.before, static_cast<float>(1.0 / time_step));
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::interactive::kernels {

namespace {

/// Panel of a supernode, shape (rows, columns).
Eigen::MatrixXd panel_matrix(const support::SupernodalFactor &factor, std::size_t s) {
    const auto &[first_column, row_start, row, value_start] = factor.supernodes;
    const Eigen::Index num_columns = first_column[s + 1] - first_column[s], num_rows = row_start[s + 1] - row_start[s];
    Eigen::MatrixXd panel = Eigen::Map<const Eigen::MatrixXd>(&factor.values[value_start[s]], num_rows, num_columns);
    const Eigen::MatrixXd inverse = panel.topRows(num_columns)
                                        .triangularView<Eigen::Lower>()
                                        .solve(Eigen::MatrixXd::Identity(num_columns, num_columns));
    panel.topRows(num_columns) = inverse;
    // The inverse has a triangle of numbers only; what a column needs stands at and behind it, so it can be replaced.
    auto below = panel.bottomRows(num_rows - num_columns);
    for (Eigen::Index j = 0; j < num_columns; ++j) {
        below.col(j) *= -inverse(j, j);
        for (Eigen::Index k = j + 1; k < num_columns; ++k)
            below.col(j) -= inverse(k, j) * below.col(k);
    }
    return panel;
}

void place_panel(const Eigen::MatrixXd &matrix, const Panel &panel, Aligned<float> &values) {
    for (std::size_t block = 0; block < panel.num_blocks; ++block) {
        const auto first = static_cast<Eigen::Index>(block * slice_size);
        const auto num_lanes = std::min<Eigen::Index>(slice_size, matrix.rows() - first);
        std::size_t at = values.size();
        values.resize(at + panel.columns_of_block(block) * slice_size, 0.0F);
        const auto num_columns = std::min<std::size_t>(panel.columns_of_block(block), matrix.cols());
        for (std::size_t column = 0; column < num_columns; ++column, at += slice_size)
            Eigen::Map<Eigen::VectorXf>(values.data() + at, num_lanes) =
                matrix.col(static_cast<Eigen::Index>(column)).segment(first, num_lanes).cast<float>();
    }
}

} // namespace

FactorRows factor_rows(const support::SupernodalFactor &factor) {
    FactorRows rows;
    rows.num_unknowns = factor.order.size();
    rows.place.resize(rows.num_unknowns);
    for (std::size_t k = 0; k < rows.num_unknowns; ++k)
        rows.place[factor.order[k]] = static_cast<std::int32_t>(4 * k);
    rows.x.assign(4 * (rows.num_unknowns + 1), 0.0F);
    const auto &all = factor.supernodes;
    std::size_t most_columns = 0, most_blocks = 0;
    for (std::size_t s = 0; s + 1 < all.first_column.size(); ++s) {
        const auto panel_rows = all.row.subspan(all.row_start[s], all.row_start[s + 1] - all.row_start[s]);
        const Panel panel{.first_column = static_cast<std::size_t>(all.first_column[s]),
                          .num_columns = static_cast<std::size_t>(all.first_column[s + 1] - all.first_column[s]),
                          .first_block = rows.row.size() / slice_size,
                          .num_blocks = filled_up(panel_rows.size()) / slice_size,
                          .first_value = rows.values.size()};
        for (const int row : panel_rows)
            rows.row.push_back(4 * row);
        rows.row.resize(filled_up(rows.row.size()), static_cast<std::int32_t>(4 * rows.num_unknowns));
        place_panel(panel_matrix(factor, s), panel, rows.values);
        most_columns = std::max(most_columns, panel.stored_columns());
        most_blocks = std::max(most_blocks, panel.num_blocks);
        rows.panels.push_back(panel);
    }
    rows.own.assign(4 * most_columns, 0.0F);
    rows.fetched.assign(3 * slice_size * most_blocks, 0.0F);
    return rows;
}

namespace {

struct SpringAtNode {
    std::size_t spring;
    int other;
};

/// Numbers that fill up: of some length.
constexpr float numbers_of_no_spring[numbers_of_spring] = {1.0F, 0.0F, 0.0F, 1.0F, 0.0F};

} // namespace

SpringRows spring_rows(const Scene &scene, const Springs &springs, std::span<const PointSpring> beside) {
    const auto &mesh = scene.body->mesh;
    std::vector<std::vector<SpringAtNode>> at_node(mesh.points.size());
    std::vector<int> num_springs(mesh.points.size(), 0);
    for (std::size_t s = 0; s < springs.edges.size(); ++s)
        for (std::size_t end = 0; end < 2; ++end) {
            at_node[springs.edges[s][end]].push_back({s, springs.edges[s][1 - end]});
            ++num_springs[springs.edges[s][end]];
        }
    SpringRows rows;
    const bool has_order = scene.orders && scene.orders->rows.size() == mesh.points.size();
    const auto order = has_order ? scene.orders->rows : order_of_nodes(mesh.tetrahedra, {}, num_springs);
    rows.place(scene, order);
    rows.force.assign(4 * rows.num_rows, 0.0F);
    for (std::size_t row = 0; row < rows.num_rows; ++row)
        rows.self.push_back(static_cast<std::int32_t>(4 * row));
    rows.item_start.assign(1, 0);
    for (std::size_t first = 0; first < rows.num_rows; first += slice_size) {
        const std::size_t last = std::min(first + slice_size, order.size());
        std::size_t most = 0;
        for (std::size_t row = first; row < last; ++row)
            most = std::max(most, at_node[order[row]].size());
        for (std::size_t k = 0; k < most; ++k) {
            const std::size_t at = rows.numbers.size();
            rows.numbers.resize(at + numbers_of_spring * slice_size);
            for (std::size_t lane = 0; lane < slice_size; ++lane) {
                const std::size_t row = first + lane;
                const auto put = [&](const auto &numbers) {
                    for (std::size_t n = 0; n < numbers_of_spring; ++n)
                        rows.numbers[at + n * slice_size + lane] = static_cast<float>(numbers[n]);
                };
                if (row >= last || k >= at_node[order[row]].size()) {
                    rows.other.push_back(rows.self[row]);
                    put(numbers_of_no_spring);
                    continue;
                }
                const auto [spring, other] = at_node[order[row]][k];
                const core::Vector3 to_other = mesh.points[other] - mesh.points[order[row]];
                rows.other.push_back(4 * rows.row_of_node[other]);
                put(std::array{to_other.x(), to_other.y(), to_other.z(), springs.rest_length[spring],
                               springs.stiffness[spring]});
            }
        }
        rows.item_start.push_back(rows.item_start.back() + most);
    }
    rows.beside = point_spring_rows(scene, beside, rows);
    return rows;
}

PrefactoredRows::PrefactoredRows(PrefactoredElements body) : elements(std::move(body)) {
    for (auto *field : {&before, &predicted, &stiffness, &right})
        field->assign(4 * nodes().num_rows, 0.0F);
}

const NodeRows &PrefactoredRows::nodes() const {
    return std::visit([](const auto &body) -> const NodeRows & { return body; }, elements);
}

std::size_t PrefactoredRows::bytes() const {
    return std::visit([](const auto &body) { return body.bytes(); }, elements) + factor.bytes() +
           bytes_of(place, before, predicted, stiffness, right);
}

Orders PrefactoredRows::orders() const {
    if (const auto *body = std::get_if<ExplicitRows>(&elements))
        return body->orders();
    Orders orders;
    orders.rows = nodes().order();
    return orders;
}

void PrefactoredRows::set_factor(const support::SupernodalFactor &matrix, const std::vector<int> &unknown,
                                 const std::vector<double> &inertia) {
    factor = factor_rows(matrix);
    place.assign(nodes().num_rows, static_cast<std::int32_t>(4 * factor.num_unknowns));
    for (std::size_t i = 0; i < unknown.size(); ++i) {
        const auto row = static_cast<std::size_t>(nodes().row_of_node[i]);
        if (unknown[i] >= 0)
            place[row] = factor.place[unknown[i]];
        std::fill_n(stiffness.begin() + static_cast<std::ptrdiff_t>(4 * row), 3, static_cast<float>(inertia[i]));
    }
}

LIVERMARK_DISPATCH(void take_prefactored_step, take_step,
                   (PrefactoredRows & rows, double time_step, double mass_damping, int iterations),
                   (rows, time_step, mass_damping, iterations))

} // namespace livermark::interactive::kernels
#endif
