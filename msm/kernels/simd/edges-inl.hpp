// Means around edges of the Cauchy-Green tensor and of the deformation gradient. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_EDGES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_EDGES_INL_HPP
#undef LIVERMARK_EDGES_INL_HPP
#else
#define LIVERMARK_EDGES_INL_HPP
#endif

#include <algorithm>
#include <array>
#include <type_traits>

#include "msm/kernels/simd/coupled_means-inl.hpp"
#include "msm/kernels/simd/means-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

// Rows of eight numbers and more at scattered places: those of tetrahedra, which edges sum, and those of edges, which
// tetrahedra sum. Rows of a slice stand in the order of row_of_lane().

template <class D, class T> HWY_INLINE void keep(D d, const Blocks<D> &blocks, T *at) {
    constexpr std::size_t lanes = hn::MaxLanes(D());
    hn::Store(blocks.r0, d, at);
    hn::Store(blocks.r1, d, at + lanes);
    hn::Store(blocks.r2, d, at + 2 * lanes);
    hn::Store(blocks.r3, d, at + 3 * lanes);
}
template <class D, class T> HWY_INLINE Blocks<D> kept_blocks(D d, const T *at) {
    constexpr std::size_t lanes = hn::MaxLanes(D());
    return {hn::Load(d, at), hn::Load(d, at + lanes), hn::Load(d, at + 2 * lanes), hn::Load(d, at + 3 * lanes)};
}

/// Eight numbers of each lane as they are loaded. Sums are made of these, and then numbers_of().
template <class D> struct EightBlocks {
    Blocks<D> a, b;

    template <class T> HWY_INLINE static EightBlocks kept(D d, const T *at) {
        return {kept_blocks(d, at), kept_blocks(d, at + 4 * hn::MaxLanes(D()))};
    }
};
template <class D, class T> HWY_INLINE void keep(D d, const EightBlocks<D> &rows, T *at) {
    keep(d, rows.a, at);
    keep(d, rows.b, at + 4 * hn::MaxLanes(D()));
}

template <class D> HWY_INLINE EightBlocks<D> plus(const EightBlocks<D> &a, const EightBlocks<D> &b) {
    return {plus<D>(a.a, b.a), plus<D>(a.b, b.b)};
}

#if HWY_TARGET <= HWY_AVX3
template <class D> inline constexpr bool has_pairs_of_rows = std::is_same_v<hn::Vec<D>, hn::Vec512<float>>;
#else
template <class D> inline constexpr bool has_pairs_of_rows = false;
#endif

/// Eight numbers of each lane from scattered places. The widest vectors take two rows at once, those of lanes four
/// apart.
template <class D, class T> HWY_INLINE EightBlocks<D> fetch_eight(D d, const T *rows, const std::int32_t *index) {
    if constexpr (has_pairs_of_rows<D>) {
        const hn::Half<D> half;
        const auto two = [&](int lane) HWY_ATTR {
            return joined(d, hn::LoadU(half, rows + index[lane + 4]), hn::LoadU(half, rows + index[lane]));
        };
        return {{two(0), two(1), two(2), two(3)}, {two(8), two(9), two(10), two(11)}};
    } else {
        return {fetch_blocks(d, rows, index), fetch_blocks(d, rows + 4, index)};
    }
}

template <class D> HWY_INLINE std::array<Rows<D>, 2> numbers_of(D d, const EightBlocks<D> &rows) {
#if HWY_TARGET <= HWY_AVX3
    if constexpr (has_pairs_of_rows<D>) {
        const auto first = [](const hn::Vec<D> &a, const hn::Vec<D> &b)
                               HWY_ATTR { return hn::Vec<D>{_mm512_shuffle_f32x4(a.raw, b.raw, 0x88)}; };
        const auto last = [](const hn::Vec<D> &a, const hn::Vec<D> &b)
                              HWY_ATTR { return hn::Vec<D>{_mm512_shuffle_f32x4(a.raw, b.raw, 0xDD)}; };
        const auto &[a, b] = rows;
        return {transposed<D>(d, {first(a.r0, b.r0), first(a.r1, b.r1), first(a.r2, b.r2), first(a.r3, b.r3)}),
                transposed<D>(d, {last(a.r0, b.r0), last(a.r1, b.r1), last(a.r2, b.r2), last(a.r3, b.r3)})};
    }
#endif
    return {transposed<D>(d, rows.a), transposed<D>(d, rows.b)};
}

/// Puts four numbers of each lane into their rows.
/// @param rows  of the slice, with row_size numbers each
template <std::size_t row_size, class D, class T>
HWY_INLINE void put_four(D d, const Rows<D> &numbers, T *rows, std::size_t lane) {
    HWY_ALIGN std::array<T, 4 * slice_size> four;
    hn::StoreInterleaved4(numbers.x, numbers.y, numbers.z, numbers.w, d, four.data());
    for (std::size_t i = 0; i < hn::Lanes(d); ++i)
        std::copy_n(four.data() + 4 * i, 4,
                    rows + row_size * static_cast<std::size_t>(row_of_lane(static_cast<int>(lane + i))));
}

template <class D, class T>
HWY_INLINE void put_eight(D d, const std::array<Rows<D>, 2> &numbers, T *rows, std::size_t lane) {
#if HWY_TARGET <= HWY_AVX3
    if constexpr (has_pairs_of_rows<D>) {
        const hn::RepartitionToWide<decltype(hn::RebindToUnsigned<D>())> pairs;
        const auto blocks_of = [&](const Rows<D> &of) HWY_ATTR {
            const auto xy01 = hn::BitCast(pairs, hn::InterleaveLower(d, of.x, of.y));
            const auto zw01 = hn::BitCast(pairs, hn::InterleaveLower(d, of.z, of.w));
            const auto xy23 = hn::BitCast(pairs, hn::InterleaveUpper(d, of.x, of.y));
            const auto zw23 = hn::BitCast(pairs, hn::InterleaveUpper(d, of.z, of.w));
            return Blocks<D>{hn::BitCast(d, hn::InterleaveLower(pairs, xy01, zw01)),
                             hn::BitCast(d, hn::InterleaveUpper(pairs, xy01, zw01)),
                             hn::BitCast(d, hn::InterleaveLower(pairs, xy23, zw23)),
                             hn::BitCast(d, hn::InterleaveUpper(pairs, xy23, zw23))};
        };
        const auto lower = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
        const auto upper = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
        const auto put = [&](std::size_t k, const hn::Vec<D> &first, const hn::Vec<D> &last) HWY_ATTR {
            const auto a = _mm512_castps_pd(first.raw), b = _mm512_castps_pd(last.raw);
            hn::Store(hn::Vec<D>{_mm512_castpd_ps(_mm512_permutex2var_pd(a, lower, b))}, d, rows + 32 * k);
            hn::Store(hn::Vec<D>{_mm512_castpd_ps(_mm512_permutex2var_pd(a, upper, b))}, d, rows + 32 * k + 16);
        };
        const auto a = blocks_of(numbers[0]), b = blocks_of(numbers[1]);
        put(0, a.r0, b.r0);
        put(1, a.r1, b.r1);
        put(2, a.r2, b.r2);
        put(3, a.r3, b.r3);
        return;
    }
#endif
    put_four<8>(d, numbers[0], rows, lane);
    put_four<8>(d, numbers[1], rows + 4, lane);
}

/// Means of C around edges: values are C - I, and stresses by them the second ones of Piola and Kirchhoff.
template <class D> struct EdgeMeansOfC {
    using T = hn::TFromD<D>;
    using Value = Symmetric<D>;
    using OfTensor = MeansOfStrains<D>;
    using Row = EightBlocks<D>;
    static constexpr std::size_t row_size = 8;

    HWY_INLINE static Row fetch(D d, const T *rows, const std::int32_t *index) { return fetch_eight(d, rows, index); }
    HWY_INLINE static Value value_of(D d, const Row &row) {
        return livermark::msm::HWY_NAMESPACE::value_of<D>(numbers_of(d, row));
    }
    HWY_INLINE static void put(D d, const Value &value, T *rows, std::size_t lane) {
        put_eight(d, rows_of(d, value, hn::Zero(d)), rows, lane);
    }

    HWY_INLINE static Value gradient_value(D d, const Columns<D> &f) { return twice_strain(d, f); }
    HWY_INLINE static Value rate_of_gradient(const Columns<D> &f, const Columns<D> &f_rate) {
        return twice_strain_rate<D>(f, f_rate);
    }
    /// The first stress of a tetrahedron times its volume, of the sum over its edges and a pressure mu inside:
    /// F (V S + mu I).
    /// @param faded  what has relaxed of the stress inside, times the volume; null if nothing does
    HWY_INLINE static Columns<D> first_stress(const Columns<D> &f, hn::Vec<D> rest_volume, const Value &sum,
                                              hn::Vec<D> inside, const T *faded) {
        return MeansOfC<false, T>::first_stress(f, rest_volume, sum, inside, faded);
    }
};

/// Eight numbers of each lane, and four more.
template <class D> struct TwelveBlocks {
    EightBlocks<D> eight;
    Blocks<D> four;

    template <class T> HWY_INLINE static TwelveBlocks kept(D d, const T *at) {
        return {EightBlocks<D>::kept(d, at), kept_blocks(d, at + 8 * hn::MaxLanes(D()))};
    }
};
template <class D, class T> HWY_INLINE void keep(D d, const TwelveBlocks<D> &rows, T *at) {
    keep(d, rows.eight, at);
    keep(d, rows.four, at + 8 * hn::MaxLanes(D()));
}
template <class D> HWY_INLINE TwelveBlocks<D> plus(const TwelveBlocks<D> &a, const TwelveBlocks<D> &b) {
    return {plus<D>(a.eight, b.eight), plus<D>(a.four, b.four)};
}

/// Means of F around edges: values are F - I, and stresses by them the first ones of Piola and Kirchhoff.
template <class D> struct EdgeMeansOfF {
    using T = hn::TFromD<D>;
    using Value = Columns<D>;
    using OfTensor = MeansOfGradients<D>;
    using Row = TwelveBlocks<D>;
    static constexpr std::size_t row_size = 12;

    HWY_INLINE static Row fetch(D d, const T *rows, const std::int32_t *index) {
        return {fetch_eight(d, rows, index), fetch_blocks(d, rows + 8, index)};
    }
    HWY_INLINE static Value value_of(D d, const Row &row) {
        const auto eight = numbers_of(d, row.eight);
        return livermark::msm::HWY_NAMESPACE::value_of<D>(
            std::array<Rows<D>, 3>{eight[0], eight[1], transposed<D>(d, row.four)});
    }
    HWY_INLINE static void put(D d, const Value &value, T *rows, std::size_t lane) {
        const auto numbers = rows_of(d, value, hn::Zero(d));
        for (std::size_t k = 0; k < 3; ++k)
            put_four<row_size>(d, numbers[k], rows + 4 * k, lane);
    }

    HWY_INLINE static Value gradient_value(D d, Columns<D> f) {
        const auto one = hn::Set(d, T(1));
        f.x.x = hn::Sub(f.x.x, one);
        f.y.y = hn::Sub(f.y.y, one);
        f.z.z = hn::Sub(f.z.z, one);
        return f;
    }
    HWY_INLINE static Value rate_of_gradient(const Columns<D> & /*f*/, const Columns<D> &f_rate) { return f_rate; }
    /// V P + mu F
    HWY_INLINE static Columns<D> first_stress(const Columns<D> &f, hn::Vec<D> rest_volume, const Value &sum,
                                              hn::Vec<D> inside, const T *faded) {
        const auto elastic = plus<D>(scaled<D>(rest_volume, sum), scaled<D>(inside, f));
        return faded ? minus<D>(elastic, product<D>(f, load_six(D(), faded))) : elastic;
    }
};

/// Strains of the tetrahedra of a fan for the means around edges, and the volumes that they gain.
template <bool is_damped, template <class> class Means, class T> class FanStrains {
    using D = Lanes<T>;
    using OfEdges = Means<D>;

  public:
    HWY_INLINE explicit FanStrains(D d) : gains_(d), growth_(d) {}

    HWY_INLINE void add(StepWorkspace<T> &at, const TetrahedronInFan &place, const Columns<D> &f,
                        hn::Vec<D> rest_volume, hn::Vec<D> gained) {
        put(at.tetrahedron_strain, place, scaled<D>(rest_volume, OfEdges::gradient_value(D(), f)));
        gains_.add(D(), gained, at.gain.data() + place.rim);
    }
    /// @param factor  beta times the volume at rest
    HWY_INLINE void add_rates(StepWorkspace<T> &at, const TetrahedronInFan &place, const Columns<D> &f,
                              const Columns<D> &f_rate, hn::Vec<D> factor, hn::Vec<D> gained) {
        put(at.tetrahedron_rate, place, scaled<D>(factor, OfEdges::rate_of_gradient(f, f_rate)));
        growth_.add(D(), gained, at.gain_rate.data() + place.rim);
    }
    HWY_INLINE void finish(StepWorkspace<T> &at, std::size_t corner, std::size_t rim) const {
        gains_.finish(D(), at.gain.data() + corner, at.gain.data() + rim);
        if constexpr (is_damped)
            growth_.finish(D(), at.gain_rate.data() + corner, at.gain_rate.data() + rim);
    }

  private:
    HWY_INLINE static void put(Aligned<T> &rows, const TetrahedronInFan &place, const typename OfEdges::Value &value) {
        const std::size_t lane = place.tetrahedron % slice_size;
        OfEdges::put(D(), value, rows.data() + OfEdges::row_size * (place.tetrahedron - lane), lane);
    }

    CornerSum<D> gains_, growth_;
};
template <bool is_damped, class T> using FanStrainsOfC = FanStrains<is_damped, EdgeMeansOfC, T>;
template <bool is_damped, class T> using FanStrainsOfF = FanStrains<is_damped, EdgeMeansOfF, T>;

/// Mean around the edges of a slice, those from `lane` on.
/// @param rows  of tetrahedra
template <template <class> class Means, class D, class T>
HWY_INLINE typename Means<D>::Value mean_around_edges(D d, const SlicedBody<T> &body, const Aligned<T> &rows, int slice,
                                                      std::size_t lane) {
    const std::size_t first = static_cast<std::size_t>(body.edge_start[slice]) * slice_size + lane;
    const std::size_t end = static_cast<std::size_t>(body.edge_start[slice + 1]) * slice_size;
    auto sum = Means<D>::fetch(d, rows.data(), body.edge_member.data() + first);
    for (std::size_t m = first + slice_size; m < end; m += slice_size)
        sum = plus<D>(sum, Means<D>::fetch(d, rows.data(), body.edge_member.data() + m));
    const auto edge = static_cast<std::size_t>(slice) * slice_size + lane;
    return scaled<D>(hn::Load(d, body.inverse_edge_volume.data() + edge), Means<D>::value_of(d, sum));
}

/// Sums of what edges do to the tetrahedra of a fan, one after the other. Two tetrahedra share the edges to the node
/// between them, and all of them the axis.
template <template <class> class Means, class T> class EdgeSums {
    using D = Lanes<T>;
    using OfEdges = Means<D>;

  public:
    HWY_INLINE EdgeSums(const StepWorkspace<T> &at, int slice, std::size_t lane)
        : rows_(at.edge_stress.data()),
          edge_(at.body.fan_edge.data() + 3 * static_cast<std::size_t>(at.body.fan_start[slice] + slice) * slice_size +
                lane),
          axis_(OfEdges::value_of(D(), OfEdges::fetch(D(), rows_, edge_))) {
        keep(D(), to_rim(), before_.data());
    }

    HWY_INLINE typename OfEdges::Value next() {
        edge_ += 3 * slice_size;
        const auto after = to_rim();
        const auto sum =
            plus<D>(plus<D>(OfEdges::Row::kept(D(), before_.data()), OfEdges::fetch(D(), rows_, edge_)), after);
        keep(D(), after, before_.data());
        return plus<D>(axis_, OfEdges::value_of(D(), sum));
    }

  private:
    HWY_INLINE typename OfEdges::Row to_rim() const {
        return plus<D>(OfEdges::fetch(D(), rows_, edge_ + slice_size),
                       OfEdges::fetch(D(), rows_, edge_ + 2 * slice_size));
    }

    const T *rows_;
    const std::int32_t *edge_;
    typename OfEdges::Value axis_;
    /// Sum of the edges to the node before. A variable would be copied in halves, which waits for the memory.
    alignas(64) std::array<T, OfEdges::row_size * slice_size> before_;
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_EDGES_INL_HPP
