#include "interactive/elements/corotational_tetrahedra.hpp"

#include <utility>

#include "interactive/elements/rows_of_nodes.hpp"
#include "interactive/kernels/corotational/corotational_steps.hpp"

namespace livermark::interactive {

CorotationalTetrahedra::CorotationalTetrahedra(Scene given, Preconditioner preconditioner)
    : Simulation(std::move(given)), energy_(tetrahedra_at_rest(*scene().body)), preconditioner_(preconditioner),
      rest_(positions()) {
    if (scene().precision == Precision::single_precision && preconditioner == Preconditioner::blocks) {
        rows_ = kernels::corotational_rows(scene());
        return;
    }
    rotations_.resize(num_tetrahedra());
    residual_ = direction_ = product_ = preconditioned_ = rest_;
}

bool CorotationalTetrahedra::touch(const std::shared_ptr<core::BallContact> &ball) {
    ball_ = ball;
    if (rows_)
        rows_->touched.clear();
    return true;
}

/// Solves until what touches and slips is what was solved for.
/// @param guess  where nodes would be, int -> Vector3: with their velocities, and once solved, where they are
/// @param solve  from where the step begins, with the points of the contact
template <class Guess, class Solve>
void CorotationalTetrahedra::step_touched(double time_step, const Guess &guess, const Solve &solve) {
    constexpr int most_solutions = 5;
    const auto &x = positions();
    contact_.begin(*ball_, [&](int node) { return x.col(node); });
    contact_.linearise(guess);
    for (int s = 0; s < most_solutions; ++s) {
        solve();
        if (!contact_.linearise(guess))
            break;
    }
    contact_.finish(*ball_, guess);
    ball_->end_step(time_step);
}

void CorotationalTetrahedra::put_touched_into_rows() {
    rows_->touched.clear();
    for (const auto &point : contact_.points()) {
        if (point.stiffness.isZero(0.0))
            continue;
        auto &kept = rows_->touched.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            kept.rows[k] = rows_->body.row_of_node[point.nodes[k]];
            kept.shape[k] = static_cast<float>(point.shape[k]);
            kept.force[k] = static_cast<float>(point.force[static_cast<Eigen::Index>(k)]);
        }
        std::size_t entry = 0;
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j)
                kept.stiffness[entry++] = static_cast<float>(point.stiffness(i, j));
    }
}

void CorotationalTetrahedra::step(double time_step, int iterations) {
    if (rows_)
        step_in_single(time_step, iterations);
    else
        step_in_double(time_step, iterations);
}

void CorotationalTetrahedra::step_in_single(double time_step, int iterations) {
    auto &x = mutable_positions();
    rows_->body.aim_constrained(scene(), rest_, x, targets(), time_step);
    const auto take = [&] { kernels::take_corotational_step(*rows_, time_step, scene().mass_damping, iterations); };
    if (ball_) {
        const auto displacement = rows_->body.displacement, velocity = rows_->body.velocity;
        bool is_solved = false;
        const auto now = [&](int node) -> core::Vector3 {
            const int row = rows_->body.row_of_node[node];
            const core::Vector3 there = rest_.col(node) + in_row(rows_->body.displacement, row).cast<double>();
            return is_solved ? there : core::Vector3(there + time_step * in_row(velocity, row).cast<double>());
        };
        step_touched(time_step, now, [&] {
            rows_->body.displacement = displacement;
            rows_->body.velocity = velocity;
            put_touched_into_rows();
            take();
            is_solved = true;
        });
    } else {
        take();
    }
    take_from_rows(rows_->body.displacement, rows_->body.row_of_node, x);
    x += rest_;
    take_from_rows(rows_->body.velocity, rows_->body.row_of_node, mutable_velocities());
    move_to_targets(); // to the last bit
}

void CorotationalTetrahedra::step_in_double(double time_step, int iterations) {
    auto &x = mutable_positions();
    auto &v = mutable_velocities();
    product_.setZero();
    for (std::size_t t = 0; t < num_tetrahedra(); ++t) {
        const auto &tetrahedron = energy_.tetrahedra()[t];
        const Matrix3 gradient = tetrahedron.gradient(x);
        rotations_[t] = densities::rotation(gradient);
        const densities::Corotational density{tetrahedron.mu, tetrahedron.lambda};
        tetrahedron.add_forces(density.stress(gradient, rotations_[t]), product_);
    }
    residual_ = time_step * (product_ + external_forces());
    for (Eigen::Index i = 0; i < x.cols(); ++i)
        residual_.col(i) += scene().node_mass[i] * v.col(i);
    for (Eigen::Index c = 0; c < targets().cols(); ++c) {
        const int node = scene().constrained_nodes[c];
        v.col(node) = (targets().col(c) - x.col(node)) / time_step;
    }
    if (ball_) {
        const Field residual = residual_, velocities = v;
        step_touched(
            time_step, [&](int node) { return core::Vector3(x.col(node) + time_step * v.col(node)); },
            [&] {
                residual_ = residual;
                v = velocities;
                for (const auto &point : contact_.points())
                    for (std::size_t k = 0; k < 3; ++k)
                        residual_.col(point.nodes[k]) += time_step * point.shape[k] * point.force;
                precondition_and_solve(time_step, iterations);
            });
    } else {
        precondition_and_solve(time_step, iterations);
    }
    x += time_step * v;
    move_to_targets(); // to the last bit
}

void CorotationalTetrahedra::precondition_and_solve(double time_step, int iterations) {
    if (preconditioner_ == Preconditioner::blocks)
        invert_blocks(time_step);
    solve(mutable_velocities(), time_step, iterations);
}

void CorotationalTetrahedra::set_state(const Field &positions, const Field &velocities) {
    Simulation::set_state(positions, velocities);
    if (rows_) {
        put_into_rows(positions - rest_, rows_->body.row_of_node, rows_->body.displacement);
        put_into_rows(velocities, rows_->body.row_of_node, rows_->body.velocity);
    }
}

void CorotationalTetrahedra::set_external_forces(const Field &forces) {
    Simulation::set_external_forces(forces);
    if (rows_)
        put_into_rows(external_forces(), rows_->body.row_of_node, rows_->body.external);
}

Cost CorotationalTetrahedra::cost(int iterations) const {
    const auto tetrahedra = static_cast<double>(num_tetrahedra());
    if (rows_)
        return {.element_passes = 1.0 + iterations,
                .bytes_per_element = static_cast<double>(rows_->bytes()) / tetrahedra};
    return {.element_passes = 2.0 + iterations,
            .bytes_per_element = static_cast<double>(sizeof(Tetrahedron) + sizeof(Matrix3)) +
                                 static_cast<double>(sizeof(Matrix3) * inverse_blocks_.size()) / tetrahedra};
}

Orders CorotationalTetrahedra::orders() const {
    return rows_ ? rows_->body.orders() : Orders{};
}

/// A v, zero at constrained nodes.
void CorotationalTetrahedra::multiply(const Field &v, double time_step, Field &product) const {
    product.setZero();
    for (std::size_t t = 0; t < num_tetrahedra(); ++t) { // K v, as forces of minus that
        const auto &tetrahedron = energy_.tetrahedra()[t];
        const Matrix3 rate = rotations_[t].transpose() * tetrahedron.gradient(v);
        Matrix3 stress = tetrahedron.mu * (rate + rate.transpose());
        stress.diagonal().array() += tetrahedron.lambda * rate.trace();
        tetrahedron.add_forces(rotations_[t] * stress, product);
    }
    if (ball_)
        for (const auto &point : contact_.points()) {
            core::Vector3 rate = core::Vector3::Zero();
            for (std::size_t k = 0; k < 3; ++k)
                rate += point.shape[k] * v.col(point.nodes[k]);
            const core::Vector3 pull = point.stiffness * rate;
            for (std::size_t k = 0; k < 3; ++k)
                product.col(point.nodes[k]) -= point.shape[k] * pull;
        }
    product *= -time_step * time_step;
    const double damping = 1.0 + scene().mass_damping * time_step;
    for (Eigen::Index i = 0; i < v.cols(); ++i)
        product.col(i) += damping * scene().node_mass[i] * v.col(i);
    for (const int node : scene().constrained_nodes)
        product.col(node).setZero();
}

/// Of A, with K_aa = sum of V ((lambda + mu) g g^T + mu |g|^2 1), g the turned gradient of the shape function.
void CorotationalTetrahedra::invert_blocks(double time_step) {
    const double damping = 1.0 + scene().mass_damping * time_step;
    inverse_blocks_.clear();
    for (const double mass : scene().node_mass)
        inverse_blocks_.emplace_back(damping * mass * Matrix3::Identity());
    for (std::size_t t = 0; t < num_tetrahedra(); ++t) {
        const auto &tetrahedron = energy_.tetrahedra()[t];
        const Eigen::Matrix<double, 3, 4> turned = rotations_[t] * tetrahedron.shape_gradients().transpose();
        const double factor = time_step * time_step * tetrahedron.volume;
        for (int c = 0; c < 4; ++c) {
            auto &block = inverse_blocks_[tetrahedron.nodes[c]];
            block += factor * (tetrahedron.lambda + tetrahedron.mu) * turned.col(c) * turned.col(c).transpose();
            block.diagonal().array() += factor * tetrahedron.mu * turned.col(c).squaredNorm();
        }
    }
    if (ball_)
        for (const auto &point : contact_.points())
            for (std::size_t k = 0; k < 3; ++k)
                inverse_blocks_[point.nodes[k]] +=
                    time_step * time_step * point.shape[k] * point.shape[k] * point.stiffness;
    for (auto &block : inverse_blocks_)
        block = block.inverse().eval();
}

void CorotationalTetrahedra::precondition(const Field &residual, Field &result) const {
    result = residual;
    for (std::size_t i = 0; i < inverse_blocks_.size(); ++i)
        result.col(static_cast<Eigen::Index>(i)) = inverse_blocks_[i] * residual.col(static_cast<Eigen::Index>(i));
}

/// Conjugate gradients for A v = residual, from v.
void CorotationalTetrahedra::solve(Field &v, double time_step, int iterations) {
    constexpr double rounding = 1e-32; // of squares: there is nothing left to do
    multiply(v, time_step, product_);
    residual_ -= product_;
    for (const int node : scene().constrained_nodes)
        residual_.col(node).setZero();
    precondition(residual_, preconditioned_);
    direction_ = preconditioned_;
    const double first = residual_.cwiseProduct(preconditioned_).sum();
    double squared = first;
    for (int i = 0; i < iterations && squared > rounding * first; ++i) {
        multiply(direction_, time_step, product_);
        const double length = squared / direction_.cwiseProduct(product_).sum();
        v += length * direction_;
        residual_ -= length * product_;
        precondition(residual_, preconditioned_);
        const double next = residual_.cwiseProduct(preconditioned_).sum();
        direction_ = preconditioned_ + next / squared * direction_;
        squared = next;
    }
}

} // namespace livermark::interactive
