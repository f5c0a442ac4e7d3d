#include "studies/models/motion/scaled_masses.hpp"

#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
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

} // namespace livermark::models
