// Both triangular solves with a factor, for three right-hand sides. Written once for each vector unit: see
// prefactored_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_FACTOR_SOLVE_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_FACTOR_SOLVE_INL_HPP
#undef LIVERMARK_INTERACTIVE_FACTOR_SOLVE_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_FACTOR_SOLVE_INL_HPP
#endif

#include <algorithm>

#include "interactive/kernels/prefactored/prefactored_rows.hpp"
#include "interactive/kernels/vectors-inl.hpp"

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
            const Vec3 of_column{number(own[0]), number(own[1]), number(own[2])};
            for (int b = 0; b < num_blocks; ++b) {
                const auto entry = hn::Load(d, column + b * num_columns * slice_size);
                sum[b] = plus_scaled(sum[b], entry, of_column);
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

/// What lanes of a block have in each component.
struct BlockSums {
    Vec3 group[num_groups];
};

#if HWY_TARGET == HWY_SCALAR

/// A row of the sums over all lanes, in the order that all vectors have.
HWY_INLINE void store_sums(const BlockSums &sums, float *at) {
    const auto sum = [&](V Vec3::*component) {
        float of_four[4];
        for (std::size_t b = 0; b < 4; ++b) {
            const auto lane = [&](std::size_t i) { return hn::GetLane(sums.group[4 * b + i].*component); };
            of_four[b] = (lane(0) + lane(1)) + (lane(2) + lane(3));
        }
        return (of_four[0] + of_four[2]) + (of_four[1] + of_four[3]);
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
        for (auto &of_column : sums)
            for (auto &group : of_column.group)
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

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_FACTOR_SOLVE_INL_HPP
