// Means around edges of the deformation gradient, and of the Cauchy-Green tensor. Written once for each vector unit:
// see take_steps.cpp.
#if defined(LIVERMARK_STARS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_STARS_INL_HPP
#undef LIVERMARK_STARS_INL_HPP
#else
#define LIVERMARK_STARS_INL_HPP
#endif

#include <array>

#include "msm/kernels/simd/fan_forces-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Places of the numbers of the stars of a slice: see SlicedBody.
struct StarPlaces {
    std::size_t corner, tetrahedron; ///< of the start of the axis, and of what is between the first two of the rim
    std::size_t length;              ///< of the rim

    template <class T>
    StarPlaces(const SlicedBody<T> &body, int slice, std::size_t lane)
        : corner(static_cast<std::size_t>(body.star_start[slice] + 2 * slice) * slice_size + lane),
          tetrahedron(static_cast<std::size_t>(body.star_start[slice]) * slice_size + lane),
          length(static_cast<std::size_t>(body.star_start[slice + 1] - body.star_start[slice])) {}
};

/// A node less the start of the axis: where it is, and where it is at rest.
template <class D> struct StarArm { Vec3<D> position, rest; };

/// Fetches the nodes of a star. With the arms x_k and X_k at rest, the axis D there and the levers L_k = D x X_k, six
/// times the volume of a tetrahedron times its gradient is
///   6 V F = x_axis (X_k x X_k+1)^T + x_k+1 L_k^T - x_k L_k+1^T.
/// So no gradient has to be read: rest is fetched as positions are.
template <bool is_damped, class T> class StarFetch {
    using D = Lanes<T>;

  public:
    HWY_INLINE StarFetch(const StepWorkspace<T> &at, int now, const StarPlaces &places)
        : position_(at.rows[now].data()), velocity_(is_damped ? at.velocity_rows[now].data() : nullptr),
          rest_(at.body.rest_rows.data()), corner_(at.body.star_corner.data() + places.corner),
          position_start_(fetch(D(), position_, corner_)), rest_start_(fetch(D(), rest_, corner_)),
          axis_(arm(corner_ + slice_size)) {}

    HWY_INLINE const StarArm<D> &axis() const { return axis_; }

    /// Arm of a node of the rim.
    HWY_INLINE StarArm<D> operator[](std::size_t k) const { return arm(corner_ + (2 + k) * slice_size); }

    /// Velocities less that of the start of the axis. They are fetched again: those who need it have no time to
    /// lose.
    HWY_INLINE Vec3<D> axis_velocity() const { return velocity(corner_ + slice_size); }
    HWY_INLINE Vec3<D> velocity(std::size_t k) const { return velocity(corner_ + (2 + k) * slice_size); }

  private:
    HWY_INLINE StarArm<D> arm(const std::int32_t *corner) const {
        return {difference(fetch(D(), position_, corner), position_start_),
                difference(fetch(D(), rest_, corner), rest_start_)};
    }
    HWY_INLINE Vec3<D> velocity(const std::int32_t *corner) const {
        return difference(fetch(D(), velocity_, corner), fetch(D(), velocity_, corner_));
    }

    const T *position_, *velocity_, *rest_;
    const std::int32_t *corner_;
    Rows<D> position_start_, rest_start_;
    StarArm<D> axis_;
};

template <class D, class T> HWY_INLINE void store(D d, const Vec3<D> &v, T *at) {
    hn::Store(v.x, d, at);
    hn::Store(v.y, d, at + slice_size);
    hn::Store(v.z, d, at + 2 * slice_size);
}
template <class D, class T> HWY_INLINE Vec3<D> load(D d, const T *at) {
    return {hn::Load(d, at), hn::Load(d, at + slice_size), hn::Load(d, at + 2 * slice_size)};
}

template <class D> HWY_INLINE Vec3<D> no_vector(D d) {
    const auto zero = hn::Zero(d);
    return {zero, zero, zero};
}
/// sum + a x b
template <class D> HWY_INLINE Vec3<D> plus_cross(const Vec3<D> &sum, const Vec3<D> &a, const Vec3<D> &b) {
    return {hn::NegMulAdd(a.z, b.y, hn::MulAdd(a.y, b.z, sum.x)), hn::NegMulAdd(a.x, b.z, hn::MulAdd(a.z, b.x, sum.y)),
            hn::NegMulAdd(a.y, b.x, hn::MulAdd(a.x, b.y, sum.z))};
}

/// matrix += v g^T
template <class D> HWY_INLINE void add_product(Columns<D> &matrix, const Vec3<D> &v, const Vec3<D> &g) {
    matrix = {plus_scaled<D>(matrix.x, g.x, v), plus_scaled<D>(matrix.y, g.y, v), plus_scaled<D>(matrix.z, g.z, v)};
}
/// M g
template <class D> HWY_INLINE Vec3<D> product(const Columns<D> &matrix, const Vec3<D> &g) {
    return combined<D>(g.x, matrix.x, g.y, matrix.y, g.z, matrix.z);
}

/// Memory for the nodes of a rim: vectors of three lines each, one behind the other. Vectors that are handed from
/// one node to the next in variables would be copied in halves, which waits for the memory.
template <class T, std::size_t num_vectors> class StarCorners {
    using D = Lanes<T>;

  public:
    HWY_INLINE explicit StarCorners(T *kept) : kept_(kept) {}
    HWY_INLINE Vec3<D> get(std::size_t k, std::size_t vector) const { return load(D(), at(k, vector)); }
    HWY_INLINE void set(std::size_t k, std::size_t vector, const Vec3<D> &value) const {
        store(D(), value, at(k, vector));
    }

  private:
    HWY_INLINE T *at(std::size_t k, std::size_t vector) const {
        return kept_ + (num_vectors * k + vector) * 3 * slice_size;
    }
    T *kept_;
};

/// C - I of the mean of F, and the forces of its stress. 36 V_e F = sum over the rim of x_k N_k^T with
/// N_k = L_k-1 - L_k+1 = D x (X_k-1 - X_k+1), and x_axis n^T with n = sum of X_k x X_k+1.
template <bool is_damped, class T> class StarsOfF {
    using D = Lanes<T>;
    using Fetch = StarFetch<is_damped, T>;

  public:
    /// @param kept  room for numbers_of_star_corner lines of each node of the rim, and of two more
    HWY_INLINE StarsOfF(const StepWorkspace<T> &at, const Fetch &fetch, const StarPlaces &places,
                        hn::Vec<D> inverse_volume, T *kept)
        : corners_(kept), length_(places.length),
          at_end_(no_vector(D())), f_{no_vector(D()), no_vector(D()), no_vector(D())}, rate_(f_) {
        // The rim has the numbers 1 to its length; its last node is also before the first one, and this behind it.
        for (std::size_t k = 0; k < length_; ++k) {
            const auto arm = fetch[k];
            corners_.set(k + 1, position, arm.position);
            corners_.set(k + 1, rest, arm.rest);
        }
        corners_.set(0, rest, corners_.get(length_, rest));
        corners_.set(length_ + 1, rest, corners_.get(1, rest));
        for (std::size_t k = 1; k <= length_; ++k) {
            const auto after = corners_.get(k + 1, rest);
            const auto normal = cross(fetch.axis().rest, minus(corners_.get(k - 1, rest), after));
            add_product<D>(f_, corners_.get(k, position), normal);
            if constexpr (is_damped)
                add_product<D>(rate_, fetch.velocity(k - 1), normal);
            at_end_ = plus_cross<D>(at_end_, corners_.get(k, rest), after);
            corners_.set(k, position, normal);
        }
        add_product<D>(f_, fetch.axis().position, at_end_);
        f_ = scaled<D>(inverse_volume, f_);
        if constexpr (is_damped) {
            add_product<D>(rate_, fetch.axis_velocity(), at_end_);
            rate_ = scaled<D>(hn::Mul(inverse_volume, hn::Set(D(), static_cast<T>(at.beta))), rate_);
        }
    }

    HWY_INLINE Symmetric<D> mean() const { return twice_strain(D(), f_); }
    /// Times beta.
    HWY_INLINE Symmetric<D> rate() const { return twice_strain_rate<D>(f_, rate_); }

    /// @param stress     1/36 of the second stress of Piola and Kirchhoff
    /// @param put_force  takes the number of a node of the rim and the force on it
    /// @return force on the end of the axis
    template <class PutForce> HWY_INLINE Vec3<D> forces(const Symmetric<D> &stress, const PutForce &put_force) const {
        const auto zero = no_vector(D());
        const auto p = product<D>(f_, stress);
        const Columns<D> push{minus(zero, p.x), minus(zero, p.y), minus(zero, p.z)};
        for (std::size_t k = 0; k < length_; ++k)
            put_force(k, product<D>(push, corners_.get(k + 1, normal_of_node)));
        return product<D>(push, at_end_);
    }

  private:
    static constexpr std::size_t position = 0, rest = 1, normal_of_node = 0;

    StarCorners<T, 2> corners_;
    std::size_t length_;
    Vec3<D> at_end_;
    Columns<D> f_, rate_;
};

/// C - I of the mean of C, and the forces of its stress in each tetrahedron, F S. 36 V_e C = sum of A^T A / (6 V) with
/// A = 6 V F.
template <bool is_damped, class T> class StarsOfC {
    using D = Lanes<T>;
    using Fetch = StarFetch<is_damped, T>;

  public:
    /// As of StarsOfF.
    HWY_INLINE StarsOfC(const StepWorkspace<T> &at, const Fetch &fetch, const StarPlaces &places,
                        hn::Vec<D> inverse_volume, T *kept)
        : corners_(kept), inverse_(at.body.star_tetrahedron.data() + places.tetrahedron), length_(places.length) {
        const auto zero = hn::Zero(D()), one = hn::Set(D(), T(1));
        mean_ = rate_ = {zero, zero, zero, zero, zero, zero};
        // The rim has the numbers 0 to its length, of which the last one is the first again.
        for (std::size_t k = 0; k < length_; ++k) {
            const auto arm = fetch[k];
            corners_.set(k, position, arm.position);
            corners_.set(k, rest, arm.rest);
            corners_.set(k, lever, cross(fetch.axis().rest, arm.rest));
        }
        for (const auto vector : {position, rest, lever})
            corners_.set(length_, vector, corners_.get(0, vector));
        for (std::size_t k = 0; k < length_; ++k)
            put(k, fetch);
        mean_ = scaled<D>(inverse_volume, mean_);
        mean_.xx = hn::Sub(mean_.xx, one);
        mean_.yy = hn::Sub(mean_.yy, one);
        mean_.zz = hn::Sub(mean_.zz, one);
        if constexpr (is_damped)
            rate_ = scaled<D>(hn::Mul(inverse_volume, hn::Set(D(), static_cast<T>(at.beta))), rate_);
    }

    HWY_INLINE Symmetric<D> mean() const { return mean_; }
    HWY_INLINE Symmetric<D> rate() const { return rate_; }

    template <class PutForce> HWY_INLINE Vec3<D> forces(const Symmetric<D> &stress, const PutForce &put_force) const {
        auto on_end = no_vector(D()), before = on_end;
        for (std::size_t k = 0; k < length_; ++k) {
            const Columns<D> a{corners_.get(k, column), corners_.get(k, column + 1), corners_.get(k, column + 2)};
            const auto push = product<D>(a, scaled<D>(hn::Load(D(), inverse_ + k * slice_size), stress));
            on_end = minus(on_end, product<D>(push, corners_.get(k, normal)));
            const auto on_from = product<D>(push, corners_.get(k + 1, lever));
            corners_.set(k, column, minus(on_from, before));
            before = product<D>(push, corners_.get(k, lever));
        }
        corners_.set(0, column, minus(corners_.get(0, column), before));
        // Behind the loop: stores at scattered places would make it wait for what it has kept.
        for (std::size_t k = 0; k < length_; ++k)
            put_force(k, corners_.get(k, column));
        return on_end;
    }

  private:
    static constexpr std::size_t position = 0, rest = 1, lever = 2, column = 3, normal = 6;

    HWY_INLINE static Columns<D> matrix_of_tetrahedron(const Vec3<D> &axis, const Vec3<D> &from, const Vec3<D> &to,
                                                       const Vec3<D> &axis_normal, const Vec3<D> &from_lever,
                                                       const Vec3<D> &to_lever) {
        const auto column = [&](const hn::Vec<D> &n, const hn::Vec<D> &l, const hn::Vec<D> &m) HWY_ATTR {
            const auto value = [&](const hn::Vec<D> &x, const hn::Vec<D> &t, const hn::Vec<D> &f)
                                   HWY_ATTR { return hn::NegMulAdd(m, f, hn::MulAdd(l, t, hn::Mul(n, x))); };
            return Vec3<D>{value(axis.x, to.x, from.x), value(axis.y, to.y, from.y), value(axis.z, to.z, from.z)};
        };
        return {column(axis_normal.x, from_lever.x, to_lever.x), column(axis_normal.y, from_lever.y, to_lever.y),
                column(axis_normal.z, from_lever.z, to_lever.z)};
    }

    HWY_INLINE void put(std::size_t k, const Fetch &fetch) {
        const auto axis_normal = cross(corners_.get(k, rest), corners_.get(k + 1, rest));
        const auto from_lever = corners_.get(k, lever), to_lever = corners_.get(k + 1, lever);
        const auto inverse = hn::Load(D(), inverse_ + k * slice_size);
        const auto a = matrix_of_tetrahedron(fetch.axis().position, corners_.get(k, position),
                                             corners_.get(k + 1, position), axis_normal, from_lever, to_lever);
        mean_ = plus_scaled<D>(
            mean_, inverse, {dot(a.x, a.x), dot(a.y, a.y), dot(a.z, a.z), dot(a.x, a.y), dot(a.y, a.z), dot(a.z, a.x)});
        if constexpr (is_damped)
            rate_ =
                plus_scaled<D>(rate_, inverse,
                               twice_strain_rate<D>(a, matrix_of_tetrahedron(fetch.axis_velocity(), fetch.velocity(k),
                                                                             fetch.velocity((k + 1) % length_),
                                                                             axis_normal, from_lever, to_lever)));
        corners_.set(k, column, a.x);
        corners_.set(k, column + 1, a.y);
        corners_.set(k, column + 2, a.z);
        corners_.set(k, normal, axis_normal);
    }

    StarCorners<T, 7> corners_;
    const T *inverse_; ///< 1 over six times the volume of each tetrahedron
    std::size_t length_;
    Symmetric<D> mean_, rate_;
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_STARS_INL_HPP
