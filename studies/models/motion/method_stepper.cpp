#include "studies/models/motion/moving_method.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/equilibrium.hpp"
#include "interactive/method.hpp"
#include "msm/dynamics/time_step.hpp"

namespace livermark::models {

namespace {

using interactive::Field;
using interactive::Scene;
using interactive::Simulation;

/// Accuracy of squared frequencies: as in interactive::critical_time_step().
constexpr double frequency_accuracy = 1e-4;

auto as_field(const Eigen::VectorXd &components) {
    return Eigen::Map<const Field>(components.data(), 3, components.size() / 3);
}

/// The energy of an interactive method, for what msm asks of the terms of a body.
class EnergyTerm : public msm::ElasticTerm {
  public:
    /// @param length  of differences of forces [m]
    EnergyTerm(const interactive::Energy &energy, double length) : energy_(&energy), length_(length) {}

    double energy(const Eigen::VectorXd &x) const override { return energy_->value(as_field(x)); }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        Field forces = Field::Zero(3, x.size() / 3);
        energy_->add_forces(as_field(x), forces);
        const double largest = beta == 0.0 ? 0.0 : v.cwiseAbs().maxCoeff();
        if (largest > 0.0) {
            const double factor = length_ / largest;
            Field behind = Field::Zero(3, forces.cols()), ahead = behind;
            energy_->add_forces(as_field(x) - factor * as_field(v), behind);
            energy_->add_forces(as_field(x) + factor * as_field(v), ahead);
            forces += beta / (2.0 * factor) * (ahead - behind);
        }
        force += Eigen::Map<const Eigen::VectorXd>(forces.data(), forces.size());
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, msm::Tangent tangent) const override {
        interactive::Energy::Triplets triplets;
        energy_->add_hessian(as_field(x), tangent != msm::Tangent::exact, triplets);
        Eigen::SparseMatrix<double> matrix(x.size(), x.size());
        matrix.setFromTriplets(triplets.begin(), triplets.end());
        return matrix;
    }

    /// Each entry by the mean of the squares that it is a product of.
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        const auto matrix = hessian(x, msm::Tangent::material);
        for (Eigen::Index column = 0; column < matrix.outerSize(); ++column)
            for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, column); entry; ++entry)
                blocks[column / 3](column % 3, column % 3) += std::abs(entry.value());
    }

  private:
    const interactive::Energy *energy_;
    double length_;
};

msm::ElasticBody elastic_body(const Simulation &at_rest) {
    // As small against an element as leaves half of the digits.
    constexpr double part_of_body = 1e-7;
    const double length = part_of_body * core::extent(at_rest.scene().body->mesh.points);
    return {at_rest.scene().node_mass, {std::make_shared<EnergyTerm>(at_rest.energy(), length)}};
}

std::vector<core::Vector3> points_of(const Scene &scene) {
    auto points = scene.body->mesh.points;
    points.insert(points.end(), scene.own_nodes.begin(), scene.own_nodes.end());
    return points;
}

msm::NodalConditions conditions_of(const Scene &scene) {
    msm::NodalConditions conditions;
    constexpr double free = std::numeric_limits<double>::quiet_NaN();
    for (const bool is_free : interactive::free_nodes(scene))
        conditions.displacement.emplace_back(core::Vector3::Constant(is_free ? free : 0.0));
    return conditions;
}

/// The same materials on the four corners that each quadratic tetrahedron has, an eighth of it each, so that all ten
/// nodes are those of a mesh.
core::Body with_own_nodes(const Scene &scene) {
    core::Body body = *scene.body;
    if (scene.own_nodes.empty())
        return body;
    const auto table = core::edge_table(scene.body->mesh.tetrahedra);
    const int mesh_nodes = scene.body->mesh.num_nodes();
    constexpr std::array<std::array<std::size_t, 3>, 4> edges_at{{{0, 1, 2}, {0, 4, 3}, {1, 3, 5}, {2, 5, 4}}};
    body.mesh.points = points_of(scene);
    body.mesh.tetrahedra.clear();
    body.mesh.region.clear();
    for (std::size_t t = 0; t < scene.body->mesh.tetrahedra.size(); ++t)
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const auto middle = [&](std::size_t k) {
                return mesh_nodes + table.tetrahedron_edge[t][edges_at[corner][k]];
            };
            body.mesh.tetrahedra.push_back({scene.body->mesh.tetrahedra[t][corner], middle(0), middle(1), middle(2)});
            body.mesh.region.push_back(scene.body->mesh.region[t]);
        }
    return body;
}

class MassCorrection : public interactive::StepCorrection {
  public:
    explicit MassCorrection(msm::MassScaling scaling) : scaling_(std::move(scaling)) {
        for (const auto &part : scaling_.parts)
            nodes_.insert(nodes_.end(), part.nodes.begin(), part.nodes.end());
    }

    const std::vector<int> &nodes() const override { return nodes_; }

    void correct(const Field &x, const Field &before, double step, Field &change) override {
        Eigen::Index first = 0;
        for (const auto &part : scaling_.parts) {
            const auto size = static_cast<Eigen::Index>(part.nodes.size());
            Field acceleration = change.middleCols(first, size) / step;
            msm::scale_acceleration(part, x.middleCols(first, size), before.middleCols(first, size), acceleration);
            change.middleCols(first, size) = step * acceleration;
            first += size;
        }
    }

  private:
    msm::MassScaling scaling_;
    std::vector<int> nodes_;
};

} // namespace

msm::MassScaling scale_masses(const Simulation &at_rest) {
    return msm::scale_masses(with_own_nodes(at_rest.scene()), elastic_body(at_rest), conditions_of(at_rest.scene()));
}

msm::MassScaling constrained(const msm::MassScaling &scaling, const Scene &scene) {
    return msm::constrained(scaling, conditions_of(scene));
}

double critical_time_step(const Simulation &at_rest, const msm::MassScaling &scaling) {
    const double highest = msm::largest_angular_frequency(elastic_body(at_rest), points_of(at_rest.scene()),
                                                          conditions_of(at_rest.scene()), scaling, frequency_accuracy);
    return highest > 0.0 ? 2.0 / highest : std::numeric_limits<double>::infinity();
}

std::shared_ptr<interactive::StepCorrection> correction_of(msm::MassScaling scaling) {
    if (scaling.parts.empty())
        return nullptr;
    return std::make_shared<MassCorrection>(std::move(scaling));
}

namespace {

using interactive::Method;

/// An interactive method.
class MethodStepper : public Stepper {
  public:
    MethodStepper(Method method, const NodalProblem &problem, const core::NodalConditions &once_released,
                  const StepperOptions &options)
        : method_(std::move(method)), scene_{.body = problem.body,
                                             .node_mass = problem.node_mass,
                                             .constrained_nodes = held_nodes(problem.conditions),
                                             .mass_damping = options.mass_damping},
          simulation_(method_.prepare(scene_)) {
        apply(problem);
        if (method_.is_explicit) {
            // One step for the whole motion: what is held less has the higher frequencies, but where held nodes leave a
            // scaled part.
            auto released = scene_;
            released.constrained_nodes = held_nodes(once_released);
            const auto released_body = method_.prepare(released);
            if (options.scales_masses)
                scaling_ = scale_masses(*released_body);
            critical_ = critical_step(*released_body);
            if (!scaling_.parts.empty())
                critical_ = std::min(critical_, critical_step(*simulation_));
        }
        correct_steps();
    }

    void prepare(double time_step) override {
        if (time_step != time_step_)
            simulation_->prepare(time_step_ = time_step);
    }
    void step(double time_step, int iterations) override { simulation_->step(time_step, iterations); }
    double critical_time_step() const override { return critical_; }
    bool counts_iterations() const override { return true; }

    void lead(std::span<const int> nodes, std::span<const core::Vector3> displacement) override {
        Field targets = simulation_->targets();
        for (std::size_t i = 0; i < nodes.size(); ++i)
            targets.col(column_of(nodes[i])) = scene_.body->mesh.points[nodes[i]] + displacement[i];
        simulation_->set_targets(targets);
    }

    void hold(const core::NodalConditions &conditions) override {
        const Field positions = simulation_->positions(), velocities = simulation_->velocities(),
                    forces = simulation_->external_forces();
        scene_.constrained_nodes = held_nodes(conditions);
        simulation_ = method_.prepare(scene_);
        simulation_->set_external_forces(forces);
        simulation_->set_state(positions, velocities);
        correct_steps();
        prepare_again();
    }

    void cut(const NodalProblem &after, const std::vector<int> &parent_tetrahedron) override {
        simulation_ = livermark::interactive::continue_after_cut(
            method_, *simulation_,
            {.body = after.body, .node_mass = after.node_mass, .parent_tetrahedron = parent_tetrahedron});
        apply(after);
        prepare_again();
    }

    /// In four parts each where the method has nodes of its own in the middle of edges. Sides are half as long then, so
    /// penalties are twice as large.
    std::vector<core::TouchedFacet> touched_facets(std::vector<core::TouchedFacet> facets) const override {
        const auto &mesh = scene_.body->mesh;
        const auto &own_nodes = simulation_->scene().own_nodes;
        if (own_nodes.empty())
            return facets;
        const auto table = core::edge_table(mesh.tetrahedra);
        if (table.edges.size() != own_nodes.size())
            throw std::logic_error("nodes of a method that are in the middle of no edge");
        const auto middle = [&](int a, int b) {
            const auto edge = std::ranges::lower_bound(table.edges, std::array{std::min(a, b), std::max(a, b)});
            return mesh.num_nodes() + static_cast<int>(edge - table.edges.begin());
        };
        std::vector<core::TouchedFacet> parts;
        for (const auto &facet : facets) {
            const auto [a, b, c] = facet.nodes;
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            for (const auto &nodes : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}})
                parts.push_back({nodes, 0.25 * facet.area, facet.normal, 0.5 * facet.side, facet.modulus});
        }
        return parts;
    }

    void touch(std::shared_ptr<core::BallContact> ball) override {
        if (!simulation_->touch(ball) && ball)
            throw std::logic_error("the method knows no contact");
    }
    void act_after_steps(core::AfterStep action) override { simulation_->act_after_steps(action); }

    core::Vector3 position(int node) const override { return simulation_->positions().col(node); }

    std::vector<core::Vector3> displacement() const override {
        auto result = simulation_->scene().body->mesh.points;
        for (std::size_t i = 0; i < result.size(); ++i)
            result[i] = simulation_->positions().col(static_cast<Eigen::Index>(i)) - result[i];
        return result;
    }

    void start_from(const std::vector<core::Vector3> &displacement) override {
        const auto &points = scene_.body->mesh.points;
        Field positions = simulation_->positions();
        for (std::size_t i = 0; i < points.size(); ++i)
            positions.col(static_cast<Eigen::Index>(i)) = points[i] + displacement[i];
        simulation_->set_state(positions, Field::Zero(3, positions.cols()));
    }

    void take_motion_of(const Stepper &other) override {
        const auto &moving = *dynamic_cast<const MethodStepper &>(other).simulation_;
        simulation_->set_external_forces(moving.external_forces());
        simulation_->set_state(moving.positions(), moving.velocities());
    }

    core::Vector3 elastic_force(std::span<const int> held) const override {
        const Field reactions = simulation_->reactions();
        Field on_held(3, static_cast<Eigen::Index>(held.size()));
        for (std::size_t i = 0; i < held.size(); ++i)
            on_held.col(static_cast<Eigen::Index>(i)) = reactions.col(column_of(held[i]));
        return -on_held.rowwise().sum();
    }

    std::vector<double> per_mass() const override {
        const auto is_free = free_nodes(simulation_->scene());
        std::vector<double> result;
        for (std::size_t node = 0; node < is_free.size(); ++node)
            result.push_back(is_free[node] ? 1.0 / simulation_->scene().node_mass[node] : 0.0);
        return result;
    }

    FrameCost cost(const Effort &effort) const override {
        const auto cost = simulation_->cost(effort.iterations);
        return {cost.element_passes * effort.steps, cost.bytes_per_element};
    }

    Eigen::MatrixXf converged_response(const core::PlaceWeights &weights, double frame) const override {
        return livermark::interactive::place_response(*simulation_, frame, weights);
    }
    Eigen::MatrixXf observed_response(const core::PlaceWeights &weights, double frame, const Effort &effort,
                                      double force) const override {
        const auto at_rest = method_.prepare(simulation_->scene());
        return livermark::interactive::observed_place_response(*at_rest, frame, effort.steps, effort.iterations,
                                                               weights, force);
    }

    void load(std::span<const int> nodes, std::span<const core::Vector3> force) override {
        Field forces = Field::Zero(3, simulation_->positions().cols());
        for (std::size_t i = 0; i < nodes.size(); ++i)
            forces.col(nodes[i]) = force[i];
        simulation_->set_external_forces(forces);
    }

    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        const auto &rest = simulation_->scene().body->mesh.points;
        for (std::size_t i = 0; i < nodes.size(); ++i)
            found[i] = simulation_->positions().col(nodes[i]) - rest[nodes[i]];
    }
    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) override {
        Field change = Field::Zero(3, simulation_->positions().cols());
        for (std::size_t i = 0; i < nodes.size(); ++i)
            change.col(nodes[i]) = velocity[i];
        simulation_->kick(change, time_step);
    }

  private:
    static std::vector<int> held_nodes(const core::NodalConditions &conditions) {
        std::vector<int> nodes;
        for (std::size_t i = 0; i < conditions.displacement.size(); ++i)
            if (conditions.constrains(i))
                nodes.push_back(static_cast<int>(i));
        return nodes;
    }

    /// Column of a constrained node in targets and reactions.
    Eigen::Index column_of(int node) const {
        return std::ranges::lower_bound(scene_.constrained_nodes, node) - scene_.constrained_nodes.begin();
    }

    void apply(const NodalProblem &problem) {
        Field forces(3, static_cast<Eigen::Index>(problem.node_mass.size()));
        for (std::size_t i = 0; i < problem.node_mass.size(); ++i)
            forces.col(static_cast<Eigen::Index>(i)) = problem.conditions.force[i];
        simulation_->set_external_forces(forces);
        auto targets = simulation_->targets();
        const auto &nodes = simulation_->scene().constrained_nodes;
        for (std::size_t c = 0; c < nodes.size(); ++c)
            targets.col(static_cast<Eigen::Index>(c)) =
                problem.body->mesh.points[nodes[c]] + problem.conditions.displacement[nodes[c]];
        simulation_->set_targets(targets);
    }

    double critical_step(const Simulation &at_rest) const {
        return scaling_.parts.empty() ? at_rest.critical_time_step()
                                      : models::critical_time_step(at_rest, constrained(scaling_, at_rest.scene()));
    }

    void correct_steps() {
        if (const auto correction = correction_of(constrained(scaling_, scene_)))
            simulation_->correct_steps(correction);
    }

    void prepare_again() {
        if (time_step_ > 0.0)
            simulation_->prepare(time_step_);
    }

    Method method_;
    Scene scene_;
    std::unique_ptr<Simulation> simulation_;
    msm::MassScaling scaling_;
    double critical_ = std::numeric_limits<double>::infinity(), time_step_ = 0.0; ///< [s]
};

} // namespace

std::unique_ptr<Stepper> method_stepper(const Method &method, const NodalProblem &problem,
                                        const core::NodalConditions &once_released, const StepperOptions &options) {
    return std::make_unique<MethodStepper>(method, problem, once_released, options);
}

} // namespace livermark::models
