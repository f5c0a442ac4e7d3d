// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/explicit_steps.cpp"
#include <hwy/foreach_target.h> // has to come before highway.h

#include "interactive/kernels/explicit_steps.hpp"
#include "interactive/kernels/neo_hookean-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Fans of a slice, one to a lane, on the way along their tetrahedra. Displacements of the rim are from the start of
/// the axis on.
class Fans {
  public:
    HWY_INLINE Fans(const ExplicitRows &rows, std::size_t slice, std::size_t lane)
        : rows_(rows.displacement.data()), corner_(rows.corner.data() + rows.first_corner(slice) + lane),
          start_(fetch(rows_, corner_)), end_(fetch(rows_, corner_ + slice_size)),
          numbers_(rows.tetrahedra.data() + rows.line_start[slice] * numbers_of_tetrahedron * slice_size + lane),
          last_(numbers_ +
                (rows.line_start[slice + 1] - rows.line_start[slice]) * numbers_of_tetrahedron * slice_size) {
        corner_ += 2 * slice_size;
        from_ = from_start(fetch(rows_, corner_));
        corner_ += slice_size;
        to_ = from_start(fetch(rows_, corner_));
    }

    HWY_INLINE bool is_at_end() const { return numbers_ == last_; }
    HWY_INLINE void go_on() {
        numbers_ += numbers_of_tetrahedron * slice_size;
        from_ = to_;
        if (is_at_end())
            return;
        corner_ += slice_size;
        to_ = from_start(fetch(rows_, corner_));
    }

    HWY_INLINE V number_of_tetrahedron(std::size_t k) const { return hn::Load(d, numbers_ + k * slice_size); }
    HWY_INLINE ShapeGradients gradients() const { return ShapeGradients(numbers_); }
    HWY_INLINE Vec3 axis() const { return end_.v - start_.v; }
    HWY_INLINE V pressures_of_axis() const { return hn::Add(start_.w, end_.w); }
    HWY_INLINE const Row &from() const { return from_; }
    HWY_INLINE const Row &to() const { return to_; }

  private:
    HWY_INLINE Row from_start(const Row &node) const { return {node.v - start_.v, node.w}; }

    const float *rows_;
    const std::int32_t *corner_;
    Row start_, end_;
    const float *numbers_, *last_;
    Row from_, to_;
};

/// V (J - 1) / 4 of tetrahedra, summed at the corners of fans.
HWY_NOINLINE void find_growth(ExplicitRows &rows) {
    for (std::size_t slice = 0; slice < rows.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            float *growth = rows.growth.data() + rows.first_corner(slice) + lane;
            float *rim = growth + 2 * slice_size;
            auto sum = hn::Zero(d), before = hn::Zero(d);
            Fans fans(rows, slice, lane);
            const auto axis = fans.axis();
            for (; !fans.is_at_end(); fans.go_on(), rim += slice_size) {
                const auto h = displacement_gradient(fans.gradients(), axis, fans.from().v, fans.to().v);
                const auto here = hn::Mul(fans.number_of_tetrahedron(10), growth_of(h, cofactors_of(h)));
                hn::Store(hn::Add(before, here), d, rim);
                sum = hn::Add(sum, here);
                before = here;
            }
            hn::Store(before, d, rim);
            hn::Store(sum, d, growth);
            hn::Store(sum, d, growth + slice_size);
        }
}

/// p = lambda ln J / J of nodes, into the last place of their rows.
HWY_NOINLINE void find_pressures(ExplicitRows &rows) {
    const hn::RebindToSigned<D> whole;
    HWY_ALIGN float pressures[hn::MaxLanes(D())];
    for (std::size_t slice = 0; slice + 1 < rows.growth_start.size(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            auto sum = hn::Zero(d);
            for (std::size_t k = rows.growth_start[slice]; k < rows.growth_start[slice + 1]; ++k)
                sum = hn::Add(sum, hn::GatherIndex(d, rows.growth.data(),
                                                   hn::Load(whole, rows.growth_at.data() + k * slice_size + lane)));
            const std::size_t row = slice * slice_size + lane;
            const auto growth = hn::Mul(sum, hn::Load(d, rows.inverse_volume.data() + row));
            const auto jacobian = hn::Add(growth, number(1.0F));
            const auto pressure =
                hn::Div(hn::Mul(hn::Load(d, rows.lambda.data() + row), log_of(jacobian, growth)), jacobian);
            hn::Store(pressure, d, pressures);
            for (std::size_t i = 0; i < hn::Lanes(d); ++i)
                rows.displacement[4 * (row + i) + 3] = pressures[i];
        }
}

/// Forces of tetrahedra, summed at the corners of fans.
template <Pressure pressure_of> HWY_NOINLINE void find_forces(ExplicitRows &rows) {
    const Vec3 zero{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    float *const forces = rows.force.data();
    for (std::size_t slice = 0; slice < rows.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const std::int32_t *slot = rows.slot.data() + rows.first_corner(slice) + lane;
            const std::int32_t *rim = slot + 2 * slice_size;
            auto at_start = zero, at_end = zero, before = zero;
            Fans fans(rows, slice, lane);
            const auto axis = fans.axis();
            [[maybe_unused]] const auto axis_pressure = fans.pressures_of_axis();
            for (; !fans.is_at_end(); fans.go_on(), rim += slice_size) {
                const auto g = fans.gradients();
                const auto h = displacement_gradient(g, axis, fans.from().v, fans.to().v);
                const auto cofactors = cofactors_of(h);
                const auto growth = growth_of(h, cofactors);
                const auto jacobian = hn::Add(growth, number(1.0F));
                const auto inverse = hn::Div(number(1.0F), jacobian);
                const auto shear = fans.number_of_tetrahedron(9), last = fans.number_of_tetrahedron(10);
                V pressure;
                if constexpr (pressure_of == Pressure::of_tetrahedra)
                    pressure = hn::Mul(hn::Mul(last, inverse), log_of(jacobian, growth));
                else
                    pressure = hn::Mul(last, hn::Add(axis_pressure, hn::Add(fans.from().w, fans.to().w)));
                const auto p = stress_of(h, cofactors, growth, inverse, shear, pressure);
                const auto at_from = pull_of(p, g.r), at_to = pull_of(p, g.s), of_end = pull_of(p, g.b);
                store(before - at_from, forces, rim);
                before = zero - at_to;
                at_end = at_end - of_end;
                at_start = at_start + (at_from + at_to + of_end);
            }
            store(before, forces, rim);
            store(at_end, forces, slot + slice_size);
            store(at_start, forces, slot);
        }
}

struct StepFactors {
    float keep, gain, step; ///< of velocities, of accelerations, h
};

/// Sums forces, and moves nodes.
HWY_NOINLINE void move_nodes(ExplicitRows &rows, const StepFactors &factors) {
    constexpr std::size_t width = 4 * nodes_at_once;
    const auto keep = number(factors.keep), gain = number(factors.gain), step = number(factors.step);
    for (std::size_t four = 0; four + 1 < rows.slot_start.size(); ++four)
        for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
            const std::size_t at = four * width + lane;
            auto force = hn::Load(d, rows.external.data() + at);
            for (std::size_t k = rows.slot_start[four]; k < rows.slot_start[four + 1]; ++k)
                force = hn::Add(force, hn::Load(d, rows.force.data() + k * width + lane));
            const auto inverse_mass = hn::Load(d, rows.inverse_mass.data() + at);
            const auto was = hn::Load(d, rows.velocity.data() + at);
            const auto moved = hn::MulAdd(hn::Mul(inverse_mass, gain), force, hn::Mul(keep, was));
            const auto velocity = hn::IfThenElse(hn::Gt(inverse_mass, hn::Zero(d)), moved, was);
            hn::Store(velocity, d, rows.velocity.data() + at);
            hn::Store(hn::MulAdd(step, velocity, hn::Load(d, rows.displacement.data() + at)), d,
                      rows.displacement.data() + at);
        }
}

void take(ExplicitRows &rows, double step, double mass_damping, int num_steps) {
    const double half = 0.5 * mass_damping * step;
    const StepFactors factors{static_cast<float>((1.0 - half) / (1.0 + half)), static_cast<float>(step / (1.0 + half)),
                              static_cast<float>(step)};
    for (int s = 0; s < num_steps; ++s) {
        if (rows.pressure == Pressure::around_nodes) {
            find_growth(rows);
            find_pressures(rows);
            find_forces<Pressure::around_nodes>(rows);
        } else {
            find_forces<Pressure::of_tetrahedra>(rows);
        }
        move_nodes(rows, factors);
    }
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::interactive::kernels {

namespace {
HWY_EXPORT(take);
} // namespace

void take_explicit_steps(ExplicitRows &rows, double step, double mass_damping, int num_steps) {
    HWY_DYNAMIC_DISPATCH(take)(rows, step, mass_damping, num_steps);
}

} // namespace livermark::interactive::kernels
#endif
