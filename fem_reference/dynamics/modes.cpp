#include "fem_reference/dynamics/modes.hpp"

#include <Spectra/SymGEigsShiftSolver.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::fem_reference {

SymmetricMatrix consistent_mass(const core::Body &body, const ElasticSystem &system) {
    auto mass = zero_of_blocks(system.stiffness.rows);
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    const int num_local = system.nodes_per_cell;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const double cell_mass = body.materials[body.mesh.region[t]].density * volumes[t];
        const int *const nodes = system.cell_nodes.data() + t * num_local;
        for (int a = 0; a < num_local; ++a) {
            const auto row = mass.column.begin() + mass.row_start[nodes[a]];
            const auto row_end = mass.column.begin() + mass.row_start[nodes[a] + 1];
            for (int b = 0; b < num_local; ++b)
                mass.value[std::lower_bound(row, row_end, nodes[b]) - mass.column.begin()] +=
                    cell_mass * system.reference_mass[a * num_local + b];
        }
    }
    return mass;
}

void multiply_mass(const SymmetricMatrix &mass, std::span<const double> x, std::span<double> out) {
    for (int a = 0; a < mass.num_rows(); ++a) {
        core::Vector3 sum = core::Vector3::Zero();
        for (int k = mass.row_start[a]; k < mass.row_start[a + 1]; ++k)
            sum += mass.value[k] * core::Vector3::Map(&x[3 * mass.column[k]]);
        core::Vector3::Map(&out[3 * a]) = sum;
    }
}

SymmetricMatrix combine(double k, SymmetricMatrix stiffness, double m, const SymmetricMatrix &mass) {
    for (double &value : stiffness.value)
        value *= k;
    for (int a = 0; a < mass.num_rows(); ++a)
        for (int i = 0; i < 3; ++i) {
            int entry = stiffness.row_start[3 * a + i] + i;
            for (int block = mass.row_start[a]; block < mass.row_start[a + 1]; ++block, entry += 3)
                stiffness.value[entry] += m * mass.value[block];
        }
    return stiffness;
}

double dot(std::span<const double> a, std::span<const double> b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += a[i] * b[i];
    return sum;
}

void add_scaled(double factor, std::span<const double> x, std::span<double> out) {
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] += factor * x[i];
}

namespace {

/// Lanczos's method finds the copies of a repeated frequency one after the other, by rounding; a few more than are
/// asked for keep the last copy of the last one from being left out.
constexpr int num_spare = 5;
/// Tolerance of 1 / omega^2.
constexpr double relative_tolerance = 1e-13;
constexpr int most_restarts = 1000;

/// Map between vectors of all unknowns and of the free ones.
struct UnconstrainedUnknowns {
    explicit UnconstrainedUnknowns(std::span<const double> prescribed) : num_all(prescribed.size()) {
        for (std::size_t i = 0; i < num_all; ++i)
            if (std::isnan(prescribed[i]))
                free_dofs.push_back(i);
    }

    void expand(const double *free, std::vector<double> &all) const {
        all.assign(num_all, 0.0);
        for (std::size_t i = 0; i < free_dofs.size(); ++i)
            all[free_dofs[i]] = free[i];
    }
    void restrict_to_free(const std::vector<double> &all, double *free) const {
        for (std::size_t i = 0; i < free_dofs.size(); ++i)
            free[i] = all[free_dofs[i]];
    }
    Eigen::Index num_free() const { return static_cast<Eigen::Index>(free_dofs.size()); }

    std::size_t num_all;
    std::vector<std::size_t> free_dofs;
};

/// y = K^-1 x, as Spectra asks for it.
class InverseStiffness {
  public:
    using Scalar = double;
    InverseStiffness(ConstrainedSolver &solver, const UnconstrainedUnknowns &unknowns)
        : solver_(solver), unknowns_(unknowns) {}

    Eigen::Index rows() const { return unknowns_.num_free(); }
    Eigen::Index cols() const { return unknowns_.num_free(); }
    void set_shift(double) {} // it is zero, and the factor is there
    void perform_op(const double *x, double *y) const {
        unknowns_.expand(x, load_);
        u_.resize(load_.size());
        solver_.solve_constrained(load_, u_);
        unknowns_.restrict_to_free(u_, y);
    }

  private:
    ConstrainedSolver &solver_;
    const UnconstrainedUnknowns &unknowns_;
    mutable std::vector<double> load_, u_;
};

/// y = M x, as Spectra asks for it.
class Mass {
  public:
    using Scalar = double;
    Mass(const SymmetricMatrix &mass, const UnconstrainedUnknowns &unknowns) : mass_(mass), unknowns_(unknowns) {}

    Eigen::Index rows() const { return unknowns_.num_free(); }
    Eigen::Index cols() const { return unknowns_.num_free(); }
    void perform_op(const double *x, double *y) const {
        unknowns_.expand(x, in_);
        out_.resize(in_.size());
        multiply_mass(mass_, in_, out_);
        unknowns_.restrict_to_free(out_, y);
    }

  private:
    const SymmetricMatrix &mass_;
    const UnconstrainedUnknowns &unknowns_;
    mutable std::vector<double> in_, out_;
};

/// phi^T M phi = 1, and of the two signs always the same.
void normalise(std::vector<double> &shape, const SymmetricMatrix &mass) {
    std::vector<double> momentum(shape.size());
    multiply_mass(mass, shape, momentum);
    const double largest = *std::ranges::max_element(shape, {}, [](double entry) { return std::abs(entry); });
    const double scale = std::copysign(1.0 / std::sqrt(dot(shape, momentum)), largest);
    for (double &entry : shape)
        entry *= scale;
}

} // namespace

EigenPairs lowest_eigenpairs(const SymmetricMatrix &stiffness, const SymmetricMatrix &mass,
                             std::span<const double> prescribed, int count) {
    const UnconstrainedUnknowns unknowns(prescribed);
    if (count < 1 || count >= unknowns.num_free())
        throw support::InputError("a body with " + std::to_string(unknowns.num_free()) +
                                  " free unknowns does not have the " + std::to_string(count) +
                                  " modes that are asked for; ask for at least one and for fewer than that");
    ConstrainedSolver solver(stiffness);
    if (!solver.factorise(prescribed))
        throw support::InputError("the constraints leave the body, or a part of it, free to move as a rigid body, so "
                                  "there are modes of zero frequency; constrain all six rigid body motions");
    InverseStiffness inverse_stiffness(solver, unknowns);
    Mass mass_operator(mass, unknowns);
    const auto num_wanted = std::min<Eigen::Index>(count + num_spare, unknowns.num_free() - 1);
    const auto num_vectors = std::min(2 * num_wanted + 10, unknowns.num_free());
    Spectra::SymGEigsShiftSolver<InverseStiffness, Mass, Spectra::GEigsMode::ShiftInvert> lanczos(
        inverse_stiffness, mass_operator, num_wanted, num_vectors, 0.0);
    lanczos.init();
    lanczos.compute(Spectra::SortRule::LargestMagn, most_restarts, relative_tolerance, Spectra::SortRule::SmallestAlge);
    if (lanczos.info() != Spectra::CompInfo::Successful)
        throw std::runtime_error("the modes did not converge in " + std::to_string(most_restarts) +
                                 " restarts of Lanczos's method");

    EigenPairs pairs;
    const Eigen::VectorXd squares = lanczos.eigenvalues();
    const Eigen::MatrixXd shapes = lanczos.eigenvectors();
    for (int mode = 0; mode < count; ++mode) {
        pairs.angular_frequency.push_back(std::sqrt(squares[mode]));
        auto &shape = pairs.shape.emplace_back();
        unknowns.expand(shapes.col(mode).data(), shape);
        normalise(shape, mass);
    }
    return pairs;
}

core::Modes lowest_modes(const core::Problem &problem, int degree, int count) {
    const auto start = core::Clock::now();
    const auto &mesh = problem.body->mesh;
    check_facets(problem.load_case, mesh);
    const auto system = assemble(*problem.body, degree, NodeOrder::of_mesh, problem.load_case.foundation);
    const auto mass = consistent_mass(*problem.body, system);
    const auto conditions = dof_conditions(problem.load_case, system);
    auto pairs = lowest_eigenpairs(compressed_rows(system.stiffness), mass, conditions.prescribed, count);

    core::Modes modes;
    modes.angular_frequency = std::move(pairs.angular_frequency);
    modes.shape.reserve(pairs.shape.size() * mesh.points.size());
    for (const auto &shape : pairs.shape)
        for (int node = 0; node < mesh.num_nodes(); ++node)
            modes.shape.emplace_back(core::Vector3::Map(&shape[3 * node]));
    modes.degrees_of_freedom = static_cast<std::int64_t>(conditions.prescribed.size());
    modes.seconds = core::seconds_since(start);
    return modes;
}

} // namespace livermark::fem_reference
