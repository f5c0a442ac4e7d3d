// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/position_steps.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h
#include <numeric>

#include "core/support/vector_dispatch.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/kernels/tetrahedra-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Four nodes of a tetrahedron, and where they are.
struct Corners {
    const std::int32_t *index;
    Row a, b, r, s;

    HWY_INLINE Corners(const float *rows, const std::int32_t *at)
        : index(at), a(fetch(rows, at)), b(fetch(rows, at + slice_size)), r(fetch(rows, at + 2 * slice_size)),
          s(fetch(rows, at + 3 * slice_size)) {}

    HWY_INLINE Matrix gradient(const ShapeGradients &g) const {
        return displacement_gradient(g, b.v - a.v, r.v - a.v, s.v - a.v);
    }
};

/// The gradient of a constraint at the four nodes of a tetrahedron.
struct Slopes {
    Vec3 a, b, r, s;

    /// @param p  the derivative by F
    HWY_INLINE Slopes(const Matrix &p, const ShapeGradients &g)
        : b(pull_of(p, g.b)), r(pull_of(p, g.r)), s(pull_of(p, g.s)) {
        a = minus(b + r + s);
    }
};

/// Sum over the nodes of w p . q.
HWY_INLINE V weighted(const Corners &at, const Slopes &p, const Slopes &q) {
    return hn::MulAdd(
        at.a.w, dot(p.a, q.a),
        hn::MulAdd(at.b.w, dot(p.b, q.b), hn::MulAdd(at.r.w, dot(p.r, q.r), hn::Mul(at.s.w, dot(p.s, q.s)))));
}

/// Both ends of springs.
HWY_INLINE void move_ends(float *rows, const std::int32_t *corner, const float *numbers, float *multiplier,
                          V per_step) {
    const auto a = fetch(rows, corner), b = fetch(rows, corner + slice_size);
    const StretchedSpring spring(load3(numbers), a.v - b.v, hn::Load(d, numbers + 3 * slice_size));
    const auto &[now, length, change] = spring;
    const auto compliance = hn::Mul(per_step, hn::Load(d, numbers + 4 * slice_size));
    const auto was = hn::Load(d, multiplier);
    const auto stiffness = hn::Add(hn::Add(a.w, b.w), compliance);
    const auto residual = hn::Neg(hn::MulAdd(compliance, was, change));
    const auto by_length = hn::Div(residual, hn::Mul(stiffness, length));
    hn::Store(hn::MulAdd(by_length, length, was), d, multiplier);
    store(Row{plus_scaled(a.v, hn::Mul(by_length, a.w), now), a.w}, rows, corner);
    store(Row{plus_scaled(b.v, hn::Neg(hn::Mul(by_length, b.w)), now), b.w}, rows, corner + slice_size);
}

/// Four nodes between which the points of springs are.
HWY_INLINE void move_fibres(float *rows, const std::int32_t *corner, const float *numbers, float *multiplier,
                            V per_step) {
    constexpr std::size_t n = 4;
    const Row nodes[n] = {fetch(rows, corner), fetch(rows, corner + slice_size), fetch(rows, corner + 2 * slice_size),
                          fetch(rows, corner + 3 * slice_size)};
    const auto weight = [&](std::size_t a) HWY_ATTR { return hn::Load(d, numbers + a * slice_size); };
    auto moved = scaled(weight(1), nodes[1].v - nodes[0].v);
    for (std::size_t a = 2; a < n; ++a)
        moved = plus_scaled(moved, weight(a), nodes[a].v - nodes[0].v);
    const StretchedSpring spring(load3(numbers + n * slice_size), moved, hn::Load(d, numbers + (n + 3) * slice_size));
    const auto compliance = hn::Mul(per_step, hn::Load(d, numbers + (n + 4) * slice_size));
    const auto was = hn::Load(d, multiplier);
    auto stiffness = compliance;
    for (std::size_t a = 0; a < n; ++a)
        stiffness = hn::MulAdd(hn::Mul(weight(a), weight(a)), nodes[a].w, stiffness);
    const auto residual = hn::Neg(hn::MulAdd(compliance, was, spring.change));
    const auto by_length = hn::Div(residual, hn::Mul(stiffness, spring.length));
    hn::Store(hn::MulAdd(by_length, spring.length, was), d, multiplier);
    for (std::size_t a = 0; a < n; ++a) {
        const auto part = hn::Mul(by_length, hn::Mul(weight(a), nodes[a].w));
        store(Row{plus_scaled(nodes[a].v, part, spring.now), nodes[a].w}, rows, corner + a * slice_size);
    }
}

HWY_INLINE void move_volumes(float *rows, const std::int32_t *corner, const float *numbers, float *multiplier,
                             V per_step) {
    const Corners at(rows, corner);
    const ShapeGradients g(numbers);
    const auto h = at.gradient(g);
    const auto cofactors = cofactors_of(h);
    const Slopes slopes(plus_ones(change_of_cofactors(h, cofactors), number(1.0F)), g);
    const auto compliance = hn::Mul(per_step, hn::Load(d, numbers + 9 * slice_size));
    const auto was = hn::Load(d, multiplier);
    const auto residual = hn::Neg(hn::MulAdd(compliance, was, growth_of(h, cofactors)));
    const auto more = hn::Div(residual, hn::Add(weighted(at, slopes, slopes), compliance));
    hn::Store(hn::Add(was, more), d, multiplier);
    const auto move = [&](const Row &node, const Vec3 &slope, std::size_t k) HWY_ATTR {
        store(Row{plus_scaled(node.v, hn::Mul(node.w, more), slope), node.w}, rows, corner + k * slice_size);
    };
    move(at.a, slopes.a, 0);
    move(at.b, slopes.b, 1);
    move(at.r, slopes.r, 2);
    move(at.s, slopes.s, 3);
}

/// The slopes of |F| and of J are parallel at rest, and the matrix of both is all but singular in long steps. So this
/// solves for dlambda_0 and dnu = dlambda_1 + dlambda_0 / sqrt 3, whose slopes are F / |F| - cof F / sqrt 3 and cof F:
/// the first one by H, where nothing cancels but a rotation.
HWY_INLINE void move_pairs(float *rows, const std::int32_t *corner, const float *numbers, float *multiplier,
                           V per_step) {
    const Corners at(rows, corner);
    const ShapeGradients g(numbers);
    const auto h = at.gradient(g);
    const auto cofactors = cofactors_of(h);
    const auto root3 = number(1.7320508075688772F), kappa = number(0.5773502691896258F);
    const auto trace = hn::Add(h.x.x, hn::Add(h.y.y, h.z.z));
    const auto excess = hn::MulAdd(number(2.0F), trace, hn::Add(dot(h.x, h.x), hn::Add(dot(h.y, h.y), dot(h.z, h.z))));
    const auto size = hn::Sqrt(hn::Add(number(3.0F), excess)); // |F|
    const auto inverse_size = hn::Div(number(1.0F), size);
    // 1 / |F| - 1 / sqrt 3
    const auto lack_of_inverse = hn::Neg(hn::Div(hn::Mul(excess, hn::Mul(kappa, inverse_size)), hn::Add(size, root3)));
    const auto change = change_of_cofactors(h, cofactors);
    const Slopes shape(plus_ones(combined(inverse_size, h, hn::Neg(kappa), change), lack_of_inverse), g);
    const Slopes volume(plus_ones(change, number(1.0F)), g);
    const auto compliance = [&](std::size_t k)
                                HWY_ATTR { return hn::Mul(per_step, hn::Load(d, numbers + k * slice_size)); };
    const auto c0 = compliance(10), c1 = compliance(11);
    const auto was0 = hn::Load(d, multiplier), was1 = hn::Load(d, multiplier + slice_size);
    const auto lack1 =
        hn::Neg(hn::MulAdd(c1, was1, hn::Sub(growth_of(h, cofactors), hn::Load(d, numbers + 9 * slice_size))));
    const auto lack0 = hn::Neg(hn::MulAdd(kappa, lack1, hn::MulAdd(c0, was0, size)));
    const auto kappa_c1 = hn::Mul(kappa, c1);
    const auto m00 = hn::Add(weighted(at, shape, shape), hn::MulAdd(kappa, kappa_c1, c0));
    const auto m01 = hn::Sub(weighted(at, shape, volume), kappa_c1);
    const auto m11 = hn::Add(weighted(at, volume, volume), c1);
    const auto inverse = hn::Div(number(1.0F), hn::MulSub(m00, m11, hn::Mul(m01, m01)));
    const auto more0 = hn::Mul(inverse, hn::MulSub(m11, lack0, hn::Mul(m01, lack1)));
    const auto more_nu = hn::Mul(inverse, hn::MulSub(m00, lack1, hn::Mul(m01, lack0)));
    hn::Store(hn::Add(was0, more0), d, multiplier);
    hn::Store(hn::Add(was1, hn::NegMulAdd(kappa, more0, more_nu)), d, multiplier + slice_size);
    const auto move = [&](const Row &node, const Vec3 &p, const Vec3 &q, std::size_t k) HWY_ATTR {
        const auto moved = plus_scaled(node.v, hn::Mul(node.w, more0), p);
        store(Row{plus_scaled(moved, hn::Mul(node.w, more_nu), q), node.w}, rows, corner + k * slice_size);
    };
    move(at.a, shape.a, volume.a, 0);
    move(at.b, shape.b, volume.b, 1);
    move(at.r, shape.r, volume.r, 2);
    move(at.s, shape.s, volume.s, 3);
}

template <Constraint kind> HWY_NOINLINE void project(ConstraintRows &set, float *rows, float per_step) {
    for (std::size_t batch = 0; batch < set.num_batches(); ++batch)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const auto *corner = set.corner.data() + batch * num_nodes_of(kind) * slice_size + lane;
            const auto *numbers = set.numbers.data() + batch * num_numbers_of(kind) * slice_size + lane;
            auto *multiplier = set.multipliers.data() + batch * num_multipliers_of(kind) * slice_size + lane;
            if constexpr (kind == Constraint::distance)
                move_ends(rows, corner, numbers, multiplier, number(per_step));
            else if constexpr (kind == Constraint::fibre)
                move_fibres(rows, corner, numbers, multiplier, number(per_step));
            else if constexpr (kind == Constraint::volume)
                move_volumes(rows, corner, numbers, multiplier, number(per_step));
            else
                move_pairs(rows, corner, numbers, multiplier, number(per_step));
        }
}

void take_step(PositionRows &rows, double time_step, double mass_damping, int iterations) {
    const auto damping = static_cast<float>(1.0 + mass_damping * time_step);
    if (damping != rows.damping) {
        for (std::size_t at = 0; at < rows.displacement.size(); at += 4)
            rows.displacement[at + 3] = rows.inverse_mass[at] / damping;
        rows.damping = damping;
    }
    predict(rows, rows.before, static_cast<float>(time_step), damping);
    for (auto &set : rows.sets)
        std::fill(set.multipliers.begin(), set.multipliers.end(), 0.0F);
    const auto per_step = static_cast<float>(1.0 / (time_step * time_step));
    float *const nodes = rows.displacement.data();
    for (int i = 0; i < iterations; ++i) {
        for (auto &set : rows.sets)
            switch (set.kind) {
            case Constraint::distance:
                project<Constraint::distance>(set, nodes, per_step);
                break;
            case Constraint::fibre:
                project<Constraint::fibre>(set, nodes, per_step);
                break;
            case Constraint::volume:
                project<Constraint::volume>(set, nodes, per_step);
                break;
            case Constraint::pair:
                project<Constraint::pair>(set, nodes, per_step);
                break;
            }
        if (rows.after_iteration)
            rows.after_iteration();
    }
    find_velocities(rows, rows.before, static_cast<float>(1.0 / time_step));
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::interactive::kernels {

namespace {

/// Numbers that fill up: finite wherever the nodes are.
std::vector<double> numbers_of_nothing(Constraint kind) {
    std::vector<double> numbers(num_numbers_of(kind), 0.0);
    if (kind == Constraint::distance)
        numbers[0] = numbers[3] = 1.0; // of some length
    if (kind == Constraint::fibre)
        numbers[4] = numbers[7] = 1.0;
    for (std::size_t k = 0; k < num_multipliers_of(kind); ++k)
        numbers[numbers.size() - 1 - k] = 1.0; // compliances
    return numbers;
}

} // namespace

PositionRows::PositionRows(const Scene &scene) {
    const std::size_t num_nodes = scene.node_mass.size();
    // Whole slices of four, with one row that no node has.
    num_rows = (num_nodes + nodes_at_once) / nodes_at_once * nodes_at_once;
    row_of_node.resize(num_nodes);
    std::iota(row_of_node.begin(), row_of_node.end(), 0);
    for (auto *field : {&displacement, &before, &velocity, &external, &inverse_mass})
        field->assign(4 * num_rows, 0.0F);
    const auto is_free = free_nodes(scene);
    for (std::size_t i = 0; i < num_nodes; ++i)
        if (is_free[i])
            std::fill_n(inverse_mass.begin() + 4 * static_cast<std::ptrdiff_t>(i), 3,
                        static_cast<float>(1.0 / scene.node_mass[i]));
}

std::size_t PositionRows::bytes() const {
    std::size_t bytes = bytes_of(displacement, before, velocity, external, inverse_mass);
    for (const auto &set : sets)
        bytes += bytes_of(set.corner, set.numbers, set.multipliers);
    return bytes;
}

ConstraintRows constraint_rows(Constraint kind, const std::vector<int> &offsets, const std::vector<int> &nodes,
                               const std::vector<double> &numbers, int num_nodes) {
    ConstraintRows rows;
    rows.kind = kind;
    std::size_t num_batches = 0;
    for (std::size_t colour = 0; colour + 1 < offsets.size(); ++colour) {
        const auto begin = static_cast<std::size_t>(offsets[colour]),
                   end = static_cast<std::size_t>(offsets[colour + 1]);
        for (std::size_t k = begin; k < end; ++k)
            rows.place.push_back(slice_size * num_batches + (k - begin));
        num_batches += filled_up(end - begin) / slice_size;
    }
    const std::size_t n = num_nodes_of(kind), m = num_numbers_of(kind);
    rows.corner.assign(n * slice_size * num_batches, 4 * num_nodes);
    rows.numbers.resize(m * slice_size * num_batches);
    rows.multipliers.assign(num_multipliers_of(kind) * slice_size * num_batches, 0.0F);
    const auto nothing = numbers_of_nothing(kind);
    for (std::size_t at = 0; at < rows.numbers.size(); ++at)
        rows.numbers[at] = static_cast<float>(nothing[at / slice_size % m]);
    for (std::size_t k = 0; k < rows.place.size(); ++k) {
        const std::size_t batch = rows.place[k] / slice_size, lane = rows.place[k] % slice_size;
        for (std::size_t a = 0; a < n; ++a)
            rows.corner[(batch * n + a) * slice_size + lane] = 4 * nodes[k * n + a];
        for (std::size_t a = 0; a < m; ++a)
            rows.numbers[(batch * m + a) * slice_size + lane] = static_cast<float>(numbers[k * m + a]);
    }
    return rows;
}

LIVERMARK_DISPATCH(void take_position_step, take_step,
                   (PositionRows & rows, double time_step, double mass_damping, int iterations),
                   (rows, time_step, mass_damping, iterations))

} // namespace livermark::interactive::kernels
#endif
