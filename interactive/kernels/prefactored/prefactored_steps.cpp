// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/prefactored/prefactored_steps.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h

#include "core/support/vector_dispatch.hpp"
#include "interactive/kernels/fans-inl.hpp"
#include "interactive/kernels/inertia-inl.hpp"
#include "interactive/kernels/prefactored/factor_solve-inl.hpp"
#include "interactive/kernels/prefactored/prefactored_rows.hpp"
#include "interactive/kernels/prefactored/projections-inl.hpp"
#include "interactive/kernels/springs-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// V (2 mu (F - R) + 3 lambda (F - D))
struct ProjectiveStress {
    HWY_INLINE Matrix operator()(const Fans &fans, const Matrix &h) const {
        const auto cofactors = cofactors_of(h);
        const auto growth = growth_of(h, cofactors);
        const auto change = change_of_cofactors(h, cofactors);
        const auto square = dot(h, h);
        const auto of_shape = hn::Mul(number(2.0F), fans.number_of_tetrahedron(9)),
                   of_volume = hn::Mul(number(3.0F), fans.number_of_tetrahedron(10));
        return combined(of_shape, beyond_rotation(h, change, growth, square), of_volume,
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
    constexpr std::size_t width = 4 * nodes_at_once;
    for (std::size_t four = 0; four + 1 < body.slot_start.size(); ++four)
        for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
            const std::size_t at = four * width + lane;
            const auto force = summed_slots(body, body.force, four, lane, hn::Zero(d));
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
    for (std::size_t at = 0; at < body.force.size(); at += hn::Lanes(d))
        hn::Store(with_inertia(hn::Load(d, body.force.data() + at), rows, body, at), d, rows.right.data() + at);
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

PrefactoredRows::PrefactoredRows(PrefactoredElements of_body) : elements(std::move(of_body)) {
    for (auto *field : {&before, &predicted, &stiffness, &right})
        field->assign(4 * nodes().num_rows, 0.0F);
}

NodeRows &PrefactoredRows::nodes() {
    return std::visit([](auto &body) -> NodeRows & { return body; }, elements);
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

void PrefactoredRows::set_factor(const support::SupernodalFactor &of_matrix, const std::vector<int> &unknown,
                                 const std::vector<double> &of_nodes) {
    factor = factor_rows(of_matrix);
    place.assign(nodes().num_rows, static_cast<std::int32_t>(4 * factor.num_unknowns));
    for (std::size_t i = 0; i < unknown.size(); ++i) {
        const auto row = static_cast<std::size_t>(nodes().row_of_node[i]);
        if (unknown[i] >= 0)
            place[row] = factor.place[unknown[i]];
        std::fill_n(stiffness.begin() + static_cast<std::ptrdiff_t>(4 * row), 3, static_cast<float>(of_nodes[i]));
    }
}

LIVERMARK_DISPATCH(void take_prefactored_step, take_step,
                   (PrefactoredRows & rows, double time_step, double mass_damping, int iterations),
                   (rows, time_step, mass_damping, iterations))

} // namespace livermark::interactive::kernels
#endif
