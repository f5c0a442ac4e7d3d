// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/explicit_steps.cpp"
#include <hwy/foreach_target.h> // has to come before highway.h

#include "core/support/vector_dispatch.hpp"
#include "interactive/kernels/explicit_rows.hpp"
#include "interactive/kernels/fans-inl.hpp"
#include "interactive/kernels/quadratic_fans-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// V (J - 1) / 4 of tetrahedra, summed at the corners of fans.
HWY_NOINLINE void find_growth(ExplicitRows &rows) {
    for (std::size_t slice = 0; slice < rows.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            float *growth = rows.growth.data() + rows.first_corner(slice) + lane;
            float *rim = growth + 2 * slice_size;
            auto sum = hn::Zero(d), before = hn::Zero(d);
            Fans fans(rows, rows.displacement, rows.tetrahedra, slice, lane);
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

/// V P of neo-Hookean tetrahedra.
template <Pressure pressure_of> struct NeoHookeanStress {
    HWY_INLINE Matrix operator()(const Fans &fans, const Matrix &h) const {
        const auto cofactors = cofactors_of(h);
        const auto growth = growth_of(h, cofactors);
        const auto jacobian = hn::Add(growth, number(1.0F));
        const auto inverse = hn::Div(number(1.0F), jacobian);
        const auto shear = fans.number_of_tetrahedron(9), last = fans.number_of_tetrahedron(10);
        V pressure;
        if constexpr (pressure_of == Pressure::of_tetrahedra)
            pressure = hn::Mul(hn::Mul(last, inverse), log_of(jacobian, growth));
        else
            pressure = hn::Mul(last, fans.pressures());
        return stress_of(h, cofactors, growth, inverse, shear, pressure);
    }
};

template <Pressure pressure_of> HWY_NOINLINE void find_forces(ExplicitRows &rows) {
    find_forces_of_fans(rows, NeoHookeanStress<pressure_of>());
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
            const auto force = summed_slots(rows, rows.force, four, lane, hn::Load(d, rows.external.data() + at));
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
        if (rows.is_quadratic) {
            find_forces_of_quadratic_fans(rows);
        } else if (rows.pressure == Pressure::around_nodes) {
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

LIVERMARK_DISPATCH(void take_explicit_steps, take,
                   (ExplicitRows & rows, double step, double mass_damping, int num_steps),
                   (rows, step, mass_damping, num_steps))

} // namespace livermark::interactive::kernels
#endif
