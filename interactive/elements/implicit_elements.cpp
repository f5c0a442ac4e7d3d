#include "interactive/elements/implicit_elements.hpp"

#include <array>
#include <stdexcept>
#include <utility>

#include "core/support/factors/sparse_cholesky.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive {

core::Vector3 ImplicitContact::linearise_at(Point &point, const core::Vector3 &x) const {
    point.stiffness.setZero();
    point.force.setZero();
    const core::Vector3 from_centre = x - step_.to;
    const auto gap = core::gap_to(step_.shape, from_centre);
    const double depth = -gap.size;
    if (depth <= 0.0 || gap.distance == 0.0)
        return core::Vector3::Zero();
    const core::Vector3 &normal = gap.normal;
    const double size = depth / point.compliance;
    point.stiffness = normal * normal.transpose() / point.compliance;
    point.force = normal * ((depth + normal.dot(x - point.start)) / point.compliance);
    if (step_.friction == 0.0)
        return size * normal;
    const auto across = [&](const core::Vector3 &v) { return core::Vector3(v - normal.dot(v) * normal); };
    const core::Vector3 ball_way = step_.to - step_.from;
    const core::Vector3 sticking = across(point.before) - across(x - point.start - ball_way) / point.compliance;
    const double length = sticking.norm(), limit = step_.friction * size;
    const double share = length > limit ? limit / length : 1.0;
    point.stiffness += share / point.compliance * (Matrix3::Identity() - normal * normal.transpose());
    point.force += share * (across(point.before) + across(ball_way) / point.compliance);
    return size * normal + share * sticking;
}

CorotationalTetrahedra::CorotationalTetrahedra(Scene given)
    : SimulationInRows(std::move(given)), energy_(capsule_and_vessels(scene()), tetrahedra_at_rest(*scene().body)),
      rows_(kernels::corotational_rows(scene(), energy_.point_springs())) {}

bool CorotationalTetrahedra::touch(const std::shared_ptr<core::BallContact> &ball) {
    rows_.touched.clear();
    return SimulationInRows::touch(ball);
}

/// Solves until what touches and slips is what was solved for.
void CorotationalTetrahedra::step_touched(double time_step, int iterations) {
    constexpr int most_solutions = 5;
    const auto displacement = rows_.body.displacement, velocity = rows_.body.velocity;
    bool is_solved = false;
    // Nodes are where their velocities lead, and once solved, where they are.
    const auto now = [&](int node) -> core::Vector3 {
        const core::Vector3 there = row_position(node);
        return is_solved ? there : core::Vector3(there + time_step * in_row(velocity, row_of(node)).cast<double>());
    };
    contact_.begin(*ball_, [&](int node) { return positions().col(node); });
    contact_.linearise(now);
    for (int s = 0; s < most_solutions; ++s) {
        rows_.body.displacement = displacement;
        rows_.body.velocity = velocity;
        put_touched_into_rows();
        kernels::take_corotational_step(rows_, time_step, scene().mass_damping, iterations);
        is_solved = true;
        if (!contact_.linearise(now))
            break;
    }
    contact_.finish(*ball_, now);
    ball_->end_step(time_step);
}

void CorotationalTetrahedra::put_touched_into_rows() {
    rows_.touched.clear();
    for (const auto &point : contact_.points()) {
        if (point.stiffness.isZero(0.0))
            continue;
        auto &kept = rows_.touched.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            kept.rows[k] = rows_.body.row_of_node[point.nodes[k]];
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
    rows_.body.aim_constrained(scene(), rest_, positions(), targets(), time_step);
    if (ball_)
        step_touched(time_step, iterations);
    else
        kernels::take_corotational_step(rows_, time_step, scene().mass_damping, iterations);
    take_state_from_rows();
}

void Prefactored::prepare(double time_step) {
    if (time_step == factorised_for_)
        return;
    const auto terms = inertia(*this, time_step);
    unknown_.assign(terms.stiffness.size(), -1);
    num_unknowns_ = 0;
    for (std::size_t i = 0; i < unknown_.size(); ++i)
        if (is_free()[i])
            unknown_[i] = num_unknowns_++;
    Energy::Triplets kept;
    for (const auto &entry : laplacian_())
        if (unknown_[entry.row()] >= 0 && unknown_[entry.col()] >= unknown_[entry.row()])
            kept.emplace_back(unknown_[entry.row()], unknown_[entry.col()], entry.value());
    for (std::size_t i = 0; i < unknown_.size(); ++i)
        if (unknown_[i] >= 0)
            kept.emplace_back(unknown_[i], unknown_[i], terms.stiffness[i]);
    Eigen::SparseMatrix<double> matrix(num_unknowns_, num_unknowns_);
    matrix.setFromTriplets(kept.begin(), kept.end());
    if (num_unknowns_ > 0) {
        if (const auto order = order_of_unknowns(); order.empty())
            factor_.order(matrix);
        else
            factor_.order(matrix, order);
        if (!factor_.factorise(matrix))
            throw std::logic_error("the matrix of projective dynamics is not positive definite");
        rows_.set_factor(factor_.factor(), unknown_, terms.stiffness);
    }
    factorised_for_ = time_step;
    columns_.clear();
    stiffness_ = terms.stiffness;
}

/// The order of a scene, as unknowns; empty if there is none.
std::vector<int> Prefactored::order_of_unknowns() const {
    if (!scene().orders || scene().orders->factor.size() != static_cast<std::size_t>(num_unknowns_))
        return {};
    std::vector<int> order;
    for (const int node : scene().orders->factor)
        order.push_back(unknown_[node]);
    return order;
}

Orders Prefactored::orders() const {
    Orders orders = rows_.orders();
    if (factorised_for_ == 0.0 || num_unknowns_ == 0)
        return orders;
    std::vector<int> node_of(static_cast<std::size_t>(num_unknowns_));
    for (std::size_t i = 0; i < unknown_.size(); ++i)
        if (unknown_[i] >= 0)
            node_of[unknown_[i]] = static_cast<int>(i);
    for (const int unknown : factor_.factor().order)
        orders.factor.push_back(node_of[unknown]);
    return orders;
}

bool Prefactored::touch(const std::shared_ptr<core::BallContact> &ball) {
    rows_.after_iteration = ball ? [this] { touch_rows(); } : std::function<void()>();
    return SimulationInRows::touch(ball);
}

void Prefactored::step(double time_step, int iterations) {
    prepare(time_step);
    if (ball_) {
        has_touched_ = false;
        forces_.assign(static_cast<std::size_t>(positions().cols()), core::Vector3::Zero());
        find_columns();
    }
    rows().aim_constrained(scene(), rest_, positions(), targets(), time_step);
    kernels::take_prefactored_step(rows_, time_step, scene().mass_damping, iterations);
    take_state_from_rows();
    if (ball_)
        ball_->end_step(time_step);
}

/// Finds the columns of nodes that the ball has come near to.
void Prefactored::find_columns() {
    columns_.resize(unknown_.size());
    std::vector<int> found;
    for (const int node : ball_->near())
        if (unknown_[node] >= 0 && columns_[node].size() == 0)
            found.push_back(node);
    if (found.empty())
        return;
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(num_unknowns_, static_cast<Eigen::Index>(found.size()));
    for (std::size_t k = 0; k < found.size(); ++k)
        unit(unknown_[found[k]], static_cast<Eigen::Index>(k)) = 1.0;
    const Eigen::MatrixXd all = factor_.solve(unit);
    for (std::size_t k = 0; k < found.size(); ++k)
        columns_[found[k]] = all.col(static_cast<Eigen::Index>(k));
}

/// Finds the forces of the ball that go with where an iteration has brought the nodes, and moves all by these.
void Prefactored::touch_nodes() {
    constexpr int most_sweeps = 20;
    constexpr double steady = 1e-3; // as the sweeps of an iteration end: the next ones go on
    const auto &near = ball_->near();
    const auto start = [&](int node) {
        return core::Vector3(rest_.col(node) + in_row(rows_.before, row_of(node)).cast<double>());
    };
    std::vector<core::Vector3> x(forces_.size()), change(forces_.size(), core::Vector3::Zero());
    for (const int node : near)
        x[node] = row_position(node);
    const auto give = [&](int node, const core::Vector3 &force) {
        change[node] += force;
        if (unknown_[node] < 0)
            return;
        for (const int other : near)
            if (unknown_[other] >= 0)
                x[other] += columns_[node][unknown_[other]] * force;
    };
    const auto yields = [&](const std::array<int, 3> &nodes, const std::array<double, 3> &shape) {
        double sum = 0.0;
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = 0; b < 3; ++b)
                if (unknown_[nodes[a]] >= 0 && unknown_[nodes[b]] >= 0)
                    sum += shape[a] * shape[b] * columns_[nodes[a]][unknown_[nodes[b]]];
        return Eigen::Matrix3d(sum * Eigen::Matrix3d::Identity());
    };
    if (!has_touched_)
        ball_->begin_step(give);
    has_touched_ = true;
    const auto now = [&](int node) -> const core::Vector3 & { return x[node]; };
    const auto step = ball_->part(0, 1);
    for (int s = 0; s < most_sweeps && ball_->sweep(step, start, now, yields, give) > steady; ++s) {
    }
    Eigen::MatrixX3d moved = Eigen::MatrixX3d::Zero(num_unknowns_, 3);
    bool is_pushed = false;
    for (const int node : near) {
        forces_[node] += change[node];
        if (unknown_[node] < 0 || change[node].isZero(0.0))
            continue;
        moved += columns_[node] * change[node].transpose();
        is_pushed = true;
    }
    for (std::size_t i = 0; is_pushed && i < unknown_.size(); ++i)
        if (unknown_[i] >= 0)
            row_position(static_cast<int>(i)) += core::Vector3(moved.row(unknown_[i]).transpose());
}

void Prefactored::touch_rows() {
    const auto &near = ball_->near();
    if (!has_touched_) {
        near_predicted_.clear();
        for (const int node : near)
            near_predicted_.emplace_back(in_row(rows_.predicted, row_of(node)).cast<double>());
    }
    touch_nodes();
    for (std::size_t k = 0; k < near.size(); ++k)
        if (unknown_[near[k]] >= 0)
            in_row(rows_.predicted, row_of(near[k])) =
                (near_predicted_[k] + forces_[near[k]] / stiffness_[near[k]]).cast<float>();
}

Energy::Triplets laplacian(const Springs &springs) {
    Energy::Triplets triplets;
    for (std::size_t s = 0; s < springs.edges.size(); ++s)
        for (const int a : springs.edges[s])
            for (const int b : springs.edges[s])
                triplets.emplace_back(a, b, a == b ? springs.stiffness[s] : -springs.stiffness[s]);
    return triplets;
}

Energy::Triplets laplacian(const std::vector<Tetrahedron> &tetrahedra) {
    Energy::Triplets triplets;
    for (const auto &t : tetrahedra) {
        const Eigen::Matrix4d block = t.volume * densities::Projective{t.mu, t.lambda}.weight() * t.shape_gradients() *
                                      t.shape_gradients().transpose();
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b)
                triplets.emplace_back(t.nodes[a], t.nodes[b], block(a, b));
    }
    return triplets;
}

} // namespace livermark::interactive
