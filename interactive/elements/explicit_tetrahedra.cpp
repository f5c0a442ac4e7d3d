#include "interactive/elements/explicit_tetrahedra.hpp"

#include <Eigen/Eigenvalues>
#include <Spectra/SymEigsSolver.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/kernels/method_steps.hpp"

namespace livermark::interactive {

namespace {

/// M^-1/2 K M^-1/2 over the free components, for Spectra.
class ScaledStiffness {
  public:
    using Scalar = double;

    ScaledStiffness(const Energy &energy, const Scene &scene) : energy_(&energy), rest_(rest_positions(scene)) {
        const auto is_free = free_nodes(scene);
        for (Eigen::Index i = 0; i < rest_.cols(); ++i)
            if (is_free[i]) {
                nodes_.push_back(i);
                root_.push_back(1.0 / std::sqrt(scene.node_mass[i]));
            }
        // As small against an element as leaves half of the digits.
        constexpr double part_of_body = 1e-7;
        length_ = part_of_body * core::extent(scene.body->mesh.points);
    }

    Eigen::Index rows() const { return 3 * static_cast<Eigen::Index>(nodes_.size()); }
    Eigen::Index cols() const { return rows(); }

    void perform_op(const double *in, double *out) const {
        Field move = Field::Zero(3, rest_.cols());
        for (std::size_t k = 0; k < nodes_.size(); ++k)
            move.col(nodes_[k]) = root_[k] * core::Vector3(in[3 * k], in[3 * k + 1], in[3 * k + 2]);
        const double largest = move.cwiseAbs().maxCoeff();
        const double factor = largest > 0.0 ? length_ / largest : 1.0;
        Field behind = Field::Zero(3, rest_.cols()), ahead = behind;
        energy_->add_forces(rest_ - factor * move, behind);
        energy_->add_forces(rest_ + factor * move, ahead);
        for (std::size_t k = 0; k < nodes_.size(); ++k)
            Eigen::Map<core::Vector3>(out + 3 * k) =
                root_[k] / (2.0 * factor) * (behind.col(nodes_[k]) - ahead.col(nodes_[k]));
    }

  private:
    const Energy *energy_;
    Field rest_;
    std::vector<Eigen::Index> nodes_; ///< that are free
    std::vector<double> root_;        ///< of one over their masses
    double length_ = 0.0;             ///< of the differences [m]
};

} // namespace

double critical_time_step(const Energy &energy, const Scene &scene) {
    ScaledStiffness operation(energy, scene);
    if (operation.rows() == 0)
        return std::numeric_limits<double>::infinity();
    constexpr Eigen::Index num_vectors = 24;
    constexpr int most_restarts = 200;
    constexpr double tolerance = 1e-4;
    Spectra::SymEigsSolver<ScaledStiffness> solver(operation, 1, std::min(num_vectors, operation.rows()));
    solver.init();
    if (solver.compute(Spectra::SortRule::LargestAlge, most_restarts, tolerance) < 1)
        throw std::runtime_error("the highest frequency of the body is not found");
    return 2.0 / std::sqrt(solver.eigenvalues()[0]);
}

double critical_time_step_bound(const std::vector<Tetrahedron> &tetrahedra, const std::vector<double> &node_mass) {
    std::vector<double> node_volume(node_mass.size(), 0.0);
    for (const auto &t : tetrahedra)
        for (const int node : t.nodes)
            node_volume[node] += t.volume;
    double highest = 0.0;
    for (const auto &t : tetrahedra) {
        const auto gradients = t.shape_gradients();
        Eigen::Matrix<double, 12, 9> strain; // dF of unit moves, over the roots of masses
        for (int a = 0; a < 4; ++a) {
            const double mass = node_mass[t.nodes[a]] * t.volume / node_volume[t.nodes[a]];
            for (int j = 0; j < 3; ++j)
                strain.block<3, 3>(3 * a, 3 * j) = gradients(a, j) / std::sqrt(mass) * Matrix3::Identity();
        }
        const densities::Tangent tangent = densities::NeoHookean{t.mu, t.lambda}.tangent(Matrix3::Identity());
        const Eigen::Matrix<double, 12, 12> matrix = t.volume * strain * tangent * strain.transpose();
        highest = std::max(highest,
                           Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>>(matrix, Eigen::EigenvaluesOnly)
                               .eigenvalues()
                               .maxCoeff());
    }
    return 2.0 / std::sqrt(highest);
}

namespace {

/// The nodes of a step as rows keep them.
class NodesInRows : public core::MovingNodes {
  public:
    /// @param time_step  h of the step [s]
    NodesInRows(kernels::ExplicitRows &rows, double time_step) : rows_(rows), time_step_(time_step) {}

    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        for (std::size_t i = 0; i < nodes.size(); ++i)
            found[i] = in_row(std::as_const(rows_.displacement), rows_.row_of_node[nodes[i]]).cast<double>();
    }
    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double /*h*/) override {
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            in_row(rows_.displacement, rows_.row_of_node[nodes[i]]) += (time_step_ * velocity[i]).cast<float>();
            in_row(rows_.velocity, rows_.row_of_node[nodes[i]]) += velocity[i].cast<float>();
        }
    }

  private:
    kernels::ExplicitRows &rows_;
    double time_step_;
};

} // namespace

ExplicitTetrahedra::ExplicitTetrahedra(Scene given, kernels::Pressure pressure, std::unique_ptr<Energy> energy,
                                       std::span<const PointSpring> springs)
    : SimulationInRows(std::move(given)), pressure_(pressure), energy_(std::move(energy)),
      rows_(kernels::explicit_rows(scene(), pressure_, springs)) {}

void ExplicitTetrahedra::step(double time_step, int iterations) {
    rows_.aim_constrained(scene(), rest_, positions(), targets(), time_step);
    const double h = time_step / iterations;
    if (!correction_ && !ball_ && !after_step_)
        kernels::take_explicit_steps(rows_, h, scene().mass_damping, iterations);
    else
        for (int i = 0; i < iterations; ++i) {
            if (correction_)
                take_corrected_step(h);
            else
                kernels::take_explicit_steps(rows_, h, scene().mass_damping, 1);
            if (ball_)
                push_out(ball_->part(i, iterations), h);
            if (after_step_) {
                NodesInRows nodes(rows_, h);
                after_step_(nodes, static_cast<double>(i + 1) / iterations, h);
            }
        }
    take_state_from_rows();
}

double ExplicitTetrahedra::critical_time_step() const {
    if (!critical_time_step_)
        critical_time_step_ = interactive::critical_time_step(energy(), scene());
    return *critical_time_step_;
}

bool ExplicitTetrahedra::correct_steps(const std::shared_ptr<StepCorrection> &correction) {
    correction_ = correction;
    return true;
}

bool ExplicitTetrahedra::act_after_steps(const AfterStep &action) {
    after_step_ = action;
    return true;
}

Cost ExplicitTetrahedra::cost(int iterations) const {
    return cost_of((pressure_ == kernels::Pressure::around_nodes ? 2.0 : 1.0) * iterations, rows_.bytes());
}

/// After a step of length h.
void ExplicitTetrahedra::push_out(const core::BallStep &step, double h) {
    const auto position = [&](int n) { return row_position(n); };
    const auto velocity = [&](int n) { return FineRow(core::Vector3::Zero(), in_row(rows_.velocity, row_of(n))); };
    const double per_mass = h * h / (1.0 + 0.5 * scene().mass_damping * h);
    const auto yields = [&](int n) { return is_free()[n] ? per_mass / scene().node_mass[n] : 0.0; };
    const auto give = [&](int n, const core::Vector3 &force) {
        const core::Vector3 way = yields(n) * force;
        position(n) += way;
        velocity(n) += way / h;
    };
    ball_->begin_step(give);
    ball_->sweep(
        step, [&](int n) { return core::Vector3(core::Vector3(position(n)) - h * core::Vector3(velocity(n))); },
        position, [&](int n) { return Matrix3(yields(n) * Matrix3::Identity()); }, give);
    ball_->end_step(h);
}

/// Steps of (1 + alpha h / 2) v = (1 - alpha h / 2) v_before + change, and of the change that is corrected.
void ExplicitTetrahedra::take_corrected_step(double h) {
    const auto &nodes = correction_->nodes();
    const auto num_nodes = static_cast<Eigen::Index>(nodes.size());
    const double half_damping = 0.5 * scene().mass_damping * h;
    const auto row = [&](kernels::Aligned<float> &field, Eigen::Index i) { return in_row(field, row_of(nodes[i])); };
    Field x(3, num_nodes), before = x, change = x;
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
        x.col(i) = rest_.col(nodes[i]) + row(rows_.displacement, i).cast<double>();
        before.col(i) = row(rows_.velocity, i).cast<double>();
    }
    kernels::take_explicit_steps(rows_, h, scene().mass_damping, 1);
    for (Eigen::Index i = 0; i < num_nodes; ++i)
        change.col(i) =
            (1.0 + half_damping) * row(rows_.velocity, i).cast<double>() - (1.0 - half_damping) * before.col(i);
    const Field uncorrected = change;
    correction_->correct(x, before, h, change);
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
        const Eigen::Vector3f more = ((change.col(i) - uncorrected.col(i)) / (1.0 + half_damping)).cast<float>();
        row(rows_.velocity, i) += more;
        row(rows_.displacement, i) += static_cast<float>(h) * more;
    }
}

namespace {

constexpr int num_points = QuadraticTetrahedron::num_points;

/// Barycentric coordinates of a quadrature point: that of its own corner, and of the other three.
constexpr double root_5 = 2.236067977499789696409;
constexpr double near = (5.0 + 3.0 * root_5) / 20.0, far = (5.0 - root_5) / 20.0;

/// The place among the ten nodes of the middle between two corners.
constexpr std::array<std::array<int, 4>, 4> middle_of{{{-1, 4, 5, 6}, {4, -1, 7, 8}, {5, 7, -1, 9}, {6, 8, 9, -1}}};

/// Corners to points or back: the matrix of barycentric coordinates is symmetric.
QuadraticTetrahedron::AtPoints mixed(const QuadraticTetrahedron::AtPoints &of) {
    const Matrix3 shared = far * (of[0] + of[1] + of[2] + of[3]);
    QuadraticTetrahedron::AtPoints result;
    for (int k = 0; k < num_points; ++k)
        result[k] = shared + (near - far) * of[k];
    return result;
}

} // namespace

QuadraticTetrahedron::AtPoints QuadraticTetrahedron::gradients(const Field &x) const {
    AtPoints edges; // so that those at a corner, times B, are F there
    for (int k = 0; k < 4; ++k) {
        std::array<core::Vector3, 4> c;
        for (int j = 0; j < 4; ++j)
            c[j] = j == k ? core::Vector3(3.0 * x.col(nodes[k]))
                          : core::Vector3(4.0 * x.col(nodes[middle_of[k][j]]) - x.col(nodes[j]));
        for (int j = 0; j < 3; ++j)
            edges[k].col(j) = c[j + 1] - c[0];
    }
    AtPoints f = mixed(edges);
    for (auto &point_value : f)
        point_value *= inverse_edges;
    return f;
}

void QuadraticTetrahedron::add_forces(const AtPoints &stresses, Field &f) const {
    AtPoints scaled;
    for (int q = 0; q < num_points; ++q)
        scaled[q] = weight() * stresses[q] * inverse_edges.transpose();
    const AtPoints at_corners = mixed(scaled);
    for (int k = 0; k < 4; ++k) {
        std::array<core::Vector3, 4> c; // dW/dc of gradients()
        c[0] = -at_corners[k].rowwise().sum();
        for (int j = 0; j < 3; ++j)
            c[j + 1] = at_corners[k].col(j);
        for (int j = 0; j < 4; ++j)
            if (j == k) {
                f.col(nodes[k]) -= 3.0 * c[k];
            } else {
                f.col(nodes[middle_of[k][j]]) -= 4.0 * c[j];
                f.col(nodes[j]) += c[j];
            }
    }
}

Eigen::Matrix<double, 10, 3> QuadraticTetrahedron::shape_gradients(int point) const {
    Eigen::Matrix<double, 4, 3> linear;
    linear.bottomRows<3>() = inverse_edges;
    linear.row(0) = -inverse_edges.colwise().sum();
    const auto barycentric = [point](int corner) { return corner == point ? near : far; };
    Eigen::Matrix<double, 10, 3> gradients;
    for (int a = 0; a < 4; ++a)
        gradients.row(a) = (4.0 * barycentric(a) - 1.0) * linear.row(a);
    for (int e = 0; e < 6; ++e) {
        const auto [a, b] = core::tetrahedron_edges[e];
        gradients.row(4 + e) = 4.0 * (barycentric(a) * linear.row(b) + barycentric(b) * linear.row(a));
    }
    return gradients;
}

Eigen::Matrix<double, 30, 30> QuadraticTetrahedron::stiffness(const Field &x, bool is_projected) const {
    const auto f = gradients(x);
    const densities::NeoHookean density{mu, lambda};
    Eigen::Matrix<double, 30, 30> matrix = Eigen::Matrix<double, 30, 30>::Zero();
    for (int q = 0; q < num_points; ++q) {
        densities::Tangent tangent = density.tangent(f[q]);
        if (is_projected)
            tangent = densities::semi_definite_part(tangent);
        const auto slopes = shape_gradients(q);
        Eigen::Matrix<double, 30, 9> strain; // dF of unit moves
        for (int a = 0; a < 10; ++a)
            for (int j = 0; j < 3; ++j)
                strain.block<3, 3>(3 * a, 3 * j) = slopes(a, j) * Matrix3::Identity();
        matrix.noalias() += weight() * strain * tangent * strain.transpose();
    }
    return matrix;
}

QuadraticEnergy::QuadraticEnergy(const Scene &scene) {
    const auto table = core::edge_table(scene.body->mesh.tetrahedra);
    const int num_corners = scene.body->mesh.num_nodes();
    const auto linear = tetrahedra_at_rest(*scene.body);
    for (std::size_t t = 0; t < linear.size(); ++t) {
        QuadraticTetrahedron element{.nodes = {},
                                     .inverse_edges = linear[t].inverse_edges,
                                     .volume = linear[t].volume,
                                     .mu = linear[t].mu,
                                     .lambda = linear[t].lambda};
        std::ranges::copy(linear[t].nodes, element.nodes.begin());
        for (int e = 0; e < 6; ++e)
            element.nodes[4 + e] = num_corners + table.tetrahedron_edge[t][e];
        tetrahedra_.push_back(element);
    }
}

double QuadraticEnergy::value(const Field &x) const {
    double value = 0.0;
    for (const auto &t : tetrahedra_)
        for (const auto &f : t.gradients(x))
            value += t.weight() * densities::NeoHookean{t.mu, t.lambda}.value(f);
    return value;
}

void QuadraticEnergy::add_forces(const Field &x, Field &f) const {
    for (const auto &t : tetrahedra_) {
        auto at_points = t.gradients(x);
        for (auto &point_value : at_points)
            point_value = densities::NeoHookean{t.mu, t.lambda}.stress(point_value);
        t.add_forces(at_points, f);
    }
}

void QuadraticEnergy::add_hessian(const Field &x, bool is_projected, Triplets &triplets) const {
    triplets.reserve(triplets.size() + 900 * tetrahedra_.size());
    for (const auto &t : tetrahedra_) {
        const auto matrix = t.stiffness(x, is_projected);
        for (int i = 0; i < 30; ++i)
            for (int j = 0; j < 30; ++j)
                triplets.emplace_back(3 * t.nodes[i / 3] + i % 3, 3 * t.nodes[j / 3] + j % 3, matrix(i, j));
    }
}

namespace {

constexpr double corner_part = 1.0 / 36.0, edge_part = 4.0 / 27.0;

std::vector<double> volumes_around(const core::TetraMesh &mesh, const std::vector<double> &volumes) {
    std::vector<double> around(mesh.points.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            around[node] += volumes[t];
    return around;
}

std::vector<double> lumped(const core::TetraMesh &mesh, const core::EdgeTable &table,
                           const std::vector<double> &node_mass) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    const auto around = volumes_around(mesh, volumes);
    std::vector<double> masses(mesh.points.size() + table.edges.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        double mass = 0.0;
        for (const int node : mesh.tetrahedra[t])
            mass += node_mass[node] * volumes[t] / around[node];
        for (const int node : mesh.tetrahedra[t])
            masses[node] += corner_part * mass;
        for (const int edge : table.tetrahedron_edge[t])
            masses[mesh.points.size() + edge] += edge_part * mass;
    }
    return masses;
}

/// The middles of edges of boundary triangles whose corners are all constrained.
std::vector<Follower> followers(const Scene &scene, const core::EdgeTable &table) {
    const auto &mesh = scene.body->mesh;
    std::vector<int> place(mesh.points.size(), -1);
    for (std::size_t c = 0; c < scene.constrained_nodes.size(); ++c)
        place[scene.constrained_nodes[c]] = static_cast<int>(c);
    std::map<std::array<int, 2>, int> number;
    for (std::size_t e = 0; e < table.edges.size(); ++e)
        number[table.edges[e]] = static_cast<int>(e);
    std::map<int, Follower> found;
    for (const auto &corners : mesh.boundary_triangles)
        if (std::ranges::all_of(corners, [&](int corner) { return place[corner] >= 0; }))
            for (int a = 0; a < 3; ++a) {
                const int from = corners[a], to = corners[(a + 1) % 3];
                const int node = mesh.num_nodes() + number.at({std::min(from, to), std::max(from, to)});
                found.try_emplace(node, Follower{node, {place[from], place[to]}});
            }
    std::vector<Follower> result;
    for (const auto &[node, follower] : found)
        result.push_back(follower);
    return result;
}

} // namespace

Scene quadratic_scene(Scene scene) {
    const auto &mesh = scene.body->mesh;
    const auto table = core::edge_table(mesh.tetrahedra);
    scene.node_mass = lumped(mesh, table, scene.node_mass);
    scene.followers = followers(scene, table);
    for (const auto &[a, b] : table.edges)
        scene.own_nodes.emplace_back(0.5 * (mesh.points[a] + mesh.points[b]));
    return scene;
}

} // namespace livermark::interactive
