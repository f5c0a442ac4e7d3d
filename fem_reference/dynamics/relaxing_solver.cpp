#include "fem_reference/dynamics/relaxing_solver.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <utility>
#include <vector>

#include "core/events.hpp"
#include "core/relaxation.hpp"
#include "core/stopwatch.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::fem_reference {

namespace {

/// A linear body that relaxes, in m coordinates c of its displacement u = sum_j c_j b_j:
///   V c + D (remaining c + sum_k w_k) = factor(t) f,   dw_k/dt + w_k / tau_k = g_k dc/dt,
/// with V and D the volumetric and the deviatoric part of its stiffness, and w_k what the branches remember. Both are
/// positive semidefinite, so that the reduced body is one itself: it stores energy and dissipates it.
struct ReducedBody {
    Eigen::MatrixXd volumetric, deviatoric; ///< (m, m) b_i^T V b_j and b_i^T D b_j [J]
    Eigen::VectorXd load;                   ///< (m) work of the whole given loads on each b_j [J]
    /// Whether b_0 is where the whole prescribed displacement or depth is, and all others are zero there: c_0 is the
    /// factor of the history then, and what that takes is a reaction.
    bool is_moved = false;
};

/// A time.
struct ReducedRecord {
    Eigen::VectorXd coordinates;           ///< (m) c
    Eigen::VectorXd relaxed;               ///< (m) remaining c + sum_k w_k: what D is multiplied by
    std::vector<Eigen::VectorXd> branches; ///< (B) of (m) w_k
    double stored_energy = 0.0;            ///< [J]
    double work = 0.0;              ///< done so far by all that drives the body, trapezoidal rule over the steps [J]
    double dissipated_energy = 0.0; ///< in all branches so far [J]
};

/// A step length, and what is factored for it.
class ReducedStep {
  public:
    ReducedStep(const ReducedBody &body, const core::PronySeries &relaxation, double length)
        : body_(body), relaxation_(relaxation), branches_(core::branch_steps(relaxation, length)),
          first_(body.is_moved ? 1 : 0), num_free_(body.load.size() - first_),
          matrix_(body.volumetric + core::instant_part(relaxation, branches_) * body.deviatoric),
          factor_(matrix_.bottomRightCorner(num_free_, num_free_)) {}

    void advance(ReducedRecord &record, double factor) const;

  private:
    const ReducedBody &body_;
    const core::PronySeries &relaxation_;
    std::vector<core::BranchStep> branches_;
    Eigen::Index first_, num_free_;
    Eigen::MatrixXd matrix_; ///< with the stiffness of the step
    Eigen::LDLT<Eigen::MatrixXd> factor_;
};

void ReducedStep::advance(ReducedRecord &record, double factor) const {
    auto &memories = record.branches;
    const Eigen::VectorXd before = record.coordinates;
    const Eigen::VectorXd force_before = body_.volumetric * before + body_.deviatoric * record.relaxed;
    Eigen::VectorXd remembered = Eigen::VectorXd::Zero(before.size());
    for (std::size_t k = 0; k < branches_.size(); ++k)
        remembered += branches_[k].fade * memories[k] - branches_[k].gain * before;
    Eigen::VectorXd now = Eigen::VectorXd::Zero(before.size());
    if (body_.is_moved)
        now[0] = factor;
    const Eigen::VectorXd left = factor * body_.load - body_.deviatoric * remembered - matrix_ * now;
    if (num_free_ > 0)
        now.tail(num_free_) = factor_.solve(left.tail(num_free_));

    const Eigen::VectorXd change = now - before;
    record.coordinates = now;
    record.relaxed = relaxation_.remaining() * now;
    record.stored_energy =
        0.5 * now.dot(body_.volumetric * now) + 0.5 * relaxation_.remaining() * now.dot(body_.deviatoric * now);
    for (std::size_t k = 0; k < branches_.size(); ++k) {
        auto &memory = memories[k];
        record.dissipated_energy +=
            branches_[k].dissipated(memory.dot(body_.deviatoric * memory), memory.dot(body_.deviatoric * change),
                                    change.dot(body_.deviatoric * change));
        memory = branches_[k].fade * memory + branches_[k].gain * change;
        record.stored_energy += branches_[k].stored(memory.dot(body_.deviatoric * memory));
        record.relaxed += memory;
    }
    const Eigen::VectorXd force = body_.volumetric * now + body_.deviatoric * record.relaxed;
    record.work += 0.5 * (force_before + force).dot(change);
}

/// Follows a history, in which u is linear over steps: the error is of second order in them, and none where stresses
/// grow linearly.
/// @param steps_per_record  of equal length between two times, at least 1
/// @return shape (K)
std::vector<ReducedRecord> follow(const ReducedBody &body, const core::SlowHistory &history, int steps_per_record) {
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(body.load.size());
    ReducedRecord now{.coordinates = zero,
                      .relaxed = zero,
                      .branches = std::vector<Eigen::VectorXd>(history.relaxation.moduli.size(), zero)};
    std::vector<ReducedRecord> records{now};
    for (int n = 1; n < history.num_records(); ++n) {
        const ReducedStep step(body, history.relaxation, (history.times[n] - history.times[n - 1]) / steps_per_record);
        for (int part = 1; part <= steps_per_record; ++part)
            step.advance(now, std::lerp(history.factors[n - 1], history.factors[n],
                                        static_cast<double>(part) / steps_per_record));
        records.push_back(now);
    }
    return records;
}

/// A displacement that the motion is made of, and what holds the body in it.
struct Shape {
    std::vector<double> displacement;           ///< (3 n) [m]
    std::vector<double> deviatoric, volumetric; ///< (3 n) D b and V b [N]
    double energy() const { return dot(displacement, deviatoric) + dot(displacement, volumetric); }
};

/// Sums of forces at the unknowns of each constraint.
/// @return shape (P) [N]
std::vector<core::Vector3> sums(const std::vector<int> &constraint, const std::vector<double> &force,
                                std::size_t num_constraints) {
    std::vector<core::Vector3> result(num_constraints, core::Vector3::Zero());
    for (std::size_t dof = 0; dof < force.size(); ++dof)
        if (constraint[dof] >= 0)
            result[constraint[dof]][dof % 3] += force[dof];
    return result;
}

/// sum_j c_j b_j
std::vector<double> combined(const std::vector<Shape> &shapes, const Eigen::VectorXd &coordinates) {
    std::vector<double> sum(shapes.front().displacement.size(), 0.0);
    for (std::size_t j = 0; j < shapes.size(); ++j)
        add_scaled(coordinates[static_cast<Eigen::Index>(j)], shapes[j].displacement, sum);
    return sum;
}

/// A part of the shear moduli other than all, of which D and V can be told apart.
double other_part(double remaining) {
    return remaining < 1.0 ? remaining : 0.5;
}

/// Parts of the shear moduli in the order in which solutions are asked for: 1, remaining(), then those in the middle
/// of the logarithms of the ones before.
double nth_part(int number, double remaining) {
    if (number < 2)
        return number == 0 ? 1.0 : remaining;
    double step = 0.5; // 1/2, 1/4, 3/4, 1/8, 3/8, ...
    int first = 2;
    for (; first + static_cast<int>(std::lround(0.5 / step)) <= number; step *= 0.5)
        first += static_cast<int>(std::lround(0.5 / step));
    return std::pow(remaining, step * (1.0 + 2.0 * (number - first)));
}

} // namespace

struct RelaxingSolver::Impl {
    /// The elements at a part of their shear moduli.
    ScaledBulk &at(double part) {
        auto &found = at_part[part];
        if (!found)
            found = coarse ? std::make_unique<ScaledBulk>(*body, elements.matrices(), elements.displacement_solver(),
                                                          choice, part, coarse->at(part), tolerance, parent)
                           : std::make_unique<ScaledBulk>(*body, elements.matrices(), elements.displacement_solver(),
                                                          choice, part);
        return *found;
    }

    std::optional<ConstrainedSolution> elastic(const DofConditions &conditions, double part);
    void split_forces(Shape &shape, double remaining);
    RelaxedState fill(core::Solution &solution, const core::LoadCase &load_case, const DofConditions &conditions,
                      const std::vector<Shape> &shapes, bool is_moved, int steps_per_record) const;
    core::History motion(const core::LoadCase &load_case, RelaxedState start);

    std::shared_ptr<const core::Body> body;
    StaticSolver &elements;
    SolverChoice choice;
    Impl *coarse = nullptr;
    double tolerance = 0.0; ///< of iterations on a refined body
    std::vector<int> parent{};
    std::map<double, std::unique_ptr<ScaledBulk>> at_part{};
};

RelaxingSolver::RelaxingSolver(std::shared_ptr<const core::Body> body, StaticSolver &elements, SolverChoice choice)
    : impl_(new Impl{.body = std::move(body), .elements = elements, .choice = choice}) {}
RelaxingSolver::RelaxingSolver(std::shared_ptr<const core::Body> body, StaticSolver &elements, SolverChoice choice,
                               RelaxingSolver &coarse, double tolerance, std::span<const int> parent)
    : impl_(new Impl{.body = std::move(body),
                     .elements = elements,
                     .choice = choice,
                     .coarse = coarse.impl_.get(),
                     .tolerance = tolerance,
                     .parent = {parent.begin(), parent.end()}}) {}
RelaxingSolver::~RelaxingSolver() = default;
RelaxingSolver::RelaxingSolver(RelaxingSolver &&) noexcept = default;
RelaxingSolver &RelaxingSolver::operator=(RelaxingSolver &&) noexcept = default;

/// The displacement of the whole load at a part of the shear moduli, at the depth where a place presses.
/// @return nothing where the body is free to move
std::optional<ConstrainedSolution> RelaxingSolver::Impl::elastic(const DofConditions &conditions, double part) {
    auto load = conditions.load;
    for (double &force : load)
        force /= part;
    auto found = at(part).solve(conditions.prescribed, load);
    if (!found.unique)
        return std::nullopt;
    if (conditions.press_depth != 0.0) {
        const double factor = conditions.press_depth / dot(found.displacement, conditions.load);
        for (double &value : found.displacement)
            value *= factor;
    }
    return found;
}

/// Finds both from the forces that hold the body at two ratios of its moduli.
void RelaxingSolver::Impl::split_forces(Shape &shape, double remaining) {
    const double other = other_part(remaining);
    shape.deviatoric = at(1.0).force(shape.displacement);
    shape.volumetric = at(other).force(shape.displacement);
    add_scaled(-1.0, shape.deviatoric, shape.volumetric);
    for (double &force : shape.volumetric)
        force /= 1.0 / other - 1.0;
    add_scaled(-1.0, shape.volumetric, shape.deviatoric);
}

/// Follows the history in the space of the shapes.
/// @return where it ends
RelaxedState RelaxingSolver::Impl::fill(core::Solution &solution, const core::LoadCase &load_case,
                                        const DofConditions &conditions, const std::vector<Shape> &shapes,
                                        bool is_moved, int steps_per_record) const {
    const auto num_shapes = static_cast<Eigen::Index>(shapes.size());
    const bool is_pressed = conditions.press_depth != 0.0;
    ReducedBody reduced;
    reduced.volumetric.resize(num_shapes, num_shapes);
    reduced.deviatoric.resize(num_shapes, num_shapes);
    reduced.load = Eigen::VectorXd::Zero(num_shapes);
    reduced.is_moved = is_moved;
    for (Eigen::Index i = 0; i < num_shapes; ++i) {
        for (Eigen::Index j = 0; j < num_shapes; ++j) {
            reduced.volumetric(i, j) = dot(shapes[i].displacement, shapes[j].volumetric);
            reduced.deviatoric(i, j) = dot(shapes[i].displacement, shapes[j].deviatoric);
        }
        if (!is_pressed) // what presses is a reaction to its depth
            reduced.load[i] = dot(shapes[i].displacement, conditions.load);
    }
    const auto &history = *load_case.slow_history;
    const auto records = follow(reduced, history, steps_per_record);

    const auto num_constraints = static_cast<std::size_t>(load_case.num_constraints());
    std::vector<std::vector<core::Vector3>> deviatoric, volumetric;
    for (const auto &shape : shapes) {
        deviatoric.push_back(sums(conditions.constraint, shape.deviatoric, num_constraints));
        volumetric.push_back(sums(conditions.constraint, shape.volumetric, num_constraints));
    }
    const auto loads = sums(conditions.constraint, conditions.load, num_constraints);
    const auto resultants = core::press_resultants(load_case, body->mesh);
    const auto &mesh_node = elements.matrices().system.mesh_node;
    for (std::size_t k = 0; k < records.size(); ++k) {
        const auto &record = records[k];
        const double held =
            reduced.volumetric.row(0).dot(record.coordinates) + reduced.deviatoric.row(0).dot(record.relaxed);
        const double press = is_pressed ? held / conditions.press_depth : 0.0; // [N]
        auto &point = solution.path.emplace_back();
        point.reaction = resultants;
        for (std::size_t p = 0; p < num_constraints; ++p) {
            point.reaction[p] *= press;
            point.reaction[p] -= (is_pressed ? press : history.factors[k]) * loads[p];
            for (Eigen::Index j = 0; j < num_shapes; ++j)
                point.reaction[p] += record.coordinates[j] * volumetric[j][p] + record.relaxed[j] * deviatoric[j][p];
        }
        std::vector<core::Vector3> displacement(mesh_node.size(), core::Vector3::Zero());
        for (std::size_t node = 0; node < mesh_node.size(); ++node)
            for (Eigen::Index j = 0; j < num_shapes; ++j)
                displacement[node] += record.coordinates[j] *
                                      Eigen::Map<const core::Vector3>(&shapes[j].displacement[3 * mesh_node[node]]);
        for (const auto &vector : displacement)
            point.displacement.push_back(vector.cast<float>());
        point.strain_energy = record.stored_energy;
        point.work = record.work;
        point.dissipated_energy = record.dissipated_energy;
        if (static_cast<int>(k) == history.whole_load_record()) {
            solution.displacement = std::move(displacement);
            solution.reaction = point.reaction;
            solution.strain_energy = record.stored_energy;
            if (!is_pressed && load_case.acceleration.isZero(0.0))
                solution.load_work = reduced.load.dot(record.coordinates);
        }
    }
    RelaxedState end{.displacement = combined(shapes, records.back().coordinates), .branches = {}};
    for (const auto &branch : records.back().branches)
        end.branches.push_back(combined(shapes, branch));
    return end;
}

core::History RelaxingSolver::Impl::motion(const core::LoadCase &load_case, RelaxedState start) {
    const double part = other_part(load_case.slow_history->relaxation.remaining());
    const auto &system = elements.matrices().system;
    const SplitStiffness stiffness(system.stiffness, at(part).system().stiffness, part);
    return release_relaxed(*body, system, stiffness, load_case, std::move(start));
}

core::Solution RelaxingSolver::solve(const core::LoadCase &load_case, int steps_per_record) {
    auto &impl = *impl_;
    check_facets(load_case, impl.body->mesh);
    const auto &matrices = impl.elements.matrices();
    const auto start = core::Clock::now();
    const auto conditions = dof_conditions(load_case, matrices.system);
    const double remaining = load_case.slow_history->relaxation.remaining();
    const bool is_moved = conditions.press_depth != 0.0 || std::ranges::any_of(conditions.prescribed, [](double value) {
                              return value < 0.0 || value > 0.0; // not NaN
                          });
    core::Solution solution;
    solution.degrees_of_freedom = static_cast<std::int64_t>(conditions.load.size()) + matrices.pressure.num_pressures();
    solution.setup_seconds = impl.elements.assembly_seconds();
    std::vector<Shape> shapes;
    double first_energy = 0.0;
    int num_solutions = 0;
    for (bool is_new = true; is_new && num_solutions < most_solutions; ++num_solutions) {
        const double part = nth_part(num_solutions, remaining);
        if (num_solutions > 0 && part == 1.0)
            break; // nothing relaxes
        auto found = impl.elastic(conditions, part);
        if (!found || !found->converged) {
            leave_unsolved(solution, impl.body->mesh, load_case);
            solution.status = core::SolutionStatus::not_converged;
            solution.message = found ? "the iterations stopped before they came to their tolerance; use the direct "
                                       "solver"
                                     : "the prescribed displacements leave the body, or a part of it, free to move as "
                                       "a rigid body; constrain all six rigid body motions";
            return solution;
        }
        impl.at(part).forget_factor();
        Shape shape{.displacement = std::move(found->displacement), .deviatoric = {}, .volumetric = {}};
        if (!shapes.empty() && is_moved)
            add_scaled(-1.0, shapes.front().displacement, shape.displacement); // zero where it is moved
        for (int pass = 0; pass < 2; ++pass)                                   // once more, against rounding
            for (std::size_t i = is_moved ? 1 : 0; i < shapes.size(); ++i) {
                const double part_of =
                    dot(shape.displacement, shapes[i].deviatoric) + dot(shape.displacement, shapes[i].volumetric);
                add_scaled(-part_of / shapes[i].energy(), shapes[i].displacement, shape.displacement);
            }
        impl.split_forces(shape, remaining);
        const double energy = shape.energy();
        if (shapes.empty())
            first_energy = energy;
        const double least = std::max(enough, 3.0 * impl.tolerance);
        is_new = energy > least * least * first_energy;
        if (is_new || shapes.empty())
            shapes.push_back(std::move(shape));
    }
    auto end = impl.fill(solution, load_case, conditions, shapes, is_moved, steps_per_record);
    solution.solve_seconds = core::seconds_since(start);
    if (load_case.release && matrices.pressure.num_pressures() == 0)
        solution.history = impl.motion(load_case, std::move(end));
    solution.solver = fmt::format("Galerkin's method on {} of {} elastic solutions", shapes.size(), num_solutions);
    return solution;
}

} // namespace livermark::fem_reference
