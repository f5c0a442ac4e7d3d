#pragma once

#include "msm/elastic_body.hpp"

namespace livermark::msm {

class Barrier;
struct CoupledArrays;
struct CoupledWorkspace;
template <class T> struct SlicedBody;
template <class T> struct StepWorkspace;

/// Parts of a step that belong to the energy of coupled springs (simd/coupled_steps-inl.hpp). All empty for a body
/// without such springs.
template <class T> struct StepFunctions {
    /// Strains of a slice of fans for the means around nodes or edges
    void (*put_means)(StepWorkspace<T> &at, int now, int slice) = nullptr;
    /// Stresses of means, and pressures, behind put_means(); all threads call it, and it waits for them
    void (*stresses)(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) = nullptr;
    /// Forces on the nodes of a slice of fans
    void (*fan_forces)(StepWorkspace<T> &at, int now, int slice) = nullptr;
    /// Turn of the branches of coupled springs, see relax_stresses(); all threads call it
    void (*relax)(StepWorkspace<T> &at, int now, int thread, Barrier &barrier) = nullptr;
};

/// Springs that are coupled around nodes at equilibria (equilibria/vector_springs.hpp).
struct EquilibriumFunctions {
    /// Energy at the displacement, infinite where it has no value. Leaves the means of parts and what they push with.
    /// @return [J]
    double (*energy)(const CoupledArrays &body, CoupledWorkspace &at) = nullptr;
    /// Elastic forces at the displacement, behind energy()
    void (*force)(const CoupledArrays &body, CoupledWorkspace &at) = nullptr;
    /// Keeps the stresses of tetrahedra for product(), behind energy()
    void (*keep_stresses)(const CoupledArrays &body, CoupledWorkspace &at) = nullptr;
    /// Minus the second derivative of the energy times the direction, behind keep_stresses()
    void (*product)(const CoupledArrays &body, CoupledWorkspace &at) = nullptr;
    /// The same at rest, where nothing has to be known before
    void (*product_at_rest)(const CoupledArrays &body, CoupledWorkspace &at) = nullptr;
};

/// Everything that vector units do with an energy. What takes doubles is empty where they have no float64.
struct EnergyFunctions {
    StepFunctions<float> (*steps)(const SlicedBody<float> &body, bool is_damped) = nullptr;
    StepFunctions<double> (*double_steps)(const SlicedBody<double> &body, bool is_damped) = nullptr;
    EquilibriumFunctions (*equilibrium)(StrainMeasure measure) = nullptr;
};

// Energies that fast kernels know, in the widest vectors that the machine has: SpringEnergy::kernels, one file each in
// kernels/energies/.
EnergyFunctions hooke_kernels();
EnergyFunctions neo_hookean_kernels();

} // namespace livermark::msm
