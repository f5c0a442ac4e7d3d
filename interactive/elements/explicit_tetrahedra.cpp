#include "interactive/elements/explicit_tetrahedra.hpp"

#include <utility>

#include "interactive/elements/rows_of_nodes.hpp"
#include "interactive/elements/tetrahedra.hpp"
#include "interactive/kernels/explicit_steps.hpp"

namespace livermark::interactive {

ExplicitTetrahedra::ExplicitTetrahedra(Scene given, kernels::Pressure pressure)
    : CentralDifferences(std::move(given)), pressure_(pressure), rest_(positions()) {
    if (scene().precision == Precision::single_precision)
        rows_ = kernels::explicit_rows(scene(), pressure_);
}

void ExplicitTetrahedra::step(double time_step, int iterations) {
    if (!rows_) {
        CentralDifferences::step(time_step, iterations);
        return;
    }
    put_constrained_into_rows(time_step);
    kernels::take_explicit_steps(*rows_, time_step / iterations, scene().mass_damping, iterations);
    auto &x = mutable_positions();
    auto &v = mutable_velocities();
    take_from_rows(rows_->displacement, rows_->row_of_node, x);
    x += rest_;
    take_from_rows(rows_->velocity, rows_->row_of_node, v);
    move_to_targets(); // to the last bit
}

void ExplicitTetrahedra::set_state(const Field &positions, const Field &velocities) {
    CentralDifferences::set_state(positions, velocities);
    if (rows_) {
        put_into_rows(positions - rest_, rows_->row_of_node, rows_->displacement);
        put_into_rows(velocities, rows_->row_of_node, rows_->velocity);
    }
}

void ExplicitTetrahedra::set_external_forces(const Field &forces) {
    CentralDifferences::set_external_forces(forces);
    if (rows_)
        put_into_rows(external_forces(), rows_->row_of_node, rows_->external);
}

Cost ExplicitTetrahedra::cost(int iterations) const {
    const double passes = pressure_ == kernels::Pressure::around_nodes ? 2.0 : 1.0;
    const auto num_tetrahedra = static_cast<double>(scene().body->mesh.tetrahedra.size());
    return {.element_passes = passes * iterations,
            .bytes_per_element = rows_ ? static_cast<double>(rows_->bytes()) / num_tetrahedra
                                       : static_cast<double>(sizeof(Tetrahedron))};
}

/// They begin where they were told to be before, without what single precision has lost on the way there.
void ExplicitTetrahedra::put_constrained_into_rows(double time_step) {
    const auto &nodes = scene().constrained_nodes;
    for (std::size_t c = 0; c < nodes.size(); ++c) {
        const int row = rows_->row_of_node[nodes[c]];
        const core::Vector3 now = positions().col(nodes[c]);
        in_row(rows_->displacement, row) = (now - rest_.col(nodes[c])).cast<float>();
        in_row(rows_->velocity, row) = ((targets().col(static_cast<Eigen::Index>(c)) - now) / time_step).cast<float>();
    }
}

} // namespace livermark::interactive
