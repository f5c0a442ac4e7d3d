#pragma once

#include <functional>
#include <span>
#include <string>

#include "msm/dynamics/motion.hpp"

namespace livermark::msm {

/// Moves a state on by one step.
using Step = std::function<void(State &)>;

/// A rule that takes an equation of motion from one time to the next. One file each in integrators/ or
/// implicit_integrators/, named as the integrator.
struct Integrator {
    std::string name;        ///< the file stem; set by the table
    std::string summary;     ///< one line
    std::string source;      ///< literature reference
    int order = 1;           ///< of the error after a given time in the length of the step
    bool is_explicit = true; ///< takes no more than accelerations
    bool is_symplectic = false;
    /// Bears steps under strong damping that are so long that what limits them is not stability but accuracy.
    bool is_stabilised = false;
    int forces_per_step = 1; ///< evaluations of the forces; 0 if a step takes as many as it needs
    /// Steps of one length; what it returns keeps its scratch space, so each thread needs its own.
    /// @param equation   kept alive and unchanged by the caller
    /// @param time_step  h [s], > 0
    std::function<Step(const EquationOfMotion &equation, double time_step)> prepare;
    /// The same method with another number of forces in a step, >= 2; nullptr if it has but one. Stable steps under
    /// strong damping are about as long as forces_per_step^2 - 1 of them.
    Integrator (*with_forces_per_step)(int number) = nullptr;
};

/// Every integrator of integrators/, in alphabetical order: the explicit ones. See msm/implicit_integrators.hpp for
/// all.
std::span<const Integrator> all_integrators();

/// @param known  where to look
/// @throws support::InputError if there is none of that name
const Integrator &find_integrator(const std::string &name, std::span<const Integrator> known = all_integrators());

} // namespace livermark::msm
