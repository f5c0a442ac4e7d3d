#include "fem_reference/hyperelastic/motion/effective_mass.hpp"

#include <stdexcept>
#include <utility>

#include "fem_reference/dynamics/mass_matrix.hpp"

namespace livermark::hyperelastic {

EffectiveMass::EffectiveMass(const Elements &elements, std::vector<bool> is_free)
    : elements_(&elements), is_free_(std::move(is_free)),
      mass_(fem_reference::consistent_mass(elements.body(), elements.system())), tangent_(elements.zero_tangent()) {
    number_.assign(is_free_.size(), -1);
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        if (is_free_[dof])
            number_[dof] = num_free_++;
    const auto &rows = tangent_.stiffness.rows;
    for (std::size_t a = 0; a < rows.num_nodes(); ++a)
        for (int i = 0; i < 3; ++i) {
            if (!is_free_[3 * a + i])
                continue;
            start_.push_back(static_cast<int>(entry_.size()));
            for (int k = rows.row_start[a]; k < rows.row_start[a + 1]; ++k)
                for (int j = 0; j < 3; ++j)
                    if (const int column = number_[3 * rows.column[k] + j]; column >= 0)
                        entry_.push_back(column);
            for (int j = 0; j <= i; ++j)
                if (const int column = number_[3 * a + j]; column >= 0)
                    entry_.push_back(column);
        }
    start_.push_back(static_cast<int>(entry_.size()));
}

void EffectiveMass::multiply_mass(std::span<const double> x, std::span<double> out) const {
    fem_reference::multiply_mass(mass_, x, out);
}

void EffectiveMass::factorise(double m, double k, const std::vector<double> &displacement,
                              const SurfaceStiffness &surface) {
    elements_->assemble_tangent({displacement, {}}, tangent_);
    surface.add_to(tangent_.stiffness);
    if (factorise(m, k))
        return;
    elements_->assemble_tangent(elements_->rest(), tangent_);
    surface.add_to(tangent_.stiffness);
    if (!factorise(m, k))
        throw std::logic_error("a body with mass has a stiffness at rest that is not positive semidefinite");
}

bool EffectiveMass::factorise(double m, double k) {
    const auto &rows = tangent_.stiffness.rows;
    std::vector<double> value;
    value.reserve(entry_.size());
    for (std::size_t a = 0; a < rows.num_nodes(); ++a) {
        // Of the mass, columns up to that of the diagonal come in the order of the blocks.
        const int first = mass_.row_start[a];
        const int num_below = rows.row_start[a + 1] - rows.row_start[a];
        for (int i = 0; i < 3; ++i) {
            if (!is_free_[3 * a + i])
                continue;
            for (int below = 0; below < num_below; ++below) {
                const int block = rows.row_start[a] + below;
                for (int j = 0; j < 3; ++j)
                    if (is_free_[3 * rows.column[block] + j])
                        value.push_back(k * tangent_.stiffness.below[block][3 * i + j] +
                                        (i == j ? m * mass_.value[first + below] : 0.0));
            }
            for (int j = 0; j <= i; ++j)
                if (is_free_[3 * a + j])
                    value.push_back(k * tangent_.stiffness.diagonal[a][3 * i + j] +
                                    (i == j ? m * mass_.value[first + num_below] : 0.0));
        }
    }
    const Eigen::Map<const Eigen::SparseMatrix<double>> upper(
        num_free_, num_free_, static_cast<Eigen::Index>(value.size()), start_.data(), entry_.data(), value.data());
    if (!is_ordered_)
        cholesky_.order(upper);
    is_ordered_ = true;
    return cholesky_.factorise(upper);
}

void EffectiveMass::solve(std::span<const double> b, std::span<double> x) const {
    Eigen::VectorXd of_free(num_free_);
    for (std::size_t dof = 0; dof < b.size(); ++dof)
        if (number_[dof] >= 0)
            of_free[number_[dof]] = b[dof];
    of_free = cholesky_.solve_single_precision(of_free);
    for (std::size_t dof = 0; dof < b.size(); ++dof)
        x[dof] = number_[dof] >= 0 ? of_free[number_[dof]] : 0.0;
}

} // namespace livermark::hyperelastic
