#include "interactive/elements/explicit_tetrahedra.hpp"

#include <utility>

#include "interactive/elements/quadratic_tetrahedra.hpp"
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
    rows_->aim_constrained(scene(), rest_, positions(), targets(), time_step);
    const double h = time_step / iterations;
    if (correction() == nullptr && ball() == nullptr && !after_step())
        kernels::take_explicit_steps(*rows_, h, scene().mass_damping, iterations);
    else
        for (int i = 0; i < iterations; ++i) {
            if (correction() != nullptr)
                take_corrected_step(h);
            else
                kernels::take_explicit_steps(*rows_, h, scene().mass_damping, 1);
            if (ball() != nullptr)
                push_rows_out(ball()->part(i, iterations), h);
            if (after_step())
                act_on_rows(static_cast<double>(i + 1) / iterations, h);
        }
    auto &x = mutable_positions();
    take_from_rows(rows_->displacement, rows_->row_of_node, x);
    x += rest_;
    take_from_rows(rows_->velocity, rows_->row_of_node, mutable_velocities());
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
    const auto num_nodes = static_cast<double>(positions().cols());
    const std::size_t of_element = scene().own_nodes.empty() ? sizeof(Tetrahedron) : sizeof(QuadraticTetrahedron);
    // Positions, velocities and external forces, and a mass.
    const double in_double = static_cast<double>(of_element) + 10 * sizeof(double) * num_nodes / num_tetrahedra;
    return {.element_passes = passes * iterations,
            .bytes_per_element = rows_ ? static_cast<double>(rows_->bytes()) / num_tetrahedra : in_double};
}

Orders ExplicitTetrahedra::orders() const {
    return rows_ ? rows_->orders() : Orders{};
}

void ExplicitTetrahedra::push_rows_out(const core::BallStep &step, double h) {
    push_out(
        step, h, [&](int n) { return FineRow(rest_.col(n), in_row(rows_->displacement, rows_->row_of_node[n])); },
        [&](int n) { return FineRow(core::Vector3::Zero(), in_row(rows_->velocity, rows_->row_of_node[n])); });
}

void ExplicitTetrahedra::act_on_rows(double part, double h) {
    NodesOfStep nodes(
        [&](int n) -> core::Vector3 {
            return in_row(std::as_const(rows_->displacement), rows_->row_of_node[n]).cast<double>();
        },
        [&](int n, const core::Vector3 &change) {
            in_row(rows_->displacement, rows_->row_of_node[n]) += (h * change).cast<float>();
            in_row(rows_->velocity, rows_->row_of_node[n]) += change.cast<float>();
        });
    after_step()(nodes, part, h);
}

/// Steps of (1 + alpha h / 2) v = (1 - alpha h / 2) v_before + change, and of the change that is corrected.
void ExplicitTetrahedra::take_corrected_step(double h) {
    const auto &nodes = correction()->nodes();
    const auto num_nodes = static_cast<Eigen::Index>(nodes.size());
    const double half_damping = 0.5 * scene().mass_damping * h;
    const auto row = [&](kernels::Aligned<float> &rows, Eigen::Index i) {
        return in_row(rows, rows_->row_of_node[nodes[i]]);
    };
    Field x(3, num_nodes), before = x, change = x;
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
        x.col(i) = rest_.col(nodes[i]) + row(rows_->displacement, i).cast<double>();
        before.col(i) = row(rows_->velocity, i).cast<double>();
    }
    kernels::take_explicit_steps(*rows_, h, scene().mass_damping, 1);
    for (Eigen::Index i = 0; i < num_nodes; ++i)
        change.col(i) =
            (1.0 + half_damping) * row(rows_->velocity, i).cast<double>() - (1.0 - half_damping) * before.col(i);
    const Field uncorrected = change;
    correction()->correct(x, before, h, change);
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
        const Eigen::Vector3f more = ((change.col(i) - uncorrected.col(i)) / (1.0 + half_damping)).cast<float>();
        row(rows_->velocity, i) += more;
        row(rows_->displacement, i) += static_cast<float>(h) * more;
    }
}

} // namespace livermark::interactive
