// Energies, forces and products with second derivatives of coupled springs at equilibria. Written once for each vector
// unit: see take_steps.cpp.
#if defined(LIVERMARK_COUPLED_EQUILIBRIA_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_COUPLED_EQUILIBRIA_INL_HPP
#undef LIVERMARK_COUPLED_EQUILIBRIA_INL_HPP
#else
#define LIVERMARK_COUPLED_EQUILIBRIA_INL_HPP
#endif

#include <algorithm>
#include <limits>

#include "msm/kernels/energy_kernels.hpp"
#include "msm/kernels/simd/coupled_means-inl.hpp"
#include "msm/kernels/vector_springs.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

// The live page looks for no equilibria: see cmake/portable.cmake.
#if HWY_HAVE_FLOAT64 && !defined(LIVERMARK_WITHOUT_EQUILIBRIA)

using CoupledLanes = hn::CappedTag<double, coupled_slice>;

/// Adds rows at scattered places, one after the other, so that two of these may be one.
template <class D> HWY_INLINE void add_rows(D d, const Rows<D> &r, double *rows, const std::int32_t *index) {
#if HWY_TARGET == HWY_SCALAR
    const auto was = fetch(d, rows, index);
    hn::StoreInterleaved4(hn::Add(was.x, r.x), hn::Add(was.y, r.y), hn::Add(was.z, r.z), hn::Add(was.w, r.w), d,
                          rows + *index);
#else
    add_blocks(d, hn::InterleaveLower(d, r.x, r.y), rows, index, 2);
    add_blocks(d, hn::InterleaveUpper(d, r.x, r.y), rows, index + 1, 2);
    add_blocks(d, hn::InterleaveLower(d, r.z, r.w), rows + 2, index, 2);
    add_blocks(d, hn::InterleaveUpper(d, r.z, r.w), rows + 2, index + 1, 2);
#endif
}

/// The same in place of what is there.
template <class D> HWY_INLINE void put_rows(D d, const Rows<D> &r, double *rows, const std::int32_t *index) {
#if HWY_TARGET == HWY_SCALAR
    hn::StoreInterleaved4(r.x, r.y, r.z, r.w, d, rows + *index);
#else
    constexpr hn::Full128<double> block;
    const auto put = [&](const hn::Vec<D> &v, std::size_t first, std::size_t lane) HWY_ATTR {
        HWY_ALIGN double parts[coupled_slice];
        hn::Store(v, d, parts);
        for (std::size_t b = 0; b < hn::Lanes(d); b += 2)
            hn::StoreU(hn::Load(block, parts + b), block, rows + first + index[lane + b]);
    };
    put(hn::InterleaveLower(d, r.x, r.y), 0, 0);
    put(hn::InterleaveUpper(d, r.x, r.y), 0, 1);
    put(hn::InterleaveLower(d, r.z, r.w), 2, 0);
    put(hn::InterleaveUpper(d, r.z, r.w), 2, 1);
#endif
}

/// The rows of parts that are behind each other, one to a lane.
template <class MeanRows> class PartRows {
  public:
    HWY_INLINE explicit PartRows(std::size_t row_size) : row_size_(row_size) {
        for (std::size_t lane = 0; lane < coupled_slice; ++lane)
            index_[lane] = static_cast<std::int32_t>(row_size * lane);
    }
    template <class D> HWY_INLINE MeanRows load(D d, const Aligned<double> &part_data, std::size_t first) const {
        MeanRows rows;
        for (std::size_t r = 0; r < rows.size(); ++r)
            rows[r] = fetch(d, part_data.data() + row_size_ * first + 4 * r, index_);
        return rows;
    }
    template <class D>
    HWY_INLINE void store(D d, const MeanRows &rows, Aligned<double> &part_data, std::size_t first) const {
        for (std::size_t r = 0; r < rows.size(); ++r)
            put_rows(d, rows[r], part_data.data() + row_size_ * first + 4 * r, index_);
    }

  private:
    std::size_t row_size_;
    HWY_ALIGN std::int32_t index_[coupled_slice];
};

template <class D> HWY_INLINE Rows<D> scaled(hn::Vec<D> factor, const Rows<D> &r) {
    return {hn::Mul(factor, r.x), hn::Mul(factor, r.y), hn::Mul(factor, r.z), hn::Mul(factor, r.w)};
}
template <class D> HWY_INLINE Rows<D> plus(const Rows<D> &a, const Rows<D> &b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z), hn::Add(a.w, b.w)};
}

/// Adds to each part around a corner.
template <class D, class MeanRows>
HWY_INLINE void add_to_parts(D d, const MeanRows &rows, const TetrahedraPlace &place, Aligned<double> &sums) {
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t r = 0; r < rows.size(); ++r)
            add_rows(d, rows[r], sums.data() + 4 * r, place.part(a));
}

/// The sum over the parts around the corners.
template <class MeanRows, class D>
HWY_INLINE MeanRows sum_of_parts(D d, const Aligned<double> &part_data, const TetrahedraPlace &place) {
    MeanRows sums;
    for (std::size_t r = 0; r < sums.size(); ++r) {
        const double *rows = part_data.data() + 4 * r;
        sums[r] = plus<D>(plus<D>(fetch(d, rows, place.part(0)), fetch(d, rows, place.part(1))),
                          plus<D>(fetch(d, rows, place.part(2)), fetch(d, rows, place.part(3))));
    }
    return sums;
}

/// Takes from the forces what pulls corners inwards.
template <class D>
HWY_INLINE void take_pulls(D d, const OfCorners<D> &pull, const TetrahedraPlace &place, Aligned<double> &force) {
    const auto zero = hn::Zero(d);
    const auto add = [&](const Vec3<D> &v, std::size_t corner) HWY_ATTR {
        add_rows(d, {v.x, v.y, v.z, zero}, force.data(), place.corner(corner));
    };
    const Vec3<D> nothing{zero, zero, zero};
    add(plus(pull.a, plus(pull.b, pull.c)), 0);
    add(minus(nothing, pull.a), 1);
    add(minus(nothing, pull.b), 2);
    add(minus(nothing, pull.c), 3);
}

/// Part of its volume that a tetrahedron lacks where the guard pushes it back; zero above.
template <class D> HWY_INLINE hn::Vec<D> deficit(D d, const TetrahedraPlace &place, hn::Vec<D> change) {
    const auto least = hn::Load(d, place.body.least_relative_volume.data() + place.line(1, 0));
    return hn::Max(hn::Zero(d), hn::Sub(hn::Sub(least, hn::Set(d, 1.0)), change));
}

template <class D> HWY_INLINE double sum_of_lanes(D d, hn::Vec<D> v) {
    HWY_ALIGN double lanes[coupled_slice];
    hn::Store(v, d, lanes);
    double sum = 0.0;
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane)
        sum += lanes[lane];
    return sum;
}

/// Visits all tetrahedra in their order.
template <class Visit> HWY_INLINE void each_tetrahedra(const CoupledArrays &body, const Visit &visit) {
    constexpr CoupledLanes d;
    for (std::size_t slice = 0; slice < body.num_tetrahedra / coupled_slice; ++slice)
        for (std::size_t lane = 0; lane < coupled_slice; lane += hn::Lanes(d))
            visit(TetrahedraPlace{body, slice, lane});
}

/// Puts down sums of what is averaged, and of relative changes of volume.
/// @param least_volume  told the least J
/// @return energy of the springs inside tetrahedra and of the guard [J]
template <template <class> class Energy, template <class> class Means>
double add_up_means(const CoupledArrays &body, CoupledWorkspace &at, double &least_volume) {
    using D = CoupledLanes;
    using Of = Means<D>;
    constexpr D d;
    std::fill(at.mean.begin(), at.mean.end(), 0.0);
    auto energy = hn::Zero(d), least = hn::Set(d, 1.0);
    each_tetrahedra(body, [&](const TetrahedraPlace &place) HWY_ATTR {
        const Of of(d, at, place);
        const auto value = of.value(d);
        const auto change = change_of_volume<D>(of.h);
        const std::size_t t = place.line(1, 0);
        const auto volume = hn::Load(d, body.volume.data() + t);
        const auto modulus = hn::Load(d, body.inner_modulus.data() + t);
        energy = hn::MulAdd(volume, Energy<D>(d, modulus, Of::twice_strain(value)).energy(d), energy);
        if (!body.guard_modulus.empty()) {
            const auto lack = deficit(d, place, change);
            const auto stiffness = hn::Mul(hn::Load(d, body.guard_modulus.data() + t), volume);
            energy = hn::MulAdd(hn::Mul(hn::Set(d, 0.5), stiffness), hn::Mul(lack, lack), energy);
        }
        least = hn::Min(least, hn::Add(hn::Set(d, 1.0), change));
        add_to_parts(d, rows_of(d, scaled<D>(volume, value), hn::Mul(volume, change)), place, at.mean);
    });
    HWY_ALIGN double lanes[coupled_slice];
    hn::Store(least, d, lanes);
    least_volume = *std::min_element(lanes, lanes + hn::Lanes(d));
    return sum_of_lanes(d, energy);
}

/// Makes means of the sums, and puts down what parts push with.
/// @param least_volume  told det F of means of F
/// @return energy of springs and volumes around nodes [J]
template <template <class> class Energy, template <class> class Means>
double push_of_parts(const CoupledArrays &body, CoupledWorkspace &at, double &least_volume) {
    using D = CoupledLanes;
    using Of = Means<D>;
    constexpr D d;
    const PartRows<typename Of::MeanRows> part_rows(body.row_size);
    const auto half = hn::Set(d, 0.5), quarter = hn::Set(d, 0.25);
    auto energy = hn::Zero(d), least = hn::Set(d, 1.0);
    for (std::size_t c = 0; c < body.num_parts; c += hn::Lanes(d)) {
        auto rows = part_rows.load(d, at.mean, c);
        const auto weight = hn::Load(d, body.part_weight.data() + c);
        for (auto &row : rows)
            row = scaled<D>(weight, row);
        part_rows.store(d, rows, at.mean, c);
        const auto value = value_of<D>(rows);
        const Energy<D> law(d, hn::Load(d, body.part_modulus.data() + c), Of::twice_strain(value));
        const auto kappa = hn::Load(d, body.volume_modulus.data() + c);
        const auto volume_part = Energy<D>::volume(d, rows[0].w);
        const auto density = hn::MulAdd(hn::Mul(half, kappa), volume_part.square, law.energy(d));
        energy = hn::MulAdd(hn::Load(d, body.part_volume.data() + c), density, energy);
        least = hn::Min(least, Of::determinant(d, value));
        const auto stress = scaled<D>(quarter, Of::stress(d, value, law.stress(d)));
        part_rows.store(d, rows_of(d, stress, hn::Mul(quarter, hn::Mul(kappa, volume_part.slope))), at.push, c);
    }
    HWY_ALIGN double lanes[coupled_slice];
    hn::Store(least, d, lanes);
    least_volume = std::min(least_volume, *std::min_element(lanes, lanes + hn::Lanes(d)));
    return sum_of_lanes(d, energy);
}

template <template <class> class Energy, template <class> class Means>
double energy_of(const CoupledArrays &body, CoupledWorkspace &at) {
    double least_volume = 1.0;
    double energy = add_up_means<Energy, Means>(body, at, least_volume);
    energy += push_of_parts<Energy, Means>(body, at, least_volume);
    const bool is_possible = Energy<CoupledLanes>::is_finite || least_volume > 0.0;
    return is_possible ? energy : std::numeric_limits<double>::infinity();
}

/// The pressure of a tetrahedron, with that of the guard.
template <class D>
HWY_INLINE hn::Vec<D> pressure(D d, const TetrahedraPlace &place, hn::Vec<D> part_data, hn::Vec<D> change) {
    if (place.body.guard_modulus.empty())
        return part_data;
    const auto modulus = hn::Load(d, place.body.guard_modulus.data() + place.line(1, 0));
    return hn::NegMulAdd(modulus, deficit(d, place, change), part_data);
}

template <template <class> class Energy, template <class> class Means>
void force_of(const CoupledArrays &body, CoupledWorkspace &at) {
    using D = CoupledLanes;
    using Of = Means<D>;
    constexpr D d;
    std::fill(at.force.begin(), at.force.end(), 0.0);
    each_tetrahedra(body, [&](const TetrahedraPlace &place) HWY_ATTR {
        const Of of(d, at, place);
        const std::size_t t = place.line(1, 0);
        const auto volume = hn::Load(d, body.volume.data() + t);
        const Energy<D> inner(d, hn::Load(d, body.inner_modulus.data() + t), Of::twice_strain(of.value(d)));
        const auto pushed = sum_of_parts<typename Of::MeanRows>(d, at.push, place);
        const auto p = hn::Mul(volume, pressure(d, place, pushed[0].w, change_of_volume<D>(of.h)));
        take_pulls(d,
                   of.pull(d, scaled<D>(volume, value_of<D>(pushed)), scaled<D>(volume, inner.stress(d)),
                           scaled<D>(p, cofactor<D>(of.f))),
                   place, at.force);
    });
}

template <class D>
HWY_INLINE void store_turning(D d, const Symmetric<D> &s, hn::Vec<D> pressure, const TetrahedraPlace &place,
                              Aligned<double> &stress) {
    const auto store = [&](const hn::Vec<D> &v, std::size_t k)
                           HWY_ATTR { hn::Store(v, d, stress.data() + place.line(7, k)); };
    store(s.xx, 0);
    store(s.yy, 1);
    store(s.zz, 2);
    store(s.xy, 3);
    store(s.yz, 4);
    store(s.zx, 5);
    store(pressure, 6);
}

template <template <class> class Energy, template <class> class Means>
void keep_stresses(const CoupledArrays &body, CoupledWorkspace &at) {
    using D = CoupledLanes;
    using Of = Means<D>;
    constexpr D d;
    each_tetrahedra(body, [&](const TetrahedraPlace &place) HWY_ATTR {
        const Of of(d, at, place);
        const auto modulus = hn::Load(d, body.inner_modulus.data() + place.line(1, 0));
        const Energy<D> inner(d, modulus, Of::twice_strain(of.value(d)));
        const auto pushed = sum_of_parts<typename Of::MeanRows>(d, at.push, place);
        store_turning(d, Of::turning_stress(value_of<D>(pushed), inner.stress(d)),
                      pressure(d, place, pushed[0].w, change_of_volume<D>(of.h)), place, at.stress);
    });
}

/// Rates of means along the direction become rates of what parts push with.
template <template <class> class Energy, template <class> class Means>
void push_rates_of_parts(const CoupledArrays &body, CoupledWorkspace &at) {
    using D = CoupledLanes;
    using Of = Means<D>;
    constexpr D d;
    const PartRows<typename Of::MeanRows> part_rows(body.row_size);
    const auto quarter = hn::Set(d, 0.25);
    for (std::size_t c = 0; c < body.num_parts; c += hn::Lanes(d)) {
        const auto means = part_rows.load(d, at.mean, c);
        auto rates = part_rows.load(d, at.mean_rate, c);
        const auto weight = hn::Load(d, body.part_weight.data() + c);
        for (auto &row : rates)
            row = scaled<D>(weight, row);
        const auto mean = value_of<D>(means), rate = value_of<D>(rates);
        const Energy<D> law(d, hn::Load(d, body.part_modulus.data() + c), Of::twice_strain(mean));
        const auto second_rate = law.stress_rate(d, Of::twice_strain_rate_of(d, mean, rate));
        const auto stress = Of::stress_rate(d, mean, rate, law.stress(d), second_rate);
        const auto kappa = hn::Load(d, body.volume_modulus.data() + c);
        const auto volume_part = hn::Mul(hn::Mul(kappa, Energy<D>::volume(d, means[0].w).curvature), rates[0].w);
        part_rows.store(d, rows_of(d, scaled<D>(quarter, stress), hn::Mul(quarter, volume_part)), at.mean_rate, c);
    }
}

template <template <class> class Energy, template <class> class Means>
void product_of(const CoupledArrays &body, CoupledWorkspace &at) {
    using D = CoupledLanes;
    using Of = Means<D>;
    constexpr D d;
    std::fill(at.mean_rate.begin(), at.mean_rate.end(), 0.0);
    each_tetrahedra(body, [&](const TetrahedraPlace &place) HWY_ATTR {
        const Of of(d, at, place);
        const auto arms = fetch_arms(d, at.direction, place);
        const auto rate = gradient<D>(arms, of.gradient);
        const auto volume = hn::Load(d, body.volume.data() + place.line(1, 0));
        const auto change_rate = contraction<D>(cofactor<D>(of.f), rate);
        add_to_parts(d, rows_of(d, scaled<D>(volume, of.rate(d, arms, rate)), hn::Mul(volume, change_rate)), place,
                     at.mean_rate);
    });
    push_rates_of_parts<Energy, Means>(body, at);
    std::fill(at.force.begin(), at.force.end(), 0.0);
    each_tetrahedra(body, [&](const TetrahedraPlace &place) HWY_ATTR {
        const Of of(d, at, place);
        const auto arms = fetch_arms(d, at.direction, place);
        const auto rate = gradient<D>(arms, of.gradient);
        const std::size_t t = place.line(1, 0);
        const auto volume = hn::Load(d, body.volume.data() + t);
        const auto value_rate = of.rate(d, arms, rate);
        const Energy<D> inner(d, hn::Load(d, body.inner_modulus.data() + t), Of::twice_strain(of.value(d)));
        const auto pushed = sum_of_parts<typename Of::MeanRows>(d, at.mean_rate, place);
        const auto load = [&](std::size_t k) HWY_ATTR { return hn::Load(d, at.stress.data() + place.line(7, k)); };
        const Symmetric<D> turning{load(0), load(1), load(2), load(3), load(4), load(5)};
        const auto cofactors = cofactor<D>(of.f);
        auto pressure_rate = pushed[0].w;
        if (!body.guard_modulus.empty()) {
            const auto modulus = hn::Load(d, body.guard_modulus.data() + t);
            const auto pushes = hn::Gt(deficit(d, place, change_of_volume<D>(of.h)), hn::Zero(d));
            pressure_rate =
                hn::MulAdd(hn::IfThenElseZero(pushes, modulus), contraction<D>(cofactors, rate), pressure_rate);
        }
        const auto volume_part = plus<D>(scaled<D>(hn::Mul(volume, pressure_rate), cofactors),
                                         scaled<D>(hn::Mul(volume, load(6)), cofactor_rate<D>(of.f, rate)));
        const auto inner_rate = inner.stress_rate(d, Of::twice_strain_rate_of(d, of.value(d), value_rate));
        take_pulls(d,
                   of.pull_rate(d, arms, rate, scaled<D>(volume, value_of<D>(pushed)), scaled<D>(volume, inner_rate),
                                scaled<D>(volume, turning), volume_part),
                   place, at.force);
    });
}

/// (R + R^T) / 2 of the gradient of displacements.
template <class D> HWY_INLINE Symmetric<D> small_strain(D d, const Columns<D> &r) {
    const auto half = hn::Set(d, 0.5);
    return {r.x.x,
            r.y.y,
            r.z.z,
            hn::Mul(half, hn::Add(r.x.y, r.y.x)),
            hn::Mul(half, hn::Add(r.y.z, r.z.y)),
            hn::Mul(half, hn::Add(r.z.x, r.x.z))};
}

/// At rest all measures of strain are the same, and so are the energies.
inline void product_at_rest(const CoupledArrays &body, CoupledWorkspace &at) {
    using D = CoupledLanes;
    using MeanRows = std::array<Rows<D>, 2>;
    constexpr D d;
    const auto strain_of = [&](const TetrahedraPlace &place, const OfCorners<D> &rest) HWY_ATTR {
        return small_strain(d, gradient<D>(fetch_arms(d, at.direction, place), rest));
    };
    std::fill(at.mean_rate.begin(), at.mean_rate.end(), 0.0);
    each_tetrahedra(body, [&](const TetrahedraPlace &place) HWY_ATTR {
        const auto strain = strain_of(place, load_gradients(d, place));
        const auto volume = hn::Load(d, body.volume.data() + place.line(1, 0));
        const auto trace = hn::Add(strain.xx, hn::Add(strain.yy, strain.zz));
        add_to_parts(d, rows_of(d, scaled<D>(volume, strain), hn::Mul(volume, trace)), place, at.mean_rate);
    });
    const PartRows<MeanRows> part_rows(body.row_size);
    for (std::size_t c = 0; c < body.num_parts; c += hn::Lanes(d)) {
        const auto rows = part_rows.load(d, at.mean_rate, c);
        const auto quarter = hn::Mul(hn::Set(d, 0.25), hn::Load(d, body.part_weight.data() + c));
        const auto strain = scaled<D>(quarter, value_of<D>(rows));
        const auto kappa = hn::Load(d, body.volume_modulus.data() + c);
        part_rows.store(d,
                        rows_of(d, stress(d, hn::Load(d, body.part_modulus.data() + c), strain),
                                hn::Mul(hn::Mul(quarter, kappa), rows[0].w)),
                        at.mean_rate, c);
    }
    std::fill(at.force.begin(), at.force.end(), 0.0);
    each_tetrahedra(body, [&](const TetrahedraPlace &place) HWY_ATTR {
        const auto rest = load_gradients(d, place);
        const std::size_t t = place.line(1, 0);
        const auto pushed = sum_of_parts<MeanRows>(d, at.mean_rate, place);
        const auto inner = stress(d, hn::Load(d, body.inner_modulus.data() + t), strain_of(place, rest));
        const auto total = plus_identity<D>(plus<D>(value_of<D>(pushed), inner), pushed[0].w);
        const auto s = scaled<D>(hn::Load(d, body.volume.data() + t), total);
        take_pulls(d, OfCorners<D>{product<D>(s, rest.a), product<D>(s, rest.b), product<D>(s, rest.c)}, place,
                   at.force);
    });
}

template <template <class> class Energy, template <class> class Means> EquilibriumFunctions equilibrium_functions() {
    return {energy_of<Energy, Means>, force_of<Energy, Means>, keep_stresses<Energy, Means>, product_of<Energy, Means>,
            product_at_rest};
}

#else

template <template <class> class Energy, template <class> class Means> EquilibriumFunctions equilibrium_functions() {
    return {};
}

#endif

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_COUPLED_EQUILIBRIA_INL_HPP
