#include "fem_reference/solvers/divergence_rows.hpp"

#include <algorithm>

#include "fem_reference/solvers/multivector.hpp"
#include "fem_reference/solvers/rows_of_blocks.hpp"

namespace livermark::fem_reference {

namespace {

/// Some lanes of one number.
template <class T, int some> struct Single {
    typename Lanes<T, some>::Numbers value{};

    Single() = default;
    [[gnu::always_inline]] explicit Single(const T *place) { std::memcpy(&value, place, sizeof value); }
    [[gnu::always_inline]] void put(T *place) const { std::memcpy(place, &value, sizeof value); }
};

template <class T, int some, int lanes>
[[gnu::always_inline]] inline void add_dot(const std::array<T, 3> &row, const Triple<T, some, lanes> &vector,
                                           Single<T, some> &sum) {
    sum.value += row[0] * vector.x + row[1] * vector.y + row[2] * vector.z;
}

/// @tparam first, some  the lanes that are looked at, as in SymmetricBlocks
template <int lanes, int first, int some, class T>
[[gnu::always_inline]] inline void less_of_row(const DivergenceRows<T> &d, std::size_t q, const T *u, const T *g,
                                               T *out) {
    Single<T, some> sum;
    for (int k = d.row_start[q]; k < d.row_start[q + 1]; ++k)
        add_dot(d.value[k], Triple<T, some, lanes>(u + std::size_t{3} * lanes * d.column[k] + first), sum);
    sum.value -= Single<T, some>(g + lanes * q + first).value;
    sum.put(out + lanes * q + first);
}

template <int lanes, int first, int some, class T>
[[gnu::always_inline]] inline void products_of_row(const DivergenceRows<T> &d, std::size_t q, const T *u, const T *p,
                                                   T *force, T *imbalance) {
    Single<T, some> sum;
    const Single<T, some> of_row(p + lanes * q + first);
    for (int k = d.row_start[q]; k < d.row_start[q + 1]; ++k) {
        const auto place = std::size_t{3} * lanes * d.column[k] + first;
        const auto &value = d.value[k];
        add_dot(value, Triple<T, some, lanes>(u + place), sum);
        Triple<T, some, lanes> there(force + place);
        there.x += value[0] * of_row.value;
        there.y += value[1] * of_row.value;
        there.z += value[2] * of_row.value;
        there.put(force + place);
    }
    sum.value -= Single<T, some>(imbalance + lanes * q + first).value;
    sum.put(imbalance + lanes * q + first);
}

/// As many lanes as a vector of the processor holds.
template <class T, int lanes> constexpr int at_once = std::min<int>(lanes, 32 / sizeof(T));

template <int lanes, class T>
[[gnu::always_inline]] inline void less(const DivergenceRows<T> &d, const T *u, const T *g, T *out) {
    constexpr int some = at_once<T, lanes>;
    for (std::size_t q = 0; q < d.num_rows(); ++q) {
        less_of_row<lanes, 0, some>(d, q, u, g, out);
        if constexpr (lanes > some)
            less_of_row<lanes, some, lanes - some>(d, q, u, g, out);
    }
}

template <int lanes, class T>
[[gnu::always_inline]] inline void products(const DivergenceRows<T> &d, const T *u, const T *p, T *force,
                                            T *imbalance) {
    constexpr int some = at_once<T, lanes>;
    for (std::size_t q = 0; q < d.num_rows(); ++q) {
        products_of_row<lanes, 0, some>(d, q, u, p, force, imbalance);
        if constexpr (lanes > some)
            products_of_row<lanes, some, lanes - some>(d, q, u, p, force, imbalance);
    }
}

template <class T>
[[gnu::always_inline]] inline void less_of_lanes(const DivergenceRows<T> &d, const T *u, const T *g, T *out,
                                                 int lanes) {
    switch (lanes) { // a lambda would be compiled for one processor
    case 1:
        return less<1>(d, u, g, out);
    case 4:
        return less<4>(d, u, g, out);
    default:
        return less<most_lanes>(d, u, g, out);
    }
}

template <class T>
[[gnu::always_inline]] inline void products_of_lanes(const DivergenceRows<T> &d, const T *u, const T *p, T *force,
                                                     T *imbalance, int lanes) {
    switch (lanes) {
    case 1:
        return products<1>(d, u, p, force, imbalance);
    case 4:
        return products<4>(d, u, p, force, imbalance);
    default:
        return products<most_lanes>(d, u, p, force, imbalance);
    }
}

} // namespace

template <>
LIVERMARK_WIDE_CLONES void DivergenceRows<float>::subtract_product(std::span<const float> u, std::span<const float> g,
                                                                   std::span<float> out, int lanes) const {
    less_of_lanes(*this, u.data(), g.data(), out.data(), lanes);
}
template <>
LIVERMARK_WIDE_CLONES void DivergenceRows<double>::subtract_product(std::span<const double> u,
                                                                    std::span<const double> g, std::span<double> out,
                                                                    int lanes) const {
    less_of_lanes(*this, u.data(), g.data(), out.data(), lanes);
}
template <>
LIVERMARK_WIDE_CLONES void DivergenceRows<float>::add_products(std::span<const float> u, std::span<const float> p,
                                                               std::span<float> force, std::span<float> imbalance,
                                                               int lanes) const {
    products_of_lanes(*this, u.data(), p.data(), force.data(), imbalance.data(), lanes);
}
template <>
LIVERMARK_WIDE_CLONES void DivergenceRows<double>::add_products(std::span<const double> u, std::span<const double> p,
                                                                std::span<double> force, std::span<double> imbalance,
                                                                int lanes) const {
    products_of_lanes(*this, u.data(), p.data(), force.data(), imbalance.data(), lanes);
}

DivergenceRows<float> rounded(const DivergenceRows<double> &matrix) {
    DivergenceRows<float> result{matrix.row_start, matrix.column, {}};
    result.value.reserve(matrix.value.size());
    for (const auto &value : matrix.value)
        std::ranges::transform(value, result.value.emplace_back().begin(),
                               [](double x) { return static_cast<float>(x); });
    return result;
}

} // namespace livermark::fem_reference
