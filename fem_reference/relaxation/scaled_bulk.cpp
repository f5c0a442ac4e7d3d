#include "fem_reference/relaxation/scaled_bulk.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace livermark::fem_reference {

namespace {

double bulk_modulus(const core::Material &material) {
    return material.lame_lambda() + 2.0 / 3.0 * material.shear_modulus();
}

core::Material with_scaled_bulk(const core::Material &material, double part) {
    const double shear = material.shear_modulus(), bulk = bulk_modulus(material) / part;
    return {material.density, 9.0 * bulk * shear / (3.0 * bulk + shear),
            (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear))};
}

bool is_mixed_region(const core::Material &material, const PressureSystem &pressure) {
    return pressure.num_pressures() > 0 && material.poisson_ratio > pressure_above_poisson_ratio;
}

/// The body without the stiffness that pressures stand for, and with other bulk moduli in its other regions.
core::Body body_of_displacements(const core::Body &body, const PressureSystem &pressure, double part) {
    auto scaled = pressure.num_pressures() > 0 ? without_pressure(body) : body;
    for (std::size_t r = 0; r < body.materials.size(); ++r)
        if (!is_mixed_region(body.materials[r], pressure))
            scaled.materials[r] = with_scaled_bulk(body.materials[r], part);
    return scaled;
}

/// The pressures of a body with other bulk moduli: each belongs to one region.
PressureSystem with_scaled_bulk(PressureSystem pressure, const core::Body &body, double part) {
    std::vector<int> region(static_cast<std::size_t>(pressure.num_pressures()), 0);
    for (std::size_t t = 0; t < pressure.of_cell.size(); ++t)
        for (const int number : pressure.of_cell[t])
            if (number >= 0)
                region[number] = body.mesh.region[t];
    for (std::size_t row = 0; row < region.size(); ++row) {
        const auto &material = body.materials[region[row]];
        const double lambda = material.lame_lambda();
        const double scaled = bulk_modulus(material) / part - 2.0 / 3.0 * material.shear_modulus();
        for (int k = pressure.compliance.row_start[row]; k < pressure.compliance.row_start[row + 1]; ++k) {
            const double mass = lambda * pressure.compliance.value[k];
            pressure.compliance.value[k] = mass / scaled;
            pressure.norm.value[k] = mass * (1.0 / scaled + 0.5 / material.shear_modulus());
        }
    }
    return pressure;
}

} // namespace

ScaledBulk::ScaledBulk(const core::Body &body, const Discretisation &matrices, ChosenSolver &solver,
                       SolverChoice choice, double part)
    : choice_(choice), body_solver_(&solver), system_(&matrices.system),
      pressure_(with_scaled_bulk(matrices.pressure, body, part)) {
    const bool is_all_mixed = std::ranges::all_of(
        body.materials, [&](const core::Material &material) { return is_mixed_region(material, pressure_); });
    if (!is_all_mixed && part != 1.0) {
        const bool is_mixed = pressure_.num_pressures() > 0;
        own_system_ = std::make_unique<ElasticSystem>(assemble(body_of_displacements(body, pressure_, part),
                                                               matrices.system.nodes_per_cell == 4 ? 1 : 2,
                                                               is_mixed ? NodeOrder::by_distance : NodeOrder::of_mesh));
        system_ = own_system_.get();
    }
    if (pressure_.num_pressures() > 0)
        mixed_.emplace(*system_, this->solver(), pressure_);
}

ScaledBulk::ScaledBulk(const core::Body &body, const Discretisation &matrices, ChosenSolver &solver,
                       SolverChoice choice, double part, ScaledBulk &coarse, double tolerance,
                       std::span<const int> parent)
    : ScaledBulk(body, matrices, solver, choice, part) {
    if (mixed_ && coarse.mixed_)
        mixed_.emplace(*system_, this->solver(), pressure_, tolerance, *coarse.mixed_,
                       nested_iteration(*coarse.system_, coarse.pressure_, *system_, pressure_, parent));
}

ChosenSolver &ScaledBulk::solver() {
    if (!own_system_)
        return *body_solver_;
    if (!own_solver_)
        own_solver_ = std::make_unique<ChosenSolver>(*own_system_, choice_);
    return *own_solver_;
}

ConstrainedSolution ScaledBulk::solve(std::span<const double> prescribed, std::span<const double> load) {
    return mixed_ ? mixed_->solve(prescribed, load) : solver().solve(prescribed, load);
}

std::vector<double> ScaledBulk::force(std::span<const double> displacement) {
    std::vector<double> force(displacement.size());
    system_->stiffness.multiply(displacement, force);
    const auto num_pressures = static_cast<std::size_t>(pressure_.num_pressures());
    if (num_pressures == 0)
        return force;
    if (!compliance_)
        compliance_.emplace(pressure_.compliance);
    const std::vector<double> all_free(num_pressures, std::numeric_limits<double>::quiet_NaN());
    const std::vector<double> none(num_pressures, 0.0);
    std::vector<double> dilation(num_pressures); // D u, of which the pressure is C^-1
    pressure_.divergence.subtract_product(displacement, none, dilation, 1);
    const auto pressure = compliance_->solve(all_free, dilation).displacement;
    std::vector<double> not_needed(num_pressures, 0.0);
    pressure_.divergence.add_products(displacement, pressure, force, not_needed, 1);
    return force;
}

} // namespace livermark::fem_reference
