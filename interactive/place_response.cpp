#include "interactive/place_response.hpp"

#include <stdexcept>

#include "interactive/inertia.hpp"
#include "support/factors/sparse_cholesky.hpp"

namespace livermark::interactive {

namespace {

/// The upper triangle of h^2 K + M (1 + alpha h), of unknowns.
/// @param unknown  (3 N) number of each, -1 where constrained
Eigen::SparseMatrix<double> step_matrix(const Simulation &at_rest, double time_step, const std::vector<int> &unknown,
                                        int num_unknowns) {
    const double square = time_step * time_step;
    Energy::Triplets all, kept;
    at_rest.energy().add_hessian(rest_positions(at_rest.scene()), false, all);
    for (const auto &entry : all) {
        const int row = unknown[entry.row()], column = unknown[entry.col()];
        if (row >= 0 && column >= row)
            kept.emplace_back(row, column, square * entry.value());
    }
    const auto terms = inertia(at_rest, time_step);
    for (std::size_t k = 0; k < unknown.size(); ++k)
        if (unknown[k] >= 0)
            kept.emplace_back(unknown[k], unknown[k], square * terms.stiffness[k / 3]);
    Eigen::SparseMatrix<double> matrix(num_unknowns, num_unknowns);
    matrix.setFromTriplets(kept.begin(), kept.end());
    return matrix;
}

} // namespace

Eigen::MatrixXf place_response(const Simulation &at_rest, double time_step,
                               const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights) {
    const auto is_free = free_nodes(at_rest.scene());
    std::vector<int> unknown(3 * is_free.size(), -1);
    int num_unknowns = 0;
    for (std::size_t k = 0; k < unknown.size(); ++k)
        if (is_free[k / 3])
            unknown[k] = num_unknowns++;
    Eigen::MatrixXf response = Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(unknown.size()), 3 * weights.rows());
    if (num_unknowns == 0)
        return response;
    const auto matrix = step_matrix(at_rest, time_step, unknown, num_unknowns);
    support::SparseCholesky factor;
    factor.order(matrix);
    if (!factor.factorise(matrix))
        throw std::logic_error("the matrix of a step is not positive definite at rest");
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(num_unknowns, response.cols());
    for (Eigen::Index place = 0; place < weights.rows(); ++place)
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, place); entry; ++entry)
            for (Eigen::Index c = 0; c < 3; ++c)
                if (const int row = unknown[3 * entry.col() + c]; row >= 0)
                    right(row, 3 * place + c) = entry.value();
    const Eigen::MatrixXd solution = factor.solve(right);
    for (std::size_t k = 0; k < unknown.size(); ++k)
        if (unknown[k] >= 0)
            response.row(static_cast<Eigen::Index>(k)) = solution.row(unknown[k]).cast<float>();
    return response;
}

Eigen::MatrixXf observed_place_response(Simulation &at_rest, double interval, int steps, int iterations,
                                        const Eigen::SparseMatrix<double, Eigen::RowMajor> &weights, double force) {
    const Field rest = rest_positions(at_rest.scene()), none = Field::Zero(3, rest.cols());
    Eigen::MatrixXf response(rest.size(), 3 * weights.rows());
    for (Eigen::Index column = 0; column < response.cols(); ++column) {
        Field forces = none;
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, column / 3); entry; ++entry)
            forces(column % 3, entry.col()) = force * entry.value();
        at_rest.set_state(rest, none);
        at_rest.set_external_forces(forces);
        for (int s = 0; s < steps; ++s)
            at_rest.step(interval / steps, iterations);
        const Field moved = (at_rest.positions() - rest) / (interval * interval * force);
        response.col(column) = Eigen::Map<const Eigen::VectorXd>(moved.data(), moved.size()).cast<float>();
    }
    return response;
}

} // namespace livermark::interactive
