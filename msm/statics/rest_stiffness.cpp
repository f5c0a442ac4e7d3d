#include "msm/statics/rest_stiffness.hpp"

#include <Spectra/SymEigsShiftSolver.h>

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/own_process.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/statics/equilibrium.hpp"

namespace livermark::msm {

Eigen::VectorXd conjugate_gradients(const LinearMap &matrix, const LinearMap &inverse, const Eigen::VectorXd &b,
                                    double tolerance, int max_steps,
                                    const std::function<void(const Eigen::VectorXd &, const Eigen::VectorXd &)> &see) {
    const double enough = tolerance * b.norm();
    Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size()), residual = b;
    Eigen::VectorXd direction, preconditioned, last_residual;
    double decrease = 0.0;
    for (int step = 0; step < max_steps && residual.norm() > enough; ++step) {
        preconditioned = inverse(residual);
        if (step == 0)
            direction = preconditioned;
        else
            direction = preconditioned + preconditioned.dot(residual - last_residual) / decrease * direction;
        decrease = residual.dot(preconditioned);
        const Eigen::VectorXd image = matrix(direction);
        const double curvature = direction.dot(image);
        if (curvature <= 0.0)
            return step == 0 ? direction : x;
        const double length = decrease / curvature;
        last_residual = residual;
        x += length * direction;
        residual -= length * image;
        if (see)
            see(length * direction, length * image);
    }
    return x;
}

Eigen::VectorXd LimitedMemory::times(const LinearMap &first, Eigen::VectorXd vector) const {
    std::vector<double> part(pairs_.size());
    for (std::size_t p = pairs_.size(); p-- > 0;) {
        part[p] = pairs_[p].step.dot(vector) / pairs_[p].curvature;
        vector -= part[p] * pairs_[p].change;
    }
    vector = first(vector);
    for (std::size_t p = 0; p < pairs_.size(); ++p)
        vector += (part[p] - pairs_[p].change.dot(vector) / pairs_[p].curvature) * pairs_[p].step;
    return vector;
}

void LimitedMemory::learn(Eigen::VectorXd step, Eigen::VectorXd change) {
    const double curvature = step.dot(change);
    if (curvature <= 0.0)
        return;
    constexpr std::size_t most_remembered = 30;
    if (pairs_.size() == most_remembered)
        pairs_.pop_front();
    pairs_.push_back({std::move(step), std::move(change), curvature});
}

namespace {

/// Tolerance of the residual of the linear answer, where it is found step by step.
constexpr double linear_tolerance = 1e-10;
constexpr int most_conjugate_gradients = 300;

/// About what is on the diagonal of the stiffness, without the stiffness. The bounds of tetrahedra are four times it.
Eigen::VectorXd bound_of_diagonal(const ElasticBody &body, const Field &positions) {
    std::vector<Eigen::Matrix3d> blocks(positions.size(), Eigen::Matrix3d::Zero());
    for (const auto &term : body.terms)
        term->add_block_bound(to_unknowns(positions), blocks);
    Field diagonal;
    for (const auto &block : blocks)
        diagonal.emplace_back(0.25 * block.diagonal());
    return to_unknowns(diagonal);
}

} // namespace

RestStiffness::RestStiffness(const ElasticBody &body, const Field &positions) : extent_(core::extent(positions)) {
    auto stiffness = body.preconditioner ? body.preconditioner(1.0) : elastic_hessian(body, positions, Tangent::exact);
    stiffness_.swap(stiffness); // Eigen does not move sparse matrices
    if (!body.preconditioner)
        diagonal_ = stiffness_.diagonal();
    else {
        product_.emplace(body, positions);
        diagonal_ = bound_of_diagonal(body, positions);
    }
}

RestStiffness RestStiffness::shared(const ElasticBody &body, const Field &positions, Field common) {
    RestStiffness rest(body, positions);
    rest.common_ = std::move(common);
    return rest;
}

RestStiffness::RestStiffness(const ElasticBody &body, const Field &positions, const Field &prescribed)
    : RestStiffness(body, positions) {
    constrain(prescribed);
}

/// @return whether the stiffness of these components is positive definite
bool RestStiffness::factorise(const FreeComponents &rows) {
    if (rows_ == rows)
        return rows_are_definite_;
    rows_.reset(); // what follows may throw
    const auto start = core::Clock::now();
    const auto restricted = rows.restrict(stiffness_);
    factor_.order(restricted);
    rows_are_definite_ = factor_.factorise(restricted);
    rows_ = rows;
    factor_seconds_ = core::seconds_since(start);
    return rows_are_definite_;
}

void RestStiffness::constrain(const Field &prescribed) {
    if (constrains(prescribed))
        return;
    free_ = FreeComponents(prescribed);
    double square = 0.0;
    for (Eigen::Index c = 0; c < stiffness_.rows(); ++c)
        if (free_.is_free(c))
            square += diagonal_[c] * diagonal_[c];
    rounding_force_ = std::numeric_limits<double>::epsilon() * extent_ * std::sqrt(square);

    const FreeComponents common(common_);
    auto constrained =
        common_.empty() ? std::nullopt : support::unknowns_to_constrain(common.are_free(), free_.are_free());
    is_definite_ = constrained && factorise(common);
    if (!is_definite_) {
        constrained.reset();
        is_definite_ = factorise(free_);
    }
    const auto start = core::Clock::now();
    if (is_definite_)
        factor_.constrain(std::move(constrained).value_or(std::vector<int>{}));
    constrain_seconds_ = core::seconds_since(start);
}

Eigen::VectorXd RestStiffness::inverse_times(const Eigen::VectorXd &force) const {
    return inverse_times(force, &support::SparseCholesky::solve_single_precision);
}

Eigen::VectorXd RestStiffness::inverse_times(const Eigen::VectorXd &force, support::SparseCholesky::Solve solve) const {
    Eigen::VectorXd factored = Eigen::VectorXd::Zero(rows_->size());
    for (Eigen::Index c = 0; c < stiffness_.rows(); ++c)
        if (free_.is_free(c))
            factored[rows_->number(c)] = force[free_.number(c)];
    factored = (factor_.*solve)(factored);
    Eigen::VectorXd solution(force.size());
    for (Eigen::Index c = 0; c < stiffness_.rows(); ++c)
        if (free_.is_free(c))
            solution[free_.number(c)] = factored[rows_->number(c)];
    return solution;
}

bool RestStiffness::constrains(const Field &prescribed) const {
    return rows_ && free_ == FreeComponents(prescribed);
}

Field RestStiffness::solve(const Field &prescribed, const Field &force, LimitedMemory *memory) const {
    auto displacement = prescribed;
    for (auto &node : displacement)
        node = node.array().isNaN().select(core::Vector3::Zero(), node);
    if (!is_definite_)
        return displacement;
    const Eigen::VectorXd load = free_.gather(to_field(to_unknowns(force) - product(to_unknowns(displacement))));
    free_.add(displacement,
              product_ ? by_conjugate_gradients(load, memory) : inverse_times(load, &support::SparseCholesky::solve),
              1.0);
    return displacement;
}

Eigen::VectorXd RestStiffness::product(const Eigen::VectorXd &displacement) const {
    return product_ ? product_->times(displacement) : Eigen::VectorXd(stiffness_ * displacement);
}

Eigen::VectorXd RestStiffness::by_conjugate_gradients(const Eigen::VectorXd &load, LimitedMemory *memory) const {
    const Field nothing(static_cast<std::size_t>(stiffness_.rows() / 3), core::Vector3::Zero());
    const auto matrix = [&](const Eigen::VectorXd &displacement) {
        auto field = nothing;
        free_.add(field, displacement, 1.0);
        return free_.gather(to_field(product_->times(to_unknowns(field))));
    };
    return conjugate_gradients(
        matrix, [this](const auto &vector) { return inverse_times(vector); }, load, linear_tolerance,
        most_conjugate_gradients,
        [memory](const auto &step, const auto &change) {
            if (memory)
                memory->learn(step, change);
        });
}

namespace {

using Weights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// (3 K) mean displacements of places.
/// @param weights  shape (K, N)
Eigen::VectorXd means(const Weights &weights, const Field &displacement) {
    Eigen::VectorXd result(3 * weights.rows());
    for (Eigen::Index place = 0; place < weights.rows(); ++place) {
        core::Vector3 mean = core::Vector3::Zero();
        for (Weights::InnerIterator entry(weights, place); entry; ++entry)
            mean += entry.value() * displacement[entry.col()];
        result.segment<3>(3 * place) = mean;
    }
    return result;
}

NodalConditions conditions_at_rest(const core::Problem &problem, const std::vector<double> &node_mass) {
    auto conditions = nodal_conditions(problem, node_mass);
    for (auto &node : conditions.displacement)
        for (double &value : node)
            value = std::isnan(value) ? value : 0.0;
    conditions.press_depth = 0.0;
    return conditions;
}

} // namespace

core::Compliance compliance(const ElasticBody &body, const core::Problem &problem,
                            std::span<const core::InteriorPlace> places) {
    const auto &mesh = problem.body->mesh;
    const auto held = conditions_at_rest(problem, body.node_mass).displacement;
    const RestStiffness rest(body, mesh.points, held);
    if (!rest.is_definite())
        throw support::InputError(fmt::format("{}: load case '{}' leaves the body free to move, or its springs do not "
                                              "hold it up; constrain it, or leave this model out",
                                              problem.body->name, problem.load_case.name));
    const auto weights = core::nodal_weights(places, mesh);
    core::Compliance found;
    found.degrees_of_freedom = 3 * static_cast<std::int64_t>(mesh.points.size());
    found.matrix.resize(3 * weights.rows(), 3 * weights.rows());
    for (Eigen::Index column = 0; column < found.matrix.cols(); ++column) {
        Field force(mesh.points.size(), core::Vector3::Zero());
        for (Weights::InnerIterator entry(weights, column / 3); entry; ++entry)
            force[entry.col()][column % 3] = entry.value();
        found.matrix.col(column) = means(weights, rest.solve(held, force));
    }
    return found;
}

namespace {

/// Tolerance of forces out of balance: places move by less than a micrometre for them.
constexpr double push_tolerance = 1e-8;

class PushedSprings : public core::PushedBody {
  public:
    PushedSprings(ElasticBody body, const core::Problem &problem, std::span<const core::InteriorPlace> places)
        : body_(std::move(body)), points_(problem.body->mesh.points),
          compliance_(msm::compliance(body_, problem, places).matrix),
          weights_(core::nodal_weights(places, problem.body->mesh)),
          conditions_(conditions_at_rest(problem, body_.node_mass)), rest_(body_, points_, conditions_.displacement),
          displacement_(points_.size(), core::Vector3::Zero()), force_(Eigen::VectorXd::Zero(3 * weights_.rows())) {}

    const Eigen::MatrixXd &compliance() const override { return compliance_; }

    std::optional<core::PushedPlaces> push(const Eigen::VectorXd &force) override {
        Field there;
        const auto go_to = [&](const Eigen::VectorXd &part) {
            load(part);
            auto found = find_equilibrium(body_, points_, conditions_, rest_,
                                          {.tolerance = push_tolerance, .memory = &memory_, .bears_rounding = true},
                                          std::move(there));
            there = std::move(found.displacement);
            return found.status == core::SolutionStatus::ok;
        };
        if (!core::push_in_parts(
                force_, force, [&] { there = displacement_; }, go_to))
            return std::nullopt;
        displacement_ = std::move(there);
        force_ = force;
        return found();
    }

  private:
    void load(const Eigen::VectorXd &force) {
        std::ranges::fill(conditions_.force, core::Vector3::Zero());
        for (Eigen::Index place = 0; place < weights_.rows(); ++place)
            for (Weights::InnerIterator entry(weights_, place); entry; ++entry)
                conditions_.force[entry.col()] += entry.value() * force.segment<3>(3 * place);
    }

    core::PushedPlaces found() const {
        return {means(weights_, displacement_), elastic_energy(body_, moved(points_, displacement_))};
    }

    ElasticBody body_;
    Field points_;
    Eigen::MatrixXd compliance_;
    Weights weights_; ///< (K, N)
    NodalConditions conditions_;
    RestStiffness rest_;
    LimitedMemory memory_;
    Field displacement_;    ///< (N) [m]
    Eigen::VectorXd force_; ///< (3 K) that it is in equilibrium under [N]
};

} // namespace

std::unique_ptr<core::PushedBody> pushed_springs(ElasticBody body, const core::Problem &problem,
                                                 std::span<const core::InteriorPlace> places) {
    return std::make_unique<PushedSprings>(std::move(body), problem, places);
}

namespace {

/// Lanczos's method finds the copies of a repeated frequency one after the other, by rounding; a few more than are
/// asked for keep the last copy of the last one from being left out.
constexpr int num_spare = 5;
/// Tolerance of 1 / omega^2.
constexpr double relative_tolerance = 1e-13;
constexpr int most_restarts_of_spectrum = 1000;
/// Below this ratio of the smallest to the largest pivot nothing but rounding is left of the smallest one: springs free
/// to move gave 2.4e-13 or less, a rod a hundred times longer than wide and constrained at one end 6e-7.
constexpr double singular_pivot_ratio = 1e-11;

/// M^-1/2 K M^-1/2 as a Cholesky factor, and its inverse with scaled masses as Spectra asks for it.
class InverseStiffness : private Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> {
  public:
    using Scalar = double;
    explicit InverseStiffness(const Eigen::SparseMatrix<double> &matrix) {
        support::keep_openmp_in_this_thread();
        cholmod().print = 0;
        {
            const auto lock = support::only_ordering();
            analyzePattern(matrix);
        }
        const auto lock = support::only_in_blas();
        factorize(matrix);
    }

    bool is_regular() {
        return info() == Eigen::Success && cholmod_rcond(m_cholmodFactor, &cholmod()) > singular_pivot_ratio;
    }
    Eigen::Index rows() const { return CholmodSupernodalLLT::rows(); }
    Eigen::Index cols() const { return CholmodSupernodalLLT::cols(); }
    void set_shift(double) {} // it is zero, and the factor is there
    /// M'^1/2 K^-1 M'^1/2 with M' the scaled mass, of which M^-1/2 M'^1/2 is known to `scaled`.
    void perform_op(const double *x, double *y) const {
        const Eigen::VectorXd weighted = scaled(Eigen::VectorXd::Map(x, rows()));
        Eigen::VectorXd solution;
        {
            const auto lock = support::only_in_blas();
            solution = solve(weighted);
        }
        Eigen::VectorXd::Map(y, rows()) = scaled(solution);
    }

    std::function<Eigen::VectorXd(const Eigen::VectorXd &)> scaled = [](const Eigen::VectorXd &x) { return x; };
};

/// M^1/2 times what scale_deformation() makes of M^-1/2 x.
Eigen::VectorXd scaled_deformation(const Eigen::VectorXd &x, double power, const MassScaling &scaling,
                                   const ElasticBody &body, const Field &positions, const FreeComponents &free) {
    const auto scale = inverse_root_mass(body.node_mass, free);
    Field field(positions.size(), core::Vector3::Zero());
    free.add(field, scale.cwiseProduct(x), 1.0);
    auto unknowns = to_unknowns(field);
    scale_deformation(scaling, power, to_unknowns(positions), unknowns);
    return free.gather(to_field(unknowns)).cwiseQuotient(scale);
}

/// Adds a mode to others: phi = M^-1/2 times an eigenvector of norm 1, and of the two signs always the same.
void add_shape(Field &shapes, Eigen::VectorXd values, const FreeComponents &free, std::size_t num_nodes) {
    Eigen::Index largest = 0;
    values.cwiseAbs().maxCoeff(&largest);
    Field shape(num_nodes, core::Vector3::Zero());
    free.add(shape, values, std::copysign(1.0, values[largest]));
    shapes.insert(shapes.end(), shape.begin(), shape.end());
}

} // namespace

core::Modes lowest_modes(const ElasticBody &body, const Field &positions, const NodalConditions &conditions, int count,
                         const MassScaling &scaling) {
    const auto start = core::Clock::now();
    const FreeComponents free(conditions.displacement);
    if (count < 1 || count >= free.size())
        throw support::InputError(
            fmt::format("a body with {} free unknowns does not have the {} modes that are asked for; "
                        "ask for at least one and for fewer than that",
                        free.size(), count));
    const auto scale = inverse_root_mass(body.node_mass, free);
    InverseStiffness inverse_stiffness(
        scale.asDiagonal() * free.restrict(elastic_hessian(body, positions, Tangent::exact)) * scale.asDiagonal());
    if (!inverse_stiffness.is_regular())
        throw support::InputError("the constraints leave the body, or a part of it, free to move, so there are modes "
                                  "of zero frequency; constrain all six rigid body motions");
    const auto scaled = [&](const Eigen::VectorXd &x, double power) {
        return scaling.parts.empty() ? x : scaled_deformation(x, power, scaling, body, positions, free);
    };
    inverse_stiffness.scaled = [&](const Eigen::VectorXd &x) { return scaled(x, 0.5); };
    const auto num_wanted = std::min<Eigen::Index>(count + num_spare, free.size() - 1);
    const auto num_vectors = std::min(2 * num_wanted + 10, free.size());
    Spectra::SymEigsShiftSolver<InverseStiffness> lanczos(inverse_stiffness, num_wanted, num_vectors, 0.0);
    lanczos.init();
    lanczos.compute(Spectra::SortRule::LargestMagn, most_restarts_of_spectrum, relative_tolerance,
                    Spectra::SortRule::SmallestAlge);
    if (lanczos.info() != Spectra::CompInfo::Successful)
        throw std::runtime_error(
            fmt::format("the modes did not converge in {} restarts of Lanczos's method", most_restarts_of_spectrum));

    core::Modes modes;
    const Eigen::VectorXd squares = lanczos.eigenvalues();
    const Eigen::MatrixXd vectors = lanczos.eigenvectors();
    modes.shape.reserve(static_cast<std::size_t>(count) * positions.size());
    for (int mode = 0; mode < count; ++mode) {
        modes.angular_frequency.push_back(std::sqrt(squares[mode]));
        add_shape(modes.shape, scale.cwiseProduct(scaled(vectors.col(mode).normalized(), -0.5)), free,
                  positions.size());
    }
    modes.degrees_of_freedom = static_cast<std::int64_t>(3 * positions.size());
    modes.seconds = core::seconds_since(start);
    return modes;
}

} // namespace livermark::msm
