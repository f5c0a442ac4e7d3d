#include "fem_reference/dynamics/newmark.hpp"

#include "fem_reference/dynamics/mass_matrix.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::fem_reference {

struct Newmark::Impl {
    Impl(const SymmetricBlocks<double> &stiffness_, const SymmetricMatrix &mass_, const core::RayleighDamping &damping,
         double time_step_)
        : stiffness(stiffness_), mass(mass_), time_step(time_step_),
          solver(combine(damping.beta + 0.5 * time_step, compressed_rows(stiffness), damping.alpha + 2.0 / time_step,
                         mass)),
          force(3 * static_cast<std::size_t>(mass.num_rows())), momentum(force.size()), mean_velocity(force.size()) {}

    Energy multiply_by_matrices(const Motion &motion);
    Energy advance(Motion &motion, std::span<const double> load);

    const SymmetricBlocks<double> &stiffness;
    const SymmetricMatrix &mass;
    double time_step;
    ConstrainedSolver solver;
    std::vector<double> force, momentum, mean_velocity;
};

/// force = K u, momentum = M v
Energy Newmark::Impl::multiply_by_matrices(const Motion &motion) {
    stiffness.multiply(motion.displacement, force);
    multiply_mass(mass, motion.velocity, momentum);
    return {.kinetic = 0.5 * dot(motion.velocity, momentum), .strain = 0.5 * dot(motion.displacement, force)};
}

Energy Newmark::Impl::advance(Motion &motion, std::span<const double> load) {
    const auto before = multiply_by_matrices(motion);
    for (std::size_t i = 0; i < force.size(); ++i)
        force[i] = 2.0 / time_step * momentum[i] + load[i] - force[i];
    solver.solve_constrained(force, mean_velocity);
    for (std::size_t i = 0; i < force.size(); ++i) {
        motion.displacement[i] += time_step * mean_velocity[i];
        motion.velocity[i] = 2.0 * mean_velocity[i] - motion.velocity[i];
    }
    return before;
}

Newmark::Newmark(const SymmetricBlocks<double> &stiffness, const SymmetricMatrix &mass,
                 const core::RayleighDamping &damping, double time_step, std::span<const double> prescribed)
    : impl_(std::make_unique<Impl>(stiffness, mass, damping, time_step)) {
    impl_->solver.factorise(prescribed); // the mass makes it positive definite, whatever is constrained
}
Newmark::~Newmark() = default;
Newmark::Newmark(Newmark &&) noexcept = default;
Newmark &Newmark::operator=(Newmark &&) noexcept = default;

Energy Newmark::advance(Motion &motion, std::span<const double> load) {
    return impl_->advance(motion, load);
}

Energy Newmark::energy(const Motion &motion) const {
    return impl_->multiply_by_matrices(motion);
}

} // namespace livermark::fem_reference
