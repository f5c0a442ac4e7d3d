#include "msm/statics/equilibrium.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "msm/statics/rest_stiffness.hpp"

namespace livermark::msm {

namespace {

/// A load of which the direction f is known and the amount is a result, because f . u is prescribed: what it takes to
/// stay among the displacements that keep f . u.
class PressedLoad {
  public:
    /// @param unit  f of the free components; empty where no place presses, and nothing is changed then
    explicit PressedLoad(Eigen::VectorXd unit) : unit_(std::move(unit)) {}

    bool is_there() const { return unit_.size() > 0; }
    const Eigen::VectorXd &unit() const { return unit_; }

    /// The amount that leaves least of an elastic force.
    double amount_in(const Eigen::VectorXd &elastic) const { return elastic.dot(unit_) / unit_.squaredNorm(); }

    /// A force without its part along f, which whoever presses takes.
    Eigen::VectorXd without(Eigen::VectorXd force) const {
        if (is_there())
            force -= amount_in(force) * unit_;
        return force;
    }

    /// An inverse times a vector, without what changes f . u; of multiples of f nothing is left.
    Eigen::VectorXd step(const LinearMap &inverse, const Eigen::VectorXd &vector) const {
        Eigen::VectorXd step = inverse(vector);
        if (is_there()) {
            const Eigen::VectorXd along = inverse(unit_);
            step -= unit_.dot(step) / unit_.dot(along) * along;
        }
        return step;
    }

  private:
    Eigen::VectorXd unit_;
};

/// Steps after which one factor has to have brought the residual down tenfold, or another is made. A hundred steps cost
/// about as much as a factor.
constexpr int steps_between_looks = 10;
constexpr double least_reduction = 0.1;
/// The same where the factor is that of a preconditioner: it takes more steps, but another factor would be a wide one.
constexpr int steps_between_looks_of_many = 40;
constexpr double least_reduction_of_many = 0.5;
/// Conjugate gradients in a step of Newton's method without a factor.
constexpr int most_products = 200;

/// Part of what compression makes negative in the second derivative that is left out first where all of it is too much.
constexpr double smallest_part_left_out = 1.0 / 16.0;

/// The way down in the potential U(x) - f . u of one body, loads and constraints. Where a place presses, f . u stays as
/// it is, and the load is a multiple of f.
class Descent {
  public:
    Descent(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
            const RestStiffness &rest, const EquilibriumOptions &options, Equilibrium &state)
        : body_(body), positions_(positions), conditions_(conditions), rest_(rest), free_(rest.free()),
          options_(options), state_(state),
          pressed_(conditions.press_depth != 0.0 ? free_.gather(conditions.force) : Eigen::VectorXd()),
          potential_(come_to(at(state.displacement))) {}

    /// Whether there is an energy where it is.
    bool is_possible() const { return std::isfinite(potential_); }

    /// Force that holds each node where it is, beyond the loads: zero on free components in equilibrium.
    const Field &unbalanced() const { return unbalanced_; }

    /// Norm of the free part of the unbalanced force, relative to all forces at work.
    double relative_residual() const {
        double all = 0.0;
        for (std::size_t i = 0; i < unbalanced_.size(); ++i)
            all += unbalanced_[i].squaredNorm() + (amount_ * conditions_.force[i]).squaredNorm();
        return all > 0.0 ? free_.gather(unbalanced_).norm() / std::sqrt(all) : 0.0;
    }

    /// Whether the free part of the unbalanced force is within the tolerance, or within what rounding leaves of it.
    bool is_balanced() const {
        return relative_residual() <= options_.tolerance || free_.gather(unbalanced_).norm() <= rest_.rounding_force();
    }

    /// Goes down as long as the inverse by a factor is good for it.
    /// @param memory          corrects the inverse
    /// @param is_approximate  whether it is that of a preconditioner
    /// @return number of steps, 0 where there was none downhill
    int follow(const LinearMap &by_factor, LimitedMemory &memory, bool is_approximate) {
        const int between_looks = is_approximate ? steps_between_looks_of_many : steps_between_looks;
        const double reduction = is_approximate ? least_reduction_of_many : least_reduction;
        const LinearMap inverse = [&](const auto &vector) { return memory.times(by_factor, vector); };
        double last_look = relative_residual();
        Eigen::VectorXd gradient = free_gradient();
        int steps = 0;
        while (!is_balanced() && state_.num_iterations < options_.max_iterations) {
            // Not of the whole gradient: single precision would lose in the load what is left to balance.
            const Eigen::VectorXd left = free_.gather(unbalanced_);
            const Eigen::VectorXd direction = -pressed_.step(inverse, left);
            const double scale = search_line(direction, left.dot(direction));
            if (scale == 0.0)
                break;
            ++steps, ++state_.num_iterations;
            const Eigen::VectorXd there = free_gradient();
            memory.learn(scale * direction, there - gradient);
            gradient = there;
            if (steps % between_looks == 0) {
                const double residual = relative_residual();
                if (residual > reduction * last_look)
                    break;
                last_look = residual;
            }
        }
        return steps;
    }

    /// The same with a factor of the second derivative where it is now. Where that is not positive definite, a part
    /// of what compression makes negative is left out of it, more and more until it is. All of it is safe, but then the
    /// way out along a direction that bends downwards is taken in steps that grow by a few percent each.
    /// @return whether there was a step downhill
    bool follow_tangent() {
        const Field x = moved(positions_, state_.displacement);
        const auto exact = free_.restrict(hessian(x, Tangent::exact));
        Eigen::SparseMatrix<double> compression;
        while (true) {
            if (part_left_out_ > 0.0 && compression.size() == 0)
                compression = free_.restrict(hessian(x, Tangent::semi_definite)) - exact;
            const bool is_definite = factorise(
                part_left_out_ > 0.0 ? Eigen::SparseMatrix<double>(exact + part_left_out_ * compression) : exact);
            ++state_.num_factors;
            LimitedMemory memory;
            if (is_definite && follow([&](const auto &vector) { return factor_.solve(vector); }, memory, false) > 0) {
                part_left_out_ = part_left_out_ > smallest_part_left_out ? 0.5 * part_left_out_ : 0.0;
                return true;
            }
            if (part_left_out_ == 1.0)
                return false;
            part_left_out_ = std::min(1.0, std::max(smallest_part_left_out, 2.0 * part_left_out_));
        }
    }

    /// A step of Newton's method with the second derivative where it is now and no factor of it: conjugate gradients
    /// with the factor of the preconditioner, as exactly as it is worth (Dembo, Eisenstat, Steihaug 1982), until they
    /// meet a direction that bends downwards (Steihaug 1983).
    /// @return whether it was a step downhill
    bool follow_products() {
        const Field x = moved(positions_, state_.displacement);
        const Eigen::VectorXd positions = to_unknowns(x);
        const Eigen::VectorXd gradient = free_.gather(unbalanced_);
        const double tolerance = std::min(0.1, std::sqrt(relative_residual()));
        const LinearMap inverse = [&](const auto &vector) { return rest_.inverse_times(vector); };
        const Eigen::VectorXd step = conjugate_gradients(
            [&](const auto &direction) { return pressed_.without(tangent_times(x, positions, direction)); },
            [&](const auto &vector) { return pressed_.step(inverse, vector); }, -gradient, tolerance, most_products);
        if (search_line(step, gradient.dot(step)) == 0.0)
            return false;
        ++state_.num_iterations;
        return true;
    }

    /// Force of the places that press, together [N].
    double press() const { return pressed_.is_there() ? amount_ : 0.0; }

  private:
    /// Derivative of U, with the load where none presses.
    Eigen::VectorXd free_gradient() const {
        Eigen::VectorXd gradient = free_.gather(unbalanced_);
        if (pressed_.is_there())
            gradient += amount_ * pressed_.unit();
        return gradient;
    }

    /// H, of the body and what touches it.
    Eigen::SparseMatrix<double> hessian(const Field &x, Tangent tangent) const {
        auto result = elastic_hessian(body_, x, tangent);
        if (options_.contact)
            result += options_.contact->hessian(x, tangent);
        return result;
    }

    /// H_ff d
    Eigen::VectorXd tangent_times(const Field &x, const Eigen::VectorXd &positions,
                                  const Eigen::VectorXd &direction) const {
        Field field(positions_.size(), core::Vector3::Zero());
        free_.add(field, direction, 1.0);
        const Eigen::VectorXd all = to_unknowns(field);
        Eigen::VectorXd product = Eigen::VectorXd::Zero(all.size());
        for (const auto &term : body_.terms)
            term->add_hessian_product(positions, all, product);
        if (options_.contact)
            options_.contact->add_hessian_product(x, all, product);
        return free_.gather(to_field(product));
    }

    bool factorise(const Eigen::SparseMatrix<double> &tangent) {
        if (!is_ordered_)
            factor_.order(tangent);
        is_ordered_ = true; // its entries are in the same places every time
        return factor_.factorise(tangent);
    }

    /// Potential, and the gradient of all but the loads, at a displacement.
    EnergyAndGradient at(const Field &displacement) const {
        const Field x = moved(positions_, displacement);
        auto there = elastic_energy_and_gradient(body_, x);
        if (!std::isfinite(there.energy))
            return there;
        if (options_.pressure) {
            options_.pressure->add_gradient(x, there.gradient);
            there.energy += options_.pressure->energy(x);
        }
        if (options_.contact) {
            options_.contact->add_gradient(x, there.gradient);
            there.energy += options_.contact->energy(x);
        }
        if (!pressed_.is_there())
            for (std::size_t i = 0; i < displacement.size(); ++i)
                there.energy -= conditions_.force[i].dot(displacement[i]);
        return there;
    }

    /// Takes what is unbalanced there. Where a place presses, its amount is that which leaves least.
    /// @return the potential
    double come_to(EnergyAndGradient there) {
        unbalanced_ = std::move(there.gradient);
        if (pressed_.is_there())
            amount_ = pressed_.amount_in(free_.gather(unbalanced_));
        for (std::size_t i = 0; i < unbalanced_.size(); ++i)
            unbalanced_[i] -= amount_ * conditions_.force[i];
        return there.energy;
    }

    /// Springs of stiffness k with energies k e^2 / 2 change by k e dx where positions are rounded by dx, and the sum
    /// of that is at most sqrt(2 U sum k) dx. A ball that touches rounds more than that where it is large.
    double rounding_of_energy() const {
        const double contact_rounding =
            options_.contact ? options_.contact->rounding_of_energy(moved(positions_, state_.displacement)) : 0.0;
        if (!options_.bears_rounding)
            return contact_rounding;
        const double rounding = std::numeric_limits<double>::epsilon() * core::extent(positions_);
        return contact_rounding + std::sqrt(2.0 * std::abs(potential_) * std::sqrt(static_cast<double>(free_.size())) *
                                            rest_.rounding_force() * rounding);
    }

    /// @return part of the direction that was gone, 0 where nothing of it leads downhill
    double search_line(const Eigen::VectorXd &direction, double slope) {
        const double start = potential_;
        // Close to the minimum the decrease is lost in rounding; a full step is then judged by the residual instead.
        const double rounding = 1e-13 * (std::abs(start) + std::abs(slope)) + rounding_of_energy();
        for (double scale = 1.0; scale > 1e-6; scale *= 0.5) {
            Field trial = state_.displacement;
            free_.add(trial, direction, scale);
            auto there = at(trial);
            if (there.energy <= start + 1e-4 * scale * slope + rounding) {
                state_.displacement = std::move(trial);
                potential_ = come_to(std::move(there));
                return scale;
            }
        }
        return 0.0;
    }

    const ElasticBody &body_;
    const Field &positions_;
    const NodalConditions &conditions_;
    const RestStiffness &rest_;
    const FreeComponents &free_;
    const EquilibriumOptions &options_;
    Equilibrium &state_; // displacement and numbers of steps
    PressedLoad pressed_;
    double amount_ = 1.0; // what the loads are multiplied by
    Field unbalanced_;
    double potential_;
    support::SparseCholesky factor_;
    bool is_ordered_ = false;
    double part_left_out_ = 0.0;
};

/// Only constrained nodes carry a constraint force; what is left on the free ones is the residual.
Field constraint_part(Field unbalanced, const NodalConditions &conditions) {
    for (std::size_t i = 0; i < unbalanced.size(); ++i)
        for (int c = 0; c < 3; ++c)
            if (std::isnan(conditions.displacement[i][c]))
                unbalanced[i][c] = 0.0;
    return unbalanced;
}

} // namespace

Field linear_solution(const RestStiffness &rest, const NodalConditions &conditions, LimitedMemory *memory) {
    auto displacement = rest.solve(conditions.displacement, conditions.force, memory);
    if (conditions.press_depth == 0.0)
        return displacement;
    double depth = 0.0; // of one newton
    for (std::size_t i = 0; i < displacement.size(); ++i)
        depth += conditions.force[i].dot(displacement[i]);
    if (depth > 0.0)
        for (auto &node : displacement)
            node *= conditions.press_depth / depth;
    return displacement;
}

Equilibrium find_equilibrium(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                             const EquilibriumOptions &options) {
    return find_equilibrium(body, positions, conditions, RestStiffness(body, positions, conditions.displacement),
                            options);
}

Equilibrium find_equilibrium(const ElasticBody &body, const Field &positions, const NodalConditions &conditions,
                             const RestStiffness &rest, const EquilibriumOptions &options, Field start) {
    Equilibrium result;
    const auto give_up = [&result](std::string why) {
        result.status = core::SolutionStatus::not_converged;
        result.message = std::move(why);
    };
    LimitedMemory own;
    auto &memory = options.memory && rest.is_approximate() ? *options.memory : own;
    if (start.empty())
        start = result.linear_displacement = linear_solution(rest, conditions, &memory);
    result.displacement = std::move(start);
    if (!rest.is_definite()) {
        give_up("the body at rest is not stiff in every direction; constrain more facets");
        result.constraint_force.assign(positions.size(), core::Vector3::Zero());
        return result;
    }
    Descent descent(body, positions, conditions, rest, options, result);
    if (!descent.is_possible()) {
        give_up("tetrahedra are inside out where the search begins; lower the load, or go to it along a path");
        result.constraint_force.assign(positions.size(), core::Vector3::Zero());
        return result;
    }
    // At rest nothing touches, so that factor is no help to a body that is touched.
    if (!options.contact)
        descent.follow([&](const auto &vector) { return rest.inverse_times(vector); }, memory, rest.is_approximate());
    while (!descent.is_balanced()) {
        if (result.num_iterations == options.max_iterations) {
            give_up(fmt::format("a relative residual of {1:.1e} is left after {0} steps; lower the load",
                                result.num_iterations, descent.relative_residual()));
            break;
        }
        if (!(rest.is_approximate() ? descent.follow_products() : descent.follow_tangent())) {
            give_up(fmt::format("no step downhill from a relative residual of {:.1e}; lower the load",
                                descent.relative_residual()));
            break;
        }
    }
    result.constraint_force = constraint_part(descent.unbalanced(), conditions);
    result.press = descent.press();
    if (options.contact)
        result.touch = options.contact->forces(moved(positions, result.displacement));
    return result;
}

} // namespace livermark::msm
