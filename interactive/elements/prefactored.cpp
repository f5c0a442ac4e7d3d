#include "interactive/elements/prefactored.hpp"

#include <stdexcept>
#include <utility>

#include "interactive/elements/rows_of_nodes.hpp"

namespace livermark::interactive {

Prefactored::Prefactored(Scene given) : Simulation(std::move(given)), rest_(positions()) {}

void Prefactored::use_vectors(kernels::PrefactoredElements elements) {
    rows_.emplace(std::move(elements));
}

void Prefactored::prepare(double time_step) {
    if (time_step == factorised_for_)
        return;
    const auto terms = inertia(*this, time_step);
    unknown_.assign(terms.stiffness.size(), -1);
    num_unknowns_ = 0;
    for (std::size_t i = 0; i < unknown_.size(); ++i)
        if (is_free()[i])
            unknown_[i] = num_unknowns_++;
    Energy::Triplets all;
    add_laplacian(all);
    Energy::Triplets kept;
    for (const auto &entry : all)
        if (unknown_[entry.row()] >= 0 && unknown_[entry.col()] >= unknown_[entry.row()])
            kept.emplace_back(unknown_[entry.row()], unknown_[entry.col()], entry.value());
    for (std::size_t i = 0; i < unknown_.size(); ++i)
        if (unknown_[i] >= 0)
            kept.emplace_back(unknown_[i], unknown_[i], terms.stiffness[i]);
    Eigen::SparseMatrix<double> matrix(num_unknowns_, num_unknowns_);
    matrix.setFromTriplets(kept.begin(), kept.end());
    if (num_unknowns_ > 0) {
        factor_.order(matrix);
        if (!factor_.factorise(matrix))
            throw std::logic_error("the matrix of projective dynamics is not positive definite");
        if (rows_)
            rows_->set_factor(factor_.factor(), unknown_, terms.stiffness);
    }
    factorised_for_ = time_step;
}

void Prefactored::step(double time_step, int iterations) {
    prepare(time_step);
    if (rows_)
        step_in_single(time_step, iterations);
    else
        step_in_double(time_step, iterations);
}

void Prefactored::step_in_single(double time_step, int iterations) {
    auto &nodes = rows_->nodes();
    nodes.aim_constrained(scene(), rest_, positions(), targets(), time_step);
    kernels::take_prefactored_step(*rows_, time_step, scene().mass_damping, iterations);
    auto &x = mutable_positions();
    take_from_rows(nodes.displacement, nodes.row_of_node, x);
    x += rest_;
    take_from_rows(nodes.velocity, nodes.row_of_node, mutable_velocities());
    move_to_targets(); // to the last bit
}

void Prefactored::step_in_double(double time_step, int iterations) {
    auto &x = mutable_positions();
    const Field before = x;
    const auto terms = inertia(*this, time_step);
    x = terms.predicted;
    Field forces(3, x.cols());
    Eigen::MatrixXd right(num_unknowns_, 3);
    for (int k = 0; k < iterations && num_unknowns_ > 0; ++k) {
        forces.setZero();
        energy().add_forces(x, forces);
        for (Eigen::Index i = 0; i < x.cols(); ++i)
            if (unknown_[i] >= 0)
                right.row(unknown_[i]) =
                    (forces.col(i) - terms.stiffness[i] * (x.col(i) - terms.predicted.col(i))).transpose();
        const Eigen::MatrixXd move = factor_.solve(right);
        for (Eigen::Index i = 0; i < x.cols(); ++i)
            if (unknown_[i] >= 0)
                x.col(i) += move.row(unknown_[i]).transpose();
    }
    mutable_velocities() = (x - before) / time_step;
}

void Prefactored::set_state(const Field &positions, const Field &velocities) {
    Simulation::set_state(positions, velocities);
    if (rows_) {
        auto &nodes = rows_->nodes();
        put_into_rows(positions - rest_, nodes.row_of_node, nodes.displacement);
        put_into_rows(velocities, nodes.row_of_node, nodes.velocity);
    }
}

void Prefactored::set_external_forces(const Field &forces) {
    Simulation::set_external_forces(forces);
    if (rows_)
        put_into_rows(external_forces(), rows_->nodes().row_of_node, rows_->nodes().external);
}

Cost Prefactored::cost(int iterations) const {
    const auto num_tetrahedra = static_cast<double>(scene().body->mesh.tetrahedra.size());
    return {.element_passes = static_cast<double>(iterations),
            .bytes_per_element = static_cast<double>(rows_ ? rows_->bytes() : bytes_of_elements()) / num_tetrahedra};
}

} // namespace livermark::interactive
