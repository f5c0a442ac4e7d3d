// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/take_steps.cpp"
#include <hwy/foreach_target.h> // has to come before highway.h
#include <stdexcept>

#include "msm/kernels/fan_forces-inl.hpp"
#include "msm/kernels/schemes-inl.hpp"
#include "msm/kernels/spring_forces-inl.hpp"
#include "msm/kernels/team.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

template <class Scheme, bool is_damped, class T>
void run(StepWorkspace<T> &at, int thread, int num_steps, Barrier &barrier) {
    const auto [first_slice, last_slice] = at.slices[thread];
    const auto [first_fan, last_fan] = at.fan_slices[thread];
    const auto [first_chunk, last_chunk] = at.chunks[thread];
    const auto [first_volume, last_volume] = at.volume_slices[thread];
    const bool has_volumes = !at.body.volume_stiffness.empty(), has_tetrahedra = !at.body.rest_volume.empty();
    const int num_stages = at.scheme.num_stages();
    int now = at.now;
    for (int step = 0; step < num_steps; ++step)
        for (int stage = 0; stage < num_stages; ++stage) {
            if (has_volumes) {
                for (int slice = first_fan; slice < last_fan; ++slice)
                    volume_gains<is_damped>(at, now, slice);
                barrier.wait();
                for (int slice = first_volume; slice < last_volume; ++slice)
                    pressures(at, now, slice);
                barrier.wait();
            }
            if (has_tetrahedra) {
                for (int chunk = first_chunk; chunk < last_chunk; ++chunk)
                    chunk_forces<is_damped>(at, now, chunk);
                barrier.wait();
            }
            for (int slice = first_slice; slice < last_slice; ++slice) {
                SliceForce<T> force;
                spring_forces<is_damped>(at, now, slice, force);
                if (has_tetrahedra)
                    add_corner_forces(at, slice, force);
                advance<Scheme, is_damped>(at, now, slice, stage, force);
            }
            now = 1 - now;
            if (step + 1 < num_steps || stage + 1 < num_stages)
                barrier.wait(); // the team waits for the last step
        }
}

template <class T> void take(StepWorkspace<T> &at, int thread, int num_steps, Barrier &barrier) {
    const auto with = [&]<class Scheme>(Scheme /*scheme*/) {
        if (at.beta != 0.0)
            run<Scheme, true>(at, thread, num_steps, barrier);
        else
            run<Scheme, false>(at, thread, num_steps, barrier);
    };
    switch (at.scheme.kind) {
    case StepScheme::Kind::symplectic_euler:
        return with(SymplecticEuler());
    case StepScheme::Kind::velocity_verlet:
        return with(VelocityVerlet());
    case StepScheme::Kind::runge_kutta:
        return with(RungeKutta());
    }
}

void take_with_float(StepWorkspace<float> &at, int thread, int num_steps, Barrier &barrier) {
    take(at, thread, num_steps, barrier);
}
#if HWY_HAVE_FLOAT64
void take_with_double(StepWorkspace<double> &at, int thread, int num_steps, Barrier &barrier) {
    take(at, thread, num_steps, barrier);
}
#else
void take_with_double(StepWorkspace<double> & /*at*/, int /*thread*/, int /*num_steps*/, Barrier & /*barrier*/) {
    throw std::logic_error("forces in double precision need vectors of float64, which are not there; ask for single");
}
#endif

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::msm {

namespace {
HWY_EXPORT(take_with_float);
HWY_EXPORT(take_with_double);
} // namespace

template <> void take_steps(StepWorkspace<float> &workspace, int thread, int num_steps, Barrier &barrier) {
    HWY_DYNAMIC_DISPATCH(take_with_float)(workspace, thread, num_steps, barrier);
}
template <> void take_steps(StepWorkspace<double> &workspace, int thread, int num_steps, Barrier &barrier) {
    HWY_DYNAMIC_DISPATCH(take_with_double)(workspace, thread, num_steps, barrier);
}

} // namespace livermark::msm
#endif
