#include "fem_reference/hyperelastic/tangent_solver.hpp"

#include <deal.II/lac/precondition.h>
#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/vector.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/support/factors/sparse_cholesky.hpp"
#include "fem_reference/linear/chosen_solver.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::hyperelastic {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Vector = dealii::Vector<double>; // displacements, then pressures over their scale

} // namespace

struct TangentSolver::Impl {
    /// Linear elements on the same tetrahedra below the quadratic ones.
    struct Levels {
        explicit Levels(const Elements &elements)
            : linear(fem_reference::assemble(fem_reference::without_pressure(elements.body()), 1)),
              from_linear(fem_reference::prolongation(linear, elements.system())) {}

        bool set_up(const fem_reference::SymmetricBlocks<double> &stiffness, const std::vector<bool> &is_free) {
            inverse.reset();
            rounded = fem_reference::rounded(stiffness);
            linear.stiffness = fem_reference::galerkin(from_linear, stiffness, linear.stiffness.rows);
            coarse.emplace(linear, fem_reference::SolverChoice::automatic);
            inverse = fem_reference::two_level(from_linear, rounded, coarse->inverse());
            return inverse->set_up({.sets = {is_free}, .set = {0}});
        }

        fem_reference::ElasticSystem linear; ///< its stiffness is P^T K P
        fem_reference::Prolongation from_linear;
        fem_reference::SymmetricBlocks<float> rounded;
        std::optional<fem_reference::ChosenSolver> coarse;
        std::unique_ptr<fem_reference::Preconditioner> inverse;
    };

    Impl(const Elements &of, std::vector<bool> free)
        : elements(of), is_free(std::move(free)), scale(fem_reference::pressure_scale(of.body())) {
        number.assign(is_free.size(), -1);
        for (std::size_t dof = 0; dof < is_free.size(); ++dof)
            if (is_free[dof])
                number[dof] = num_free++;
        if (elements.num_pressures() > 0) {
            norm.emplace(elements.pressure().norm);
            const std::vector<double> nothing_prescribed(elements.num_pressures(),
                                                         std::numeric_limits<double>::quiet_NaN());
            norm->factorise(nothing_prescribed);
            levels.emplace(elements);
            return;
        }
        const auto &rows = elements.system().stiffness.rows;
        for (std::size_t a = 0; a < rows.num_nodes(); ++a)
            for (int i = 0; i < 3; ++i) {
                if (!is_free[3 * a + i])
                    continue;
                start.push_back(static_cast<int>(entry.size()));
                for (int k = rows.row_start[a]; k < rows.row_start[a + 1]; ++k)
                    for (int j = 0; j < 3; ++j)
                        if (const int column = number[3 * rows.column[k] + j]; column >= 0)
                            entry.push_back(column);
                for (int j = 0; j <= i; ++j)
                    if (const int column = number[3 * a + j]; column >= 0)
                        entry.push_back(column);
            }
        start.push_back(static_cast<int>(entry.size()));
    }

    std::span<double> displacements(Vector &x) const { return std::span(x.begin(), is_free.size()); }
    std::span<const double> displacements(const Vector &x) const { return std::span(x.begin(), is_free.size()); }
    std::span<double> pressures(Vector &x) const { return std::span(x.begin(), x.size()).subspan(is_free.size()); }
    std::span<const double> pressures(const Vector &x) const {
        return std::span(x.begin(), x.size()).subspan(is_free.size());
    }
    /// out = an approximate K^-1 times a force
    void apply_inverse(std::span<const double> force, std::span<double> out) const {
        if (levels) {
            std::vector<float> residual(force.begin(), force.end()), correction(force.size());
            fem_reference::clear_constrained(std::span(residual), is_free);
            levels->inverse->apply(residual, correction);
            std::ranges::copy(correction, out.begin());
            return;
        }
        Eigen::VectorXd of_free(num_free);
        for (std::size_t dof = 0; dof < force.size(); ++dof)
            if (number[dof] >= 0)
                of_free[number[dof]] = force[dof];
        of_free = cholesky.solve_single_precision(of_free);
        for (std::size_t dof = 0; dof < force.size(); ++dof)
            out[dof] = number[dof] >= 0 ? of_free[number[dof]] : 0.0;
    }

    const Elements &elements;
    std::vector<bool> is_free;
    double scale;
    std::vector<int> number; ///< (3 n) of each free displacement among these, -1 where not free
    int num_free = 0;
    std::vector<int> start, entry; ///< rows of the lower triangle on what is free, and so columns of the upper one
    support::SparseCholesky cholesky;
    bool is_ordered = false;
    mutable std::optional<fem_reference::ConstrainedSolver> norm;
    mutable std::optional<Levels> levels; ///< with a pressure
};

TangentSolver::TangentSolver(const Elements &elements, std::vector<bool> is_free)
    : impl_(std::make_unique<Impl>(elements, std::move(is_free))) {}
TangentSolver::~TangentSolver() = default;

double TangentSolver::pressure_scale() const {
    return impl_->scale;
}

bool TangentSolver::is_direct() const {
    return !impl_->levels;
}

bool TangentSolver::factorise(const fem_reference::SymmetricBlocks<double> &stiffness) {
    if (impl_->levels)
        return impl_->levels->set_up(stiffness, impl_->is_free);
    std::vector<double> value;
    value.reserve(impl_->entry.size());
    const auto &rows = stiffness.rows;
    const auto is_free = [&](std::size_t node, int i) { return impl_->is_free[3 * node + i]; };
    for (std::size_t a = 0; a < rows.num_nodes(); ++a)
        for (int i = 0; i < 3; ++i) {
            if (!is_free(a, i))
                continue;
            for (int k = rows.row_start[a]; k < rows.row_start[a + 1]; ++k)
                for (int j = 0; j < 3; ++j)
                    if (is_free(rows.column[k], j))
                        value.push_back(stiffness.below[k][3 * i + j]);
            for (int j = 0; j <= i; ++j)
                if (is_free(a, j))
                    value.push_back(stiffness.diagonal[a][3 * i + j]);
        }
    const Eigen::Map<const Sparse> upper(impl_->num_free, impl_->num_free, static_cast<Eigen::Index>(value.size()),
                                         impl_->start.data(), impl_->entry.data(), value.data());
    if (!impl_->is_ordered)
        impl_->cholesky.order(upper);
    impl_->is_ordered = true;
    return impl_->cholesky.factorise(upper);
}

namespace {

/// The interface that deal.II's solvers call.
template <class Action> struct Operator {
    Action action;
    void vmult(Vector &out, const Vector &x) const { action(out, x); }
};
template <class Action> Operator(Action) -> Operator<Action>;

} // namespace

TangentSolver::Correction TangentSolver::solve(const TangentMatrices &tangent, const SurfaceStiffness &surface,
                                               const State &right, double tolerance) const {
    const auto &impl = *impl_;
    const auto num_displacements = impl.is_free.size();
    const auto num_pressures = static_cast<std::size_t>(impl.elements.num_pressures());
    std::vector<double> scaled(num_pressures), volumes(num_pressures);
    const Operator matrix{[&](Vector &out, const Vector &x) {
        const auto u = impl.displacements(x);
        const auto force = impl.displacements(out);
        tangent.stiffness.multiply(u, force);
        surface.add_product(u, force);
        if (num_pressures > 0) {
            for (std::size_t k = 0; k < num_pressures; ++k)
                scaled[k] = impl.scale * impl.pressures(x)[k];
            fem_reference::multiply(impl.elements.compliance(), scaled, volumes);
            tangent.divergence.add_products(u, scaled, force, volumes, 1);
            for (std::size_t k = 0; k < num_pressures; ++k)
                impl.pressures(out)[k] = impl.scale * volumes[k];
        }
        fem_reference::clear_constrained(force, impl.is_free);
    }};
    const Operator preconditioner{[&](Vector &out, const Vector &x) {
        impl.apply_inverse(impl.displacements(x), impl.displacements(out));
        if (num_pressures > 0) {
            for (std::size_t k = 0; k < num_pressures; ++k)
                scaled[k] = impl.pressures(x)[k] / impl.scale;
            tangent.divergence.subtract_product(impl.displacements(std::as_const(out)), scaled, volumes, 1);
            impl.norm->solve_constrained(volumes, impl.pressures(out));
            for (double &pressure : impl.pressures(out))
                pressure /= impl.scale;
        }
    }};

    Vector load(num_displacements + num_pressures), x(num_displacements + num_pressures);
    std::ranges::copy(right.displacement, load.begin());
    fem_reference::clear_constrained(impl.displacements(load), impl.is_free);
    for (std::size_t k = 0; k < num_pressures; ++k)
        impl.pressures(load)[k] = impl.scale * right.pressure[k];

    Correction result;
    dealii::ReductionControl control(max_iterations, std::numeric_limits<double>::min(), tolerance);
    constexpr unsigned int most_vectors = 70;
    dealii::SolverGMRES<Vector> gmres(control, dealii::SolverGMRES<Vector>::AdditionalData(most_vectors));
    try {
        gmres.solve(matrix, x, load, preconditioner);
        result.converged = true;
    } catch (const dealii::SolverControl::NoConvergence &) {
        result.converged = false;
    }
    result.iterations = static_cast<int>(control.last_step());
    result.change.displacement.assign(x.begin(), x.begin() + num_displacements);
    for (const double pressure : impl.pressures(std::as_const(x)))
        result.change.pressure.push_back(impl.scale * pressure);
    return result;
}

} // namespace livermark::hyperelastic
