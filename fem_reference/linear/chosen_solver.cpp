#include "fem_reference/linear/chosen_solver.hpp"

#include <deal.II/lac/solver_control.h>
#include <deal.II/lac/solver_gmres.h>
#include <deal.II/lac/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fem_reference/linear/elastic_system.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "fem_reference/solvers/two_level.hpp"

namespace livermark::fem_reference {

namespace {

/// Sparse Cholesky factors as a preconditioner that is exact: one for each set of unknowns that are free.
class Factor : public Preconditioner {
  public:
    /// @param first  of the first set, shared with who solves with it alone
    Factor(const SymmetricBlocks<double> &stiffness, ConstrainedSolver &first) : stiffness_(stiffness), first_(first) {}

    bool set_up(const FreeUnknowns &free) override {
        while (others_.size() + 1 < free.sets.size())
            others_.emplace_back(compressed_rows(stiffness_));
        columns_.assign(free.sets.size(), {});
        for (int lane = 0; lane < free.lanes(); ++lane)
            columns_[free.set[lane]].push_back(lane);
        bool unique = true;
        for (std::size_t s = 0; s < free.sets.size(); ++s) {
            const auto &is_free = free.sets[s];
            std::vector<double> prescribed(is_free.size(), 0.0);
            for (std::size_t dof = 0; dof < is_free.size(); ++dof)
                if (is_free[dof])
                    prescribed[dof] = std::numeric_limits<double>::quiet_NaN();
            unique = solver(s).factorise(prescribed) && unique;
        }
        lanes_ = free.lanes();
        return unique;
    }
    void apply(std::span<const float> residual, std::span<float> correction) override {
        for (std::size_t s = 0; s < columns_.size(); ++s)
            solver(s).solve_single_precision(residual, correction, lanes_, columns_[s]);
    }
    std::size_t max_columns() const override { return most_lanes; }
    std::string name() const override { return "CHOLMOD"; }

  private:
    ConstrainedSolver &solver(std::size_t set) { return set == 0 ? first_ : others_[set - 1]; }

    const SymmetricBlocks<double> &stiffness_;
    ConstrainedSolver &first_;
    std::vector<ConstrainedSolver> others_;
    std::vector<std::vector<int>> columns_; ///< of each set
    int lanes_ = 0;
};

} // namespace

ChosenSolver::ChosenSolver(const ElasticSystem &system, SolverChoice choice) : stiffness_(&system.stiffness) {
    if (choice == SolverChoice::iterative ||
        (choice == SolverChoice::automatic && system.stiffness.num_rows() > largest_direct_system)) {
        iterative_.emplace(system.stiffness, algebraic_multigrid(system));
    } else {
        direct_.emplace(compressed_rows(system.stiffness));
        factor_ = std::make_unique<Factor>(system.stiffness, *direct_);
    }
}

ChosenSolver::ChosenSolver(const ElasticSystem &fine, const ElasticSystem &coarse, ChosenSolver &coarse_solver,
                           std::span<const int> parent)
    : stiffness_(&fine.stiffness),
      single_precision_(std::make_unique<SymmetricBlocks<float>>(rounded(fine.stiffness))) {
    iterative_.emplace(fine.stiffness,
                       two_level(prolongation(coarse, fine, parent), *single_precision_, coarse_solver.inverse()));
}

void ChosenSolver::set_up(std::span<const double> prescribed) {
    if (direct_)
        direct_->factorise(prescribed);
    else
        iterative_->set_up(prescribed);
}

ConstrainedSolution ChosenSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
    return direct_ ? direct_->solve(prescribed, load) : iterative_->solve(prescribed, load);
}

double ChosenSolver::setup_seconds() const {
    return direct_ ? direct_->factor_seconds() : iterative_->setup_seconds();
}

void ChosenSolver::multiply(std::span<const double> x, std::span<double> out) const {
    stiffness_->multiply(x, out);
}

void ChosenSolver::multiply(std::span<const float> x, std::span<float> out) const {
    if (!single_precision_)
        single_precision_ = std::make_unique<SymmetricBlocks<float>>(rounded(*stiffness_));
    single_precision_->multiply(x, out);
}

Preconditioner &ChosenSolver::inverse() {
    return direct_ ? *factor_ : iterative_->preconditioner();
}

std::size_t ChosenSolver::max_columns() const {
    return direct_ ? 1 : iterative_->preconditioner().max_columns(); // factors of several sets fill the memory
}

std::string ChosenSolver::description(const ConstrainedSolution &solution) const {
    if (direct_)
        return "CHOLMOD";
    return "CG, " + std::to_string(solution.iterations) + " iterations, " + iterative_->preconditioner().name();
}

Corners::Corners(const core::Body &body, SolverChoice choice, const Discretisation &matrices, int largest_factor,
                 const std::optional<core::Foundation> &foundation) {
    const bool is_mixed = matrices.pressure.num_pressures() > 0;
    const bool is_large =
        matrices.system.nodes_per_cell > 4 && matrices.system.stiffness.num_rows() > largest_direct_quadratic_system;
    if (choice != SolverChoice::automatic || !(is_mixed || is_large))
        return;
    system = std::make_unique<ElasticSystem>(
        assemble(is_mixed ? without_pressure(body) : body, 1, NodeOrder::of_mesh, foundation));
    const bool is_factored = system->stiffness.num_rows() <= largest_factor;
    solver = std::make_unique<ChosenSolver>(*system, is_factored ? SolverChoice::direct : SolverChoice::iterative);
}

/// The matrix [K D^T; D -C] on free displacements and all pressures, for vectors that are worked on together (see
/// matrices.hpp): displacements (3 n, lanes), pressures (m, lanes).
struct SaddlePoint {
    const ChosenSolver &solver; ///< of K
    const PressureSystem &pressure;
    const DivergenceRows<float> &single_precision_divergence; ///< that of the pressure
    int lanes;
    std::span<const std::size_t> constrained; ///< entries of displacements that are not free, see constrained_entries()

    /// force = K u + D^T p, and imbalance = D u - C p
    void apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
               std::span<double> imbalance) const;
    void apply(std::span<const float> u, std::span<const float> p, std::span<float> force,
               std::span<float> imbalance) const;
};

/// A right-hand side.
struct SaddlePointLoad {
    std::vector<double> f; ///< (3 n, lanes) zero where not free
    std::vector<double> g; ///< (m, lanes)
};

/// End of the iterations.
struct SaddlePointEnding {
    int iterations = 0;
    bool converged = true;
};

namespace {

/// Displacements of all columns, then pressures of all columns: one system.
using Vector = dealii::Vector<double>;
/// The same in the iterations, which keep some twenty of them: half the memory to go through.
using KrylovVector = dealii::Vector<float>;

/// Reduction that one round of iterations may reach: in single precision what they believe to be left differs from what
/// is left.
constexpr double furthest_round = 2e-5;
/// A round that ends further than it was told to begins another one.
constexpr double reserve = 0.5;
/// The residual as the preconditioner sees it is less than the error, where it is a pressure that the mass of pressures
/// takes for smaller than it is.
constexpr double seen_of_tolerance = 0.4;
/// Vectors of a Krylov space; a round takes about twenty.
constexpr int largest_space = 40;

template <class T> std::span<T> part(dealii::Vector<T> &vector, std::size_t first, std::size_t count) {
    return {vector.begin() + first, count};
}

template <class T> std::span<const T> part(const dealii::Vector<T> &vector, std::size_t first, std::size_t count) {
    return {vector.begin() + first, count};
}

/// The matrix and its preconditioner, pressures of each column in a unit of their own.
struct Scaled {
    const SaddlePoint &matrix;
    Preconditioner &inverse;
    ConstrainedSolver &norm;
    std::size_t num_u, num_p; ///< of all columns
    std::vector<double> unit; ///< (lanes) [Pa/m]

    template <class T> void vmult(dealii::Vector<T> &out, const dealii::Vector<T> &in) const {
        const auto pressures = part(in, num_u, num_p);
        std::vector<T> p(pressures.begin(), pressures.end());
        scale(unit, p);
        const auto force = part(out, 0, num_u);
        matrix.apply(part(in, 0, num_u), p, force, part(out, num_u, num_p));
        zero(matrix.constrained, force);
    }

    /// u = K^-1 f, p = S^-1 (D u - g)
    void precondition(KrylovVector &out, const KrylovVector &in) const {
        const auto u = part(out, 0, num_u), p = part(out, num_u, num_p);
        inverse.apply(part(in, 0, num_u), u);
        std::vector<float> imbalance(num_p);
        matrix.single_precision_divergence.subtract_product(u, part(in, num_u, num_p), imbalance, matrix.lanes);
        std::vector<int> columns(matrix.lanes);
        std::iota(columns.begin(), columns.end(), 0);
        norm.solve_single_precision(imbalance, p, matrix.lanes, columns);
        auto per_unit = unit;
        for (double &value : per_unit)
            value = 1.0 / value;
        scale(per_unit, p);
    }
};

/// right_hand_side - A unknowns
Vector residual(const Scaled &system, const Vector &right_hand_side, const Vector &unknowns) {
    Vector left(right_hand_side);
    system.vmult(left, unknowns);
    left.sadd(-1.0, 1.0, right_hand_side);
    return left;
}

void add(Vector &sum, const KrylovVector &summand) {
    std::ranges::transform(sum, summand, sum.begin(), std::plus<>());
}

/// Rounds of iterations until the preconditioned residual is small.
/// @param size      of the preconditioned load, of which the right-hand side may be a part
/// @param unknowns  zero
SaddlePointEnding iterate(const Scaled &system, double size, double goal, int max_iterations,
                          const Vector &right_hand_side, Vector &unknowns) {
    const Operator preconditioner{[&](KrylovVector &out, const KrylovVector &in) { system.precondition(out, in); }};
    SaddlePointEnding ending;
    KrylovVector correction(right_hand_side.size()), to_solve(right_hand_side.size()), seen(right_hand_side.size());
    Vector left(right_hand_side);
    to_solve = left;
    while (size > goal) {
        dealii::ReductionControl control(max_iterations - ending.iterations, reserve * goal, furthest_round);
        correction = 0.0F;
        using Solver = dealii::SolverGMRES<KrylovVector>;
        try {
            Solver(control, Solver::AdditionalData(largest_space)).solve(system, correction, to_solve, preconditioner);
        } catch (const dealii::SolverControl::NoConvergence &) {
            ending.converged = false;
        }
        ending.iterations += static_cast<int>(control.last_step());
        add(unknowns, correction);
        left = residual(system, right_hand_side, unknowns);
        to_solve = left;
        system.precondition(seen, to_solve);
        const double before = size;
        size = seen.l2_norm();
        ending.converged = ending.converged && size < reserve * before;
        if (!ending.converged)
            break;
    }
    add(unknowns, seen); // as the preconditioner sees what is left: the solution gets better for nothing
    return ending;
}

template <class T>
void product(const SaddlePoint &matrix, const DivergenceRows<T> &divergence, std::span<const T> u, std::span<const T> p,
             std::span<T> force, std::span<T> imbalance) {
    matrix.solver.multiply(u, force);
    multiply(matrix.pressure.compliance, p, imbalance, matrix.lanes);
    divergence.add_products(u, p, force, imbalance, matrix.lanes);
}

} // namespace

void SaddlePoint::apply(std::span<const double> u, std::span<const double> p, std::span<double> force,
                        std::span<double> imbalance) const {
    product(*this, pressure.divergence, u, p, force, imbalance);
}

void SaddlePoint::apply(std::span<const float> u, std::span<const float> p, std::span<float> force,
                        std::span<float> imbalance) const {
    product(*this, single_precision_divergence, u, p, force, imbalance);
}

/// Solves [K D^T; D -C] [u; p] = [f; g] by generalised minimal residuals, preconditioned by the lower block triangle
/// with inverses, exact or not, of K and of the norm of the pressure: that takes a third of the iterations that minimal
/// residuals take with the diagonal alone. What is left in each column is measured as the preconditioner sees it, which
/// is nearly the error: in parts of the displacements and pressures of the whole load.
/// (Y. Saad and M. H. Schultz 1986, SIAM J. Sci. Stat. Comput. 7(3); H. C. Elman, D. J. Silvester and A. J. Wathen
/// 2014, Finite Elements and Fast Iterative Solvers)
/// @param inverse         of K, set up for the unknowns that are free
/// @param norm            of the pressure, factored with nothing constrained
/// @param tolerance       of each column
/// @param max_iterations  after how many it gives up
/// @param whole           the load, that tolerances are in parts of
/// @param left            what of it is to be solved for: all, or what a first guess leaves
/// @param u               shape (3 n, lanes), zero where not free
/// @param p               shape (m, lanes)
SaddlePointEnding solve(const SaddlePoint &matrix, Preconditioner &inverse, ConstrainedSolver &norm, double tolerance,
                        int max_iterations, const SaddlePointLoad &whole, const SaddlePointLoad &left,
                        std::span<double> u, std::span<double> p) {
    Scaled system{matrix, inverse, norm, u.size(), p.size(), std::vector<double>(matrix.lanes, 1.0)};
    Vector right_hand_side(u.size() + p.size()), unknowns(u.size() + p.size());
    const auto fill = [&](const SaddlePointLoad &load) {
        std::ranges::copy(load.f, right_hand_side.begin());
        std::ranges::copy(load.g, right_hand_side.begin() + u.size());
    };
    fill(whole);
    KrylovVector seen(right_hand_side.size()), to_see(right_hand_side.size());
    to_see = right_hand_side;
    system.precondition(seen, to_see);
    unknowns = seen;

    // Displacements and pressures of every column begin at one: what is left of all together is no less than of each.
    const auto first_u = part(unknowns, 0, u.size()), first_p = part(unknowns, u.size(), p.size());
    auto size = roots_of(dots(first_u, first_u, matrix.lanes));
    const auto size_of_p = roots_of(dots(first_p, first_p, matrix.lanes));
    auto per_size = size;
    int num_ones = 0;
    for (int c = 0; c < matrix.lanes; ++c) {
        num_ones += (size[c] > 0.0 ? 1 : 0) + (size_of_p[c] > 0.0 ? 1 : 0);
        if (size[c] > 0.0 && size_of_p[c] > 0.0)
            system.unit[c] = size_of_p[c] / size[c];
        else if (!(size[c] > 0.0))
            size[c] = size_of_p[c]; // loads that only change volumes
        per_size[c] = size[c] > 0.0 ? 1.0 / size[c] : 0.0;
    }
    unknowns = 0.0;
    fill(left);
    scale(per_size, {right_hand_side.begin(), right_hand_side.size()});
    const auto ending =
        iterate(system, std::sqrt(num_ones), seen_of_tolerance * tolerance, max_iterations, right_hand_side, unknowns);
    scale(system.unit, first_p);
    scale(size, {unknowns.begin(), unknowns.size()});
    std::ranges::copy(first_u, u.begin());
    std::ranges::copy(first_p, p.begin());
    return ending;
}

namespace {

/// Columns side by side; lanes that none needs are zero.
std::vector<double> together(std::span<const Conditions> conditions, int lanes,
                             const std::function<double(const Conditions &, std::size_t)> &value) {
    const auto num_rows = conditions.front().load.size();
    std::vector<double> result(lanes * num_rows, 0.0);
    for (std::size_t i = 0; i < num_rows; ++i)
        for (std::size_t c = 0; c < conditions.size(); ++c)
            result[lanes * i + c] = value(conditions[c], i);
    return result;
}

/// Enough for the solution on the coarse mesh, which is wrong by percents as it is.
constexpr double guess_tolerance = 1e-2;

std::vector<double> negative(std::vector<double> values) {
    std::ranges::transform(values, values.begin(), std::negate<>());
    return values;
}

/// (lanes) norm of each column
std::vector<double> size_of(const SaddlePointLoad &load, int lanes) {
    auto squares = dots(load.f, load.f, lanes);
    std::ranges::transform(squares, dots(load.g, load.g, lanes), squares.begin(), std::plus<>());
    return roots_of(squares);
}

} // namespace

/// Displacements and pressures of several columns, and the loads that they belong to.
struct MixedSolver::State {
    FreeUnknowns free;
    std::vector<std::size_t> constrained; ///< entries of displacements that are not free
    std::vector<double> load;             ///< (3 n, lanes)
    std::vector<double> u, p;             ///< (3 n, lanes), (m, lanes)
    /// (lanes) size of what is out of balance, of forces and volumes, where only what is constrained has moved
    std::vector<double> first_size;
    SaddlePointEnding ending{};
};

struct MixedSolver::Impl {
    Impl(const ElasticSystem &k, ChosenSolver &inverse_of_k, const PressureSystem &p, double relative)
        : system(k), solver(inverse_of_k), pressure(p), single_precision_divergence(rounded(p.divergence)),
          tolerance(relative), norm(pressure.norm) {
        const std::vector<double> all_free(static_cast<std::size_t>(pressure.num_pressures()),
                                           std::numeric_limits<double>::quiet_NaN());
        norm.factorise(all_free);
    }

    std::optional<State> approach(std::span<const Conditions> conditions, double to) const;
    std::optional<State> first_guess(std::span<const Conditions> conditions) const;

    /// Residual of u and p; nothing where unknowns are constrained.
    SaddlePointLoad left(const State &state, std::span<const double> u, std::span<const double> p) const {
        SaddlePointLoad out{std::vector<double>(u.size()), std::vector<double>(p.size())};
        matrix(state).apply(u, p, out.f, out.g);
        for (std::size_t i = 0; i < u.size(); ++i)
            out.f[i] = state.load[i] - out.f[i];
        zero(state.constrained, out.f);
        out.g = negative(std::move(out.g));
        return out;
    }
    SaddlePoint matrix(const State &state) const {
        return {solver, pressure, single_precision_divergence, state.free.lanes(), state.constrained};
    }

    const ElasticSystem &system;
    ChosenSolver &solver;
    const PressureSystem &pressure;
    DivergenceRows<float> single_precision_divergence;
    double tolerance;
    mutable ConstrainedSolver norm; ///< nothing is constrained
    MixedSolver *coarse = nullptr;  ///< and how to come from there, or nothing
    NestedIteration nested{};
};

MixedSolver::MixedSolver(const ElasticSystem &system, ChosenSolver &solver, const PressureSystem &pressure,
                         double tolerance)
    : impl_(std::make_unique<Impl>(system, solver, pressure, tolerance)) {}
MixedSolver::MixedSolver(const ElasticSystem &system, ChosenSolver &solver, const PressureSystem &pressure,
                         double tolerance, MixedSolver &coarse, NestedIteration nested)
    : impl_(std::make_unique<Impl>(system, solver, pressure, tolerance)) {
    impl_->coarse = &coarse;
    impl_->nested = std::move(nested);
}
MixedSolver::~MixedSolver() = default;
MixedSolver::MixedSolver(MixedSolver &&) noexcept = default;
MixedSolver &MixedSolver::operator=(MixedSolver &&) noexcept = default;

std::size_t MixedSolver::max_columns() const {
    return impl_->solver.max_columns();
}

/// The solution on the coarse mesh, nothing if there is none.
std::optional<MixedSolver::State> MixedSolver::Impl::first_guess(std::span<const Conditions> conditions) const {
    if (!coarse)
        return std::nullopt;
    const auto num_coarse = 3 * nested.displacement.fine_node.size();
    std::vector<std::vector<double>> prescribed, load;
    for (const auto &column : conditions) {
        auto &in_column = prescribed.emplace_back();
        for (const int node : nested.displacement.fine_node)
            in_column.insert(in_column.end(), &column.prescribed[3 * node], &column.prescribed[3 * node] + 3);
        nested.displacement.restrict_to(column.load, load.emplace_back(num_coarse));
    }
    std::vector<Conditions> on_coarse;
    for (std::size_t c = 0; c < conditions.size(); ++c)
        on_coarse.push_back({prescribed[c], load[c]});
    return coarse->impl_->approach(on_coarse, guess_tolerance);
}

/// Iterations on both at once.
/// @return nothing if the conditions do not fix the solution
std::optional<MixedSolver::State> MixedSolver::Impl::approach(std::span<const Conditions> conditions, double to) const {
    const auto guess = first_guess(conditions);
    std::vector<std::span<const double>> prescribed;
    for (const auto &column : conditions)
        prescribed.push_back(column.prescribed);
    const auto free = free_unknowns(prescribed);
    auto &inverse = solver.inverse();
    if (!inverse.set_up(free))
        return std::nullopt;

    const int lanes = free.lanes();
    State state{
        .free = free,
        .constrained = constrained_entries(free),
        .load = together(conditions, lanes, [](const auto &column, auto i) { return column.load[i]; }),
        .u = together(
            conditions, lanes,
            [](const auto &column, auto i) { return std::isnan(column.prescribed[i]) ? 0.0 : column.prescribed[i]; }),
        .p = std::vector<double>(static_cast<std::size_t>(lanes) * pressure.num_pressures(), 0.0),
        .first_size = {},
    };
    const auto whole = left(state, state.u, state.p);
    state.first_size = size_of(whole, lanes);
    if (guess) {
        std::vector<double> inside(state.u.size(), 0.0);
        nested.displacement.add_prolonged(guess->u, inside);
        zero(state.constrained, inside);
        for (std::size_t i = 0; i < inside.size(); ++i)
            state.u[i] += inside[i];
        state.p = nested.prolonged_pressure(guess->p, lanes);
    }
    std::vector<double> more_u(state.u.size()), more_p(state.p.size());
    state.ending = fem_reference::solve(matrix(state), inverse, norm, to, max_iterations, whole,
                                        guess ? left(state, state.u, state.p) : whole, more_u, more_p);
    for (std::size_t i = 0; i < more_u.size(); ++i)
        state.u[i] += more_u[i];
    for (std::size_t q = 0; q < more_p.size(); ++q)
        state.p[q] += more_p[q];
    return state;
}

ConstrainedSolution MixedSolver::solve(std::span<const double> prescribed, std::span<const double> load) {
    return std::move(solve(std::array{Conditions{prescribed, load}}).front());
}

std::vector<ConstrainedSolution> MixedSolver::solve(std::span<const Conditions> conditions) {
    std::vector<ConstrainedSolution> solutions(conditions.size());
    auto state = impl_->approach(conditions, impl_->tolerance);
    if (!state)
        return solutions;
    const int lanes = state->free.lanes();
    auto &u = state->u;
    balance(impl_->system, state->free, impl_->left(*state, u, state->p).f, u);

    std::vector<double> residual(u.size()), imbalance(state->p.size());
    impl_->matrix(*state).apply(u, state->p, residual, imbalance);
    for (std::size_t i = 0; i < u.size(); ++i)
        residual[i] -= state->load[i];
    SaddlePointLoad where_free{residual, std::move(imbalance)};
    zero(state->constrained, where_free.f);
    const auto last = size_of(where_free, lanes);
    const auto internal_work = dots(u, residual, lanes), external_work = dots(u, state->load, lanes);
    auto displacements = separated(u, lanes, conditions.size()),
         residuals = separated(residual, lanes, conditions.size());
    for (std::size_t c = 0; c < conditions.size(); ++c)
        solutions[c] = {.unique = true,
                        .displacement = std::move(displacements[c]),
                        .residual = std::move(residuals[c]),
                        .energy = 0.5 * (internal_work[c] + external_work[c]),
                        .converged = state->ending.converged,
                        .iterations = state->ending.iterations,
                        .relative_residual = state->first_size[c] > 0.0 ? last[c] / state->first_size[c] : 0.0};
    return solutions;
}

std::string MixedSolver::description(const ConstrainedSolution &solution) const {
    return fmt::format("GMRES, {} iterations, {} and the mass of the pressure", solution.iterations,
                       impl_->solver.inverse().name());
}

} // namespace livermark::fem_reference
