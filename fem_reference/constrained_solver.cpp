#include "fem_reference/constrained_solver.hpp"

#include <cholmod.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/openmp.hpp"
#include "fem_reference/columns.hpp"
#include "fem_reference/mass_matrix.hpp"

namespace livermark::fem_reference {

namespace {

/// Below this ratio of the smallest to the largest pivot nothing but rounding is left of the smallest one: a body free
/// to move gave 5e-15 or less, a rod a hundred times longer than wide and held at one end 2e-8.
constexpr double singular_pivot_ratio = 1e-12;

/// out = K u - f
std::vector<double> residual_of(const SymmetricMatrix &matrix, std::span<const double> u, std::span<const double> f) {
    std::vector<double> out(u.size());
    multiply(matrix, u, out);
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] -= f[i];
    return out;
}

} // namespace

struct ConstrainedSolver::Impl {
    explicit Impl(const SymmetricMatrix &matrix) : stiffness(matrix) {
        core::keep_openmp_in_this_thread();
        cholmod_start(&common);
        common.print = 0;
        // One ordering instead of the best of several, and one kind of factor: the same bits every time. Nested
        // dissection costs 77 GFlop for 70,000 unknowns of quadratic tetrahedra where minimum degree costs 264.
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_METIS;
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.useGPU = 0;
    }
    ~Impl() {
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }
    Impl(const Impl &) = delete;
    Impl &operator=(const Impl &) = delete;

    void check(const std::string &what) const {
        if (common.status < CHOLMOD_OK)
            throw std::runtime_error("CHOLMOD failed to " + what + " a matrix of " + std::to_string(free_dofs.size()) +
                                     " rows" + (common.status == CHOLMOD_OUT_OF_MEMORY ? ": out of memory" : ""));
    }

    void factorise(std::span<const double> prescribed);
    std::vector<double> solve_free(std::vector<double> right_hand_sides);

    const SymmetricMatrix &stiffness;
    cholmod_common common{};
    cholmod_factor *factor = nullptr;
    std::vector<bool> is_free;  ///< (n) of the factor in use
    std::vector<int> free_dofs; ///< rows of the factor in use
    bool unique = false;
    double factor_seconds = 0.0;
};

void ConstrainedSolver::Impl::factorise(std::span<const double> prescribed) {
    const auto start = std::chrono::steady_clock::now();
    std::vector<bool> wanted(prescribed.size());
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        wanted[i] = std::isnan(prescribed[i]);
    if (wanted == is_free)
        return;
    cholmod_free_factor(&factor, &common);
    is_free.clear(); // what follows may throw
    free_dofs.clear();
    std::vector<int> free_index(wanted.size(), -1);
    for (std::size_t i = 0; i < wanted.size(); ++i)
        if (wanted[i]) {
            free_index[i] = static_cast<int>(free_dofs.size());
            free_dofs.push_back(static_cast<int>(i));
        }
    unique = true;
    if (!free_dofs.empty()) {
        // The upper triangle by columns; symmetry lets it be read from the rows.
        std::vector<int> column_start{0};
        std::vector<int> row;
        std::vector<double> value;
        for (const int dof : free_dofs) {
            for (int k = stiffness.row_start[dof]; k < stiffness.row_start[dof + 1] && stiffness.column[k] <= dof; ++k)
                if (const int other = free_index[stiffness.column[k]]; other >= 0) {
                    row.push_back(other);
                    value.push_back(stiffness.value[k]);
                }
            column_start.push_back(static_cast<int>(row.size()));
        }
        cholmod_sparse upper{};
        upper.nrow = upper.ncol = free_dofs.size();
        upper.nzmax = value.size();
        upper.p = column_start.data();
        upper.i = row.data();
        upper.x = value.data();
        upper.stype = 1;
        upper.itype = CHOLMOD_INT;
        upper.xtype = CHOLMOD_REAL;
        upper.dtype = CHOLMOD_DOUBLE;
        upper.sorted = 1;
        upper.packed = 1;
        factor = cholmod_analyze(&upper, &common);
        check("order");
        cholmod_factorize(&upper, factor, &common);
        check("factor");
        unique = common.status == CHOLMOD_OK && cholmod_rcond(factor, &common) > singular_pivot_ratio;
    }
    is_free = std::move(wanted);
    factor_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// @param right_hand_sides  one behind the other
std::vector<double> ConstrainedSolver::Impl::solve_free(std::vector<double> right_hand_sides) {
    cholmod_dense b{};
    b.nzmax = right_hand_sides.size();
    b.nrow = b.d = free_dofs.size();
    b.ncol = b.nzmax / b.nrow;
    b.x = right_hand_sides.data();
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    cholmod_dense *x = cholmod_solve(CHOLMOD_A, factor, &b, &common);
    check("solve with");
    const double *const values = static_cast<const double *>(x->x);
    right_hand_sides.assign(values, values + x->nzmax);
    cholmod_free_dense(&x, &common);
    return right_hand_sides;
}

ConstrainedSolver::ConstrainedSolver(const SymmetricMatrix &stiffness) : impl_(std::make_unique<Impl>(stiffness)) {}
ConstrainedSolver::~ConstrainedSolver() = default;
ConstrainedSolver::ConstrainedSolver(ConstrainedSolver &&) noexcept = default;
ConstrainedSolver &ConstrainedSolver::operator=(ConstrainedSolver &&) noexcept = default;

bool ConstrainedSolver::factorise(std::span<const double> prescribed) {
    impl_->factorise(prescribed);
    return impl_->unique;
}

void ConstrainedSolver::solve_held(std::span<const double> load, std::span<double> u, int lanes,
                                   std::span<const int> columns) {
    const auto &free_dofs = impl_->free_dofs;
    for (const int column : columns)
        for (std::size_t entry = column; entry < u.size(); entry += lanes)
            u[entry] = 0.0;
    if (free_dofs.empty())
        return;
    std::vector<double> right_hand_sides;
    right_hand_sides.reserve(free_dofs.size() * columns.size());
    for (const int column : columns)
        for (const int dof : free_dofs)
            right_hand_sides.push_back(load[static_cast<std::size_t>(lanes) * dof + column]);
    const auto answers = impl_->solve_free(std::move(right_hand_sides));
    auto answer = answers.begin();
    for (const int column : columns)
        for (const int dof : free_dofs)
            u[static_cast<std::size_t>(lanes) * dof + column] = *answer++;
}

void ConstrainedSolver::solve_held(std::span<const double> load, std::span<double> u) {
    constexpr std::array only{0};
    solve_held(load, u, 1, only);
}

ConstrainedSolution ConstrainedSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
    impl_->factorise(prescribed);
    ConstrainedSolution solution;
    solution.unique = impl_->unique;
    if (!solution.unique)
        return solution;

    auto &u = solution.displacement;
    u.resize(prescribed.size());
    for (std::size_t i = 0; i < u.size(); ++i)
        u[i] = impl_->is_free[i] ? 0.0 : prescribed[i];
    const auto &free_dofs = impl_->free_dofs;
    if (!free_dofs.empty()) {
        const auto imbalance = residual_of(impl_->stiffness, u, load);
        std::vector<double> right_hand_side;
        right_hand_side.reserve(free_dofs.size());
        for (const int dof : free_dofs)
            right_hand_side.push_back(-imbalance[dof]);
        const auto answer = impl_->solve_free(std::move(right_hand_side));
        for (std::size_t i = 0; i < free_dofs.size(); ++i)
            u[free_dofs[i]] = answer[i];
    }
    solution.residual = residual_of(impl_->stiffness, u, load);
    solution.energy = 0.5 * (dot(u, solution.residual) + dot(u, load));
    return solution;
}

double ConstrainedSolver::factor_seconds() const {
    return impl_->factor_seconds;
}

} // namespace livermark::fem_reference
