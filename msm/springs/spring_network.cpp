#include "msm/springs/spring_network.hpp"

#include <algorithm>

#include "msm/dynamics/step_parts.hpp"
#include "msm/mass_lumping.hpp"
#include "msm/viscoelastic/relaxing_term.hpp"

namespace livermark::msm {

namespace {

class Springs : public RelaxingTerm {
  public:
    Springs(const core::SpringNetwork &springs, const ForceCurve &curve) : springs_(springs), curve_(curve) {}

    double energy(const Eigen::VectorXd &x) const override {
        double energy = 0.0;
        for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
            const double rest_length = springs_.rest_length[s];
            const double length = span(x, s).norm();
            energy += part_ * springs_.stiffness[s] * rest_length * rest_length * curve_.energy(length / rest_length);
            if (added_.size() > 0)
                energy += added(s) * (length - rest_length);
        }
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
            const auto [i, j] = springs_.edges[s];
            const core::Vector3 span = of_node(x, j) - of_node(x, i);
            const double length = span.norm();
            const double stretch = length / springs_.rest_length[s];
            double extension = part_ * springs_.rest_length[s] * curve_.force(stretch);
            if (beta != 0.0)
                extension +=
                    beta * axial(stretch, Tangent::material) * span.dot(of_node(v, j) - of_node(v, i)) / length;
            double tension = springs_.stiffness[s] * extension / length;
            if (added_.size() > 0)
                tension += added(s) / length;
            of_node(force, i) += tension * span;
            of_node(force, j) -= tension * span;
        }
    }

    Eigen::VectorXd relaxing_stress(const Eigen::VectorXd &x) const override {
        Eigen::VectorXd tension(static_cast<Eigen::Index>(springs_.edges.size()));
        for (std::size_t s = 0; s < springs_.edges.size(); ++s)
            tension[static_cast<Eigen::Index>(s)] = part_ * springs_.stiffness[s] * springs_.rest_length[s] *
                                                    curve_.force(span(x, s).norm() / springs_.rest_length[s]);
        return tension;
    }

    void add_force_of(const Eigen::VectorXd &x, const Eigen::VectorXd &stress, Eigen::VectorXd &force) const override {
        for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
            const auto [i, j] = springs_.edges[s];
            const core::Vector3 pull = stress[static_cast<Eigen::Index>(s)] * span(x, s).normalized();
            of_node(force, i) += pull;
            of_node(force, j) -= pull;
        }
    }

    Eigen::VectorXd relaxing_compliance() const override {
        Eigen::VectorXd compliance(static_cast<Eigen::Index>(springs_.stiffness.size()));
        std::ranges::transform(springs_.stiffness, compliance.begin(), [this](double stiffness) {
            return part_ * stiffness != 0.0 ? 1.0 / (part_ * stiffness) : 0.0; // without stiffness there is no stress
        });
        return compliance;
    }

    std::shared_ptr<const RelaxingTerm> relaxed(double part, const Eigen::VectorXd &added) const override {
        auto term = std::make_shared<Springs>(*this);
        term->part_ = part * part_;
        term->added_ = added;
        return term;
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(36 * springs_.edges.size());
        const auto add = [&entries](int row, int column, const Eigen::Matrix3d &block, double sign) {
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b)
                    entries.emplace_back(3 * row + a, 3 * column + b, sign * block(a, b));
        };
        for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
            const auto [i, j] = springs_.edges[s];
            const core::Vector3 span = this->span(x, s);
            const core::Vector3 direction = span.normalized();
            const double stretch = span.norm() / springs_.rest_length[s];
            double transverse = part_ * curve_.force(stretch) / stretch;
            if (added_.size() > 0 && added(s) != 0.0) // so there is a stiffness
                transverse += added(s) / (springs_.stiffness[s] * span.norm());
            if (tangent == Tangent::semi_definite)
                transverse = std::max(transverse, 0.0);
            else if (tangent == Tangent::material)
                transverse = 0.0;
            const Eigen::Matrix3d along = direction * direction.transpose();
            const Eigen::Matrix3d block = springs_.stiffness[s] * (axial(stretch, tangent) * along +
                                                                   transverse * (Eigen::Matrix3d::Identity() - along));
            add(i, i, block, 1.0);
            add(j, j, block, 1.0);
            add(i, j, block, -1.0);
            add(j, i, block, -1.0);
        }
        Eigen::SparseMatrix<double> hessian(x.size(), x.size());
        hessian.setFromTriplets(entries.begin(), entries.end());
        return hessian;
    }

    /// (n . (u_i - u_j))^2 <= 2 (n . u_i)^2 + 2 (n . u_j)^2
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (std::size_t s = 0; s < springs_.edges.size(); ++s) {
            const core::Vector3 span = this->span(x, s);
            const core::Vector3 direction = span.normalized();
            const double stiffness =
                springs_.stiffness[s] * axial(span.norm() / springs_.rest_length[s], Tangent::material);
            const Eigen::Matrix3d block = 2.0 * stiffness * direction * direction.transpose();
            for (const int node : springs_.edges[s])
                blocks[node] += block;
        }
    }

    bool describe(StepParts &parts) const override {
        if (curve_.force != hooke.force || part_ != 1.0 || added_.size() > 0)
            return false;
        parts.edges = springs_.edges;
        parts.stiffness = springs_.stiffness;
        parts.rest_length = springs_.rest_length;
        return true;
    }

  private:
    /// What is stiff along the spring: never less than nothing, but for the exact derivative.
    double axial(double stretch, Tangent tangent) const {
        const double slope = part_ * curve_.slope(stretch);
        return tangent == Tangent::exact ? slope : std::max(slope, 0.0);
    }

    core::Vector3 span(const Eigen::VectorXd &x, std::size_t s) const {
        return of_node(x, springs_.edges[s][1]) - of_node(x, springs_.edges[s][0]);
    }

    double added(std::size_t s) const { return added_[static_cast<Eigen::Index>(s)]; }

    core::SpringNetwork springs_;
    ForceCurve curve_;
    double part_ = 1.0;     // see RelaxingTerm::relaxed()
    Eigen::VectorXd added_; // (S) [N], or empty
};

} // namespace

core::SpringNetwork spring_network(const core::Body &body, const SpringLaw &law) {
    auto table = core::edge_table(body.mesh.tetrahedra);
    core::SpringNetwork springs;
    springs.node_mass = lumped_masses(body);
    springs.stiffness = law.stiffness(body, table);
    springs.rest_length.reserve(table.edges.size());
    for (const auto &[i, j] : table.edges)
        springs.rest_length.push_back((body.mesh.points[j] - body.mesh.points[i]).norm());
    springs.edges = std::move(table.edges);
    return springs;
}

std::shared_ptr<const ElasticTerm> spring_term(const core::SpringNetwork &springs) {
    return spring_term(springs, hooke);
}

std::shared_ptr<const ElasticTerm> spring_term(const core::SpringNetwork &springs, const ForceCurve &curve) {
    return std::make_shared<Springs>(springs, curve);
}

} // namespace livermark::msm
