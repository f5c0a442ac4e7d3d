// Means of coupled springs in tetrahedra and around nodes. Written once for each vector unit: see
// take_steps.cpp.
#if defined(LIVERMARK_COUPLED_MEANS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_COUPLED_MEANS_INL_HPP
#undef LIVERMARK_COUPLED_MEANS_INL_HPP
#else
#define LIVERMARK_COUPLED_MEANS_INL_HPP
#endif

#include <array>

#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/vector_springs.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// Tetrahedra, one to a lane, and where their numbers stand in slices.
struct TetrahedraPlace {
    const CoupledArrays &body;
    std::size_t slice, lane;

    HWY_INLINE std::size_t line(std::size_t lines, std::size_t k) const {
        return coupled_slice * (lines * slice + k) + lane;
    }
    HWY_INLINE const std::int32_t *corner(std::size_t a) const { return body.corner.data() + line(4, a); }
    HWY_INLINE const std::int32_t *part(std::size_t a) const { return body.part.data() + line(4, a); }
};

template <class D> HWY_INLINE OfCorners<D> load_gradients(D d, const TetrahedraPlace &place) {
    const auto load = [&](std::size_t k)
                          HWY_ATTR { return hn::Load(d, place.body.gradient.data() + place.line(9, k)); };
    return {{load(0), load(1), load(2)}, {load(3), load(4), load(5)}, {load(6), load(7), load(8)}};
}

/// A nodal field at corners 1 to 3 less that at corner 0.
template <class D> HWY_INLINE OfCorners<D> fetch_arms(D d, const Aligned<double> &rows, const TetrahedraPlace &place) {
    const auto start = fetch(d, rows.data(), place.corner(0));
    return {difference(fetch(d, rows.data(), place.corner(1)), start),
            difference(fetch(d, rows.data(), place.corner(2)), start),
            difference(fetch(d, rows.data(), place.corner(3)), start)};
}

template <class D> HWY_INLINE OfCorners<D> plus(const OfCorners<D> &a, const OfCorners<D> &b) {
    return {plus(a.a, b.a), plus(a.b, b.b), plus(a.c, b.c)};
}
/// A : B
template <class D> HWY_INLINE hn::Vec<D> contraction(const Columns<D> &a, const Columns<D> &b) {
    return hn::Add(dot(a.x, b.x), hn::Add(dot(a.y, b.y), dot(a.z, b.z)));
}

/// I + H
template <class D> HWY_INLINE Columns<D> plus_identity(D d, Columns<D> h) {
    const auto one = hn::Set(d, 1.0);
    h.x.x = hn::Add(h.x.x, one);
    h.y.y = hn::Add(h.y.y, one);
    h.z.z = hn::Add(h.z.z, one);
    return h;
}
/// H + H^T + H^T H, twice Green's strain of F = I + H: small strains keep all their digits.
template <class D> HWY_INLINE Symmetric<D> twice_strain_of(const Columns<D> &h) {
    return {hn::Add(hn::Add(h.x.x, h.x.x), dot(h.x, h.x)), hn::Add(hn::Add(h.y.y, h.y.y), dot(h.y, h.y)),
            hn::Add(hn::Add(h.z.z, h.z.z), dot(h.z, h.z)), hn::Add(hn::Add(h.x.y, h.y.x), dot(h.x, h.y)),
            hn::Add(hn::Add(h.y.z, h.z.y), dot(h.y, h.z)), hn::Add(hn::Add(h.z.x, h.x.z), dot(h.z, h.x))};
}
/// det (I + H) - 1
template <class D> HWY_INLINE hn::Vec<D> change_of_volume(const Columns<D> &h) {
    const auto yz = cross(h.y, h.z);
    const auto minors = hn::Add(yz.x, hn::Add(hn::MulSub(h.x.x, h.y.y, hn::Mul(h.x.y, h.y.x)),
                                              hn::MulSub(h.x.x, h.z.z, hn::Mul(h.x.z, h.z.x))));
    return hn::Add(hn::Add(h.x.x, hn::Add(h.y.y, h.z.z)), hn::Add(minors, dot(h.x, yz)));
}
template <class D> HWY_INLINE Columns<D> cofactor(const Columns<D> &f) {
    return {cross(f.y, f.z), cross(f.z, f.x), cross(f.x, f.y)};
}
/// Its derivative where F grows by R.
template <class D> HWY_INLINE Columns<D> cofactor_rate(const Columns<D> &f, const Columns<D> &rate) {
    return {plus(cross(f.y, rate.z), cross(rate.y, f.z)), plus(cross(f.z, rate.x), cross(rate.z, f.x)),
            plus(cross(f.x, rate.y), cross(rate.x, f.y))};
}

/// Rows of a part, one to a lane: what is averaged, and a number beside it.
template <class D> HWY_INLINE std::array<Rows<D>, 2> rows_of(D d, const Symmetric<D> &s, hn::Vec<D> beside) {
    return {Rows<D>{s.xx, s.yy, s.zz, beside}, Rows<D>{s.xy, s.yz, s.zx, hn::Zero(d)}};
}
template <class D> HWY_INLINE std::array<Rows<D>, 3> rows_of(D d, const Columns<D> &c, hn::Vec<D> beside) {
    const auto zero = hn::Zero(d);
    return {Rows<D>{c.x.x, c.x.y, c.x.z, beside}, Rows<D>{c.y.x, c.y.y, c.y.z, zero},
            Rows<D>{c.z.x, c.z.y, c.z.z, zero}};
}
template <class D> HWY_INLINE Symmetric<D> value_of(const std::array<Rows<D>, 2> &rows) {
    return {rows[0].x, rows[0].y, rows[0].z, rows[1].x, rows[1].y, rows[1].z};
}
template <class D> HWY_INLINE Columns<D> value_of(const std::array<Rows<D>, 3> &rows) {
    return {{rows[0].x, rows[0].y, rows[0].z}, {rows[1].x, rows[1].y, rows[1].z}, {rows[2].x, rows[2].y, rows[2].z}};
}

/// Means of C: values are 2 E, and stresses by them are those of Piola and Kirchhoff, the second.
template <class D> struct MeansOfStrains {
    using Value = Symmetric<D>;
    using MeanRows = std::array<Rows<D>, 2>;

    OfCorners<D> gradient; ///< at rest
    Columns<D> h, f;

    HWY_INLINE MeansOfStrains(D d, const CoupledWorkspace &at, const TetrahedraPlace &place)
        : gradient(load_gradients(d, place)),
          h(livermark::msm::HWY_NAMESPACE::gradient<D>(fetch_arms(d, at.displacement, place), gradient)),
          f(plus_identity(d, h)) {}

    HWY_INLINE Value value(D /*d*/) const { return twice_strain_of<D>(h); }
    HWY_INLINE Value rate(D /*d*/, const OfCorners<D> & /*arms*/, const Columns<D> &f_rate) const {
        return twice_strain_rate<D>(f, f_rate);
    }
    /// The stress that turns with a tetrahedron.
    HWY_INLINE static Symmetric<D> turning_stress(const Value &pushed, const Symmetric<D> &inner) {
        return plus<D>(pushed, inner);
    }
    /// Pulls on the corners inwards, for each m^3.
    HWY_INLINE OfCorners<D> pull(D /*d*/, const Value &pushed, const Symmetric<D> &inner,
                                 const Columns<D> &volume_stress) const {
        return pulls<D>(plus<D>(product<D>(f, plus<D>(pushed, inner)), volume_stress), gradient);
    }
    /// Its rate.
    /// @param turning  the stress that was there
    HWY_INLINE OfCorners<D> pull_rate(D /*d*/, const OfCorners<D> & /*arms*/, const Columns<D> &rate,
                                      const Value &pushed, const Symmetric<D> &inner, const Symmetric<D> &turning,
                                      const Columns<D> &volume_stress) const {
        const auto p = plus<D>(product<D>(f, plus<D>(pushed, inner)), product<D>(rate, turning));
        return pulls<D>(plus<D>(p, volume_stress), gradient);
    }

    HWY_INLINE static Symmetric<D> twice_strain(const Value &mean) { return mean; }
    HWY_INLINE static Symmetric<D> twice_strain_rate_of(D /*d*/, const Value & /*mean*/, const Value &rate) {
        return rate;
    }
    /// The stress by the mean.
    HWY_INLINE static Value stress(D /*d*/, const Value & /*mean*/, const Symmetric<D> &second) { return second; }
    HWY_INLINE static Value stress_rate(D /*d*/, const Value & /*mean*/, const Value & /*rate*/,
                                        const Symmetric<D> & /*second*/, const Symmetric<D> &second_rate) {
        return second_rate;
    }
    /// det F, where a mean without it has no energy.
    HWY_INLINE static hn::Vec<D> determinant(D d, const Value & /*mean*/) { return hn::Set(d, 1.0); }
};

/// Means of F: values are F - I, and stresses by them are the first of Piola and Kirchhoff.
template <class D> struct MeansOfGradients : MeansOfStrains<D> {
    using Value = Columns<D>;
    using MeanRows = std::array<Rows<D>, 3>;

    HWY_INLINE MeansOfGradients(D d, const CoupledWorkspace &at, const TetrahedraPlace &place)
        : MeansOfStrains<D>(d, at, place) {}

    HWY_INLINE Value value(D /*d*/) const { return this->h; }
    HWY_INLINE Value rate(D /*d*/, const OfCorners<D> & /*arms*/, const Columns<D> &f_rate) const { return f_rate; }
    HWY_INLINE static Symmetric<D> turning_stress(const Value & /*pushed*/, const Symmetric<D> &inner) { return inner; }
    HWY_INLINE OfCorners<D> pull(D /*d*/, const Value &pushed, const Symmetric<D> &inner,
                                 const Columns<D> &volume_stress) const {
        const auto p = plus<D>(pushed, product<D>(this->f, inner));
        return pulls<D>(plus<D>(p, volume_stress), this->gradient);
    }
    HWY_INLINE OfCorners<D> pull_rate(D /*d*/, const OfCorners<D> & /*arms*/, const Columns<D> &rate,
                                      const Value &pushed, const Symmetric<D> &inner, const Symmetric<D> &turning,
                                      const Columns<D> &volume_stress) const {
        const auto p = plus<D>(product<D>(this->f, inner), product<D>(rate, turning));
        return pulls<D>(plus<D>(plus<D>(pushed, p), volume_stress), this->gradient);
    }

    HWY_INLINE static Symmetric<D> twice_strain(const Value &mean) { return twice_strain_of<D>(mean); }
    HWY_INLINE static Symmetric<D> twice_strain_rate_of(D d, const Value &mean, const Value &rate) {
        return twice_strain_rate<D>(plus_identity(d, mean), rate);
    }
    HWY_INLINE static Value stress(D d, const Value &mean, const Symmetric<D> &second) {
        return product<D>(plus_identity(d, mean), second);
    }
    HWY_INLINE static Value stress_rate(D d, const Value &mean, const Value &rate, const Symmetric<D> &second,
                                        const Symmetric<D> &second_rate) {
        return plus<D>(product<D>(plus_identity(d, mean), second_rate), product<D>(rate, second));
    }
    HWY_INLINE static hn::Vec<D> determinant(D d, const Value &mean) {
        return hn::Add(hn::Set(d, 1.0), change_of_volume<D>(mean));
    }
};

/// Vectors along the six edges of a tetrahedron, in the order of core::tetrahedron_edges.
template <class D> struct OfEdges { Vec3<D> ab, ac, ad, bc, bd, cd; };

template <class D> HWY_INLINE OfEdges<D> edges_of(const OfCorners<D> &arms) {
    return {arms.a, arms.b, arms.c, minus(arms.b, arms.a), minus(arms.c, arms.a), minus(arms.c, arms.b)};
}

/// Means of elongations: values are 2 E = 2 D q with q = 2 l0 (l - l0) of the edges, see tetrahedron.hpp.
template <class D> struct MeansOfElongations : MeansOfStrains<D> {
    using Value = Symmetric<D>;

    OfCorners<D> rest, arms; ///< nodes less the first one: at rest, and their displacements

    HWY_INLINE MeansOfElongations(D d, const CoupledWorkspace &at, const TetrahedraPlace &place)
        : MeansOfStrains<D>(d, at, place), rest(fetch_arms(d, place.body.rest, place)),
          arms(fetch_arms(d, at.displacement, place)) {}

    HWY_INLINE Value value(D d) const {
        const auto moved = edges_of(arms), at_rest = edges_of(rest);
        // l^2 - l0^2 = (2 L + u) . u, and l - l0 is that over l + l0
        const auto stretch = [&](const Vec3<D> &u, const Vec3<D> &span) HWY_ATTR {
            const auto rest_square = dot(span, span), square_change = dot(plus(plus(span, span), u), u);
            const auto rest_length = hn::Sqrt(rest_square);
            const auto length = hn::Sqrt(hn::Add(rest_square, square_change));
            const auto twice = hn::Mul(hn::Set(d, 2.0), rest_length);
            return hn::Div(hn::Mul(twice, square_change), hn::Add(length, rest_length));
        };
        return from_stretches(d, stretch(moved.ab, at_rest.ab), stretch(moved.ac, at_rest.ac),
                              stretch(moved.ad, at_rest.ad), stretch(moved.bc, at_rest.bc),
                              stretch(moved.bd, at_rest.bd), stretch(moved.cd, at_rest.cd));
    }
    HWY_INLINE Value rate(D d, const OfCorners<D> &arm_rates, const Columns<D> & /*f_rate*/) const {
        const auto now = edges_of(plus(rest, arms)), at_rest = edges_of(rest), u = edges_of(arm_rates);
        const auto stretch = [&](const Vec3<D> &span, const Vec3<D> &rest_span, const Vec3<D> &rate) HWY_ATTR {
            return hn::Mul(hn::Mul(hn::Set(d, 2.0), relative_rest_length(span, rest_span)), dot(span, rate));
        };
        return from_stretches(d, stretch(now.ab, at_rest.ab, u.ab), stretch(now.ac, at_rest.ac, u.ac),
                              stretch(now.ad, at_rest.ad, u.ad), stretch(now.bc, at_rest.bc, u.bc),
                              stretch(now.bd, at_rest.bd, u.bd), stretch(now.cd, at_rest.cd, u.cd));
    }
    /// With the tensions T = -g_i . S g_j of edges ij, which pull with l0 / l of the edge.
    HWY_INLINE OfCorners<D> pull(D d, const Value &pushed, const Symmetric<D> &inner,
                                 const Columns<D> &volume_stress) const {
        const auto now = edges_of(plus(rest, arms)), at_rest = edges_of(rest);
        const auto tension = tensions(d, plus<D>(pushed, inner));
        const auto edge = [&](const hn::Vec<D> &of, const Vec3<D> &span, const Vec3<D> &rest_span)
                              HWY_ATTR { return scaled<D>(hn::Mul(of, relative_rest_length(span, rest_span)), span); };
        const auto volume_pulls = pulls<D>(volume_stress, this->gradient);
        return plus(volume_pulls,
                    on_corners({edge(tension[0], now.ab, at_rest.ab), edge(tension[1], now.ac, at_rest.ac),
                                edge(tension[2], now.ad, at_rest.ad), edge(tension[3], now.bc, at_rest.bc),
                                edge(tension[4], now.bd, at_rest.bd), edge(tension[5], now.cd, at_rest.cd)}));
    }
    HWY_INLINE OfCorners<D> pull_rate(D d, const OfCorners<D> &arm_rates, const Columns<D> & /*rate*/,
                                      const Value &pushed, const Symmetric<D> &inner, const Symmetric<D> &turning,
                                      const Columns<D> &volume_stress) const {
        const auto now = edges_of(plus(rest, arms)), at_rest = edges_of(rest), u = edges_of(arm_rates);
        const auto more = tensions(d, plus<D>(pushed, inner)), there = tensions(d, turning);
        // d (l0 / l x) = l0 / l (u - x (x . u) / l^2)
        const auto edge = [&](const hn::Vec<D> &of, const hn::Vec<D> &was, const Vec3<D> &span,
                              const Vec3<D> &rest_span, const Vec3<D> &rate) HWY_ATTR {
            const auto along = hn::Div(dot(span, rate), dot(span, span));
            const auto factor = relative_rest_length(span, rest_span);
            return scaled<D>(factor, plus_scaled<D>(scaled<D>(was, rate), hn::NegMulAdd(was, along, of), span));
        };
        const auto volume_pulls = pulls<D>(volume_stress, this->gradient);
        return plus(volume_pulls, on_corners({edge(more[0], there[0], now.ab, at_rest.ab, u.ab),
                                              edge(more[1], there[1], now.ac, at_rest.ac, u.ac),
                                              edge(more[2], there[2], now.ad, at_rest.ad, u.ad),
                                              edge(more[3], there[3], now.bc, at_rest.bc, u.bc),
                                              edge(more[4], there[4], now.bd, at_rest.bd, u.bd),
                                              edge(more[5], there[5], now.cd, at_rest.cd, u.cd)}));
    }

  private:
    /// l0 / l
    HWY_INLINE static hn::Vec<D> relative_rest_length(const Vec3<D> &span, const Vec3<D> &rest_span) {
        return hn::Sqrt(hn::Div(dot(rest_span, rest_span), dot(span, span)));
    }
    HWY_INLINE Vec3<D> first_gradient(D d) const {
        const auto &[a, b, c] = this->gradient;
        const auto zero = hn::Zero(d);
        return minus(Vec3<D>{zero, zero, zero}, plus(a, plus(b, c)));
    }

    /// 2 E = -1/2 sum of q_ij (g_i g_j^T + g_j g_i^T)
    HWY_INLINE Symmetric<D> from_stretches(D d, hn::Vec<D> ab, hn::Vec<D> ac, hn::Vec<D> ad, hn::Vec<D> bc,
                                           hn::Vec<D> bd, hn::Vec<D> cd) const {
        const Vec3<D> &b = this->gradient.a, &c = this->gradient.b, &e = this->gradient.c;
        const auto first = first_gradient(d);
        // The sum over the ends j > i of each i comes first.
        const auto zero = hn::Zero(d);
        const Vec3<D> along_first = combined<D>(ab, b, ac, c, ad, e), along_b = combined<D>(bc, c, bd, e, zero, e),
                      along_c = scaled<D>(cd, e);
        const auto half = hn::Set(d, -0.5);
        const auto diagonal = [&](auto component) HWY_ATTR {
            return hn::Neg(
                hn::MulAdd(component(first), component(along_first),
                           hn::MulAdd(component(b), component(along_b), hn::Mul(component(c), component(along_c)))));
        };
        const auto beside = [&](auto one, auto other) HWY_ATTR {
            const auto half_of = [&](auto i, auto j) HWY_ATTR {
                return hn::MulAdd(i(first), j(along_first), hn::MulAdd(i(b), j(along_b), hn::Mul(i(c), j(along_c))));
            };
            return hn::Mul(half, hn::Add(half_of(one, other), half_of(other, one)));
        };
        const auto x = [](const Vec3<D> &v) HWY_ATTR { return v.x; };
        const auto y = [](const Vec3<D> &v) HWY_ATTR { return v.y; };
        const auto z = [](const Vec3<D> &v) HWY_ATTR { return v.z; };
        return {diagonal(x), diagonal(y), diagonal(z), beside(x, y), beside(y, z), beside(z, x)};
    }

    HWY_INLINE std::array<hn::Vec<D>, 6> tensions(D d, const Symmetric<D> &stress) const {
        const auto &[b, c, e] = this->gradient;
        const auto first = first_gradient(d);
        const auto along_b = product<D>(stress, b), along_c = product<D>(stress, c), along_e = product<D>(stress, e);
        return {hn::Neg(dot(first, along_b)), hn::Neg(dot(first, along_c)), hn::Neg(dot(first, along_e)),
                hn::Neg(dot(b, along_c)),     hn::Neg(dot(b, along_e)),     hn::Neg(dot(c, along_e))};
    }
    /// Pulls of edges on the ends behind them, added up for corners 1 to 3.
    HWY_INLINE static OfCorners<D> on_corners(const OfEdges<D> &pull) {
        return {minus(pull.ab, plus(pull.bc, pull.bd)), minus(plus(pull.ac, pull.bc), pull.cd),
                plus(pull.ad, plus(pull.bd, pull.cd))};
    }
};

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_COUPLED_MEANS_INL_HPP
