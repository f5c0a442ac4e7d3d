#include "msm/springs/springs.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/support/input_error.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

SpringLaw law_of_tetrahedra(std::string summary, std::string source,
                            std::array<double, 6> (*edge_stiffness)(const core::Body &, std::size_t)) {
    return {.name = {},
            .summary = std::move(summary),
            .source = std::move(source),
            .stiffness =
                [=](const core::Body &body, const core::EdgeTable &table) {
                    std::vector<double> stiffness(table.edges.size(), 0.0);
                    for (std::size_t t = 0; t < table.tetrahedron_edge.size(); ++t) {
                        const auto added = edge_stiffness(body, t);
                        for (std::size_t e = 0; e < 6; ++e)
                            stiffness[table.tetrahedron_edge[t][e]] += added[e];
                    }
                    return stiffness;
                },
            .edge_stiffness = edge_stiffness};
}

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
            const core::Vector3 span = node_part(x, j) - node_part(x, i);
            const double length = span.norm();
            const double stretch = length / springs_.rest_length[s];
            double extension = part_ * springs_.rest_length[s] * curve_.force(stretch);
            if (beta != 0.0)
                extension +=
                    beta * axial(stretch, Tangent::material) * span.dot(node_part(v, j) - node_part(v, i)) / length;
            double tension = springs_.stiffness[s] * extension / length;
            if (added_.size() > 0)
                tension += added(s) / length;
            node_part(force, i) += tension * span;
            node_part(force, j) -= tension * span;
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
            node_part(force, i) += pull;
            node_part(force, j) -= pull;
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
        return square_matrix(entries, x.size());
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
    /// Stiffness along the spring: never less than nothing, but for the exact derivative.
    double axial(double stretch, Tangent tangent) const {
        const double slope = part_ * curve_.slope(stretch);
        return tangent == Tangent::exact ? slope : std::max(slope, 0.0);
    }

    core::Vector3 span(const Eigen::VectorXd &x, std::size_t s) const {
        return node_part(x, springs_.edges[s][1]) - node_part(x, springs_.edges[s][0]);
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
    std::ranges::transform(springs.stiffness, core::capsule_springs(body, table), springs.stiffness.begin(),
                           std::plus());
    springs.rest_length.reserve(table.edges.size());
    for (const auto &[i, j] : table.edges)
        springs.rest_length.push_back((body.mesh.points[j] - body.mesh.points[i]).norm());
    springs.edges = std::move(table.edges);
    return springs;
}

std::shared_ptr<const ElasticTerm> spring_term(const core::SpringNetwork &springs, const ForceCurve &curve) {
    return std::make_shared<Springs>(springs, curve);
}

core::Body for_springs_beside_volume(core::Body body) {
    for (auto &material : body.materials)
        material = {material.density, 2.5 * material.shear_modulus(), 0.25};
    return body;
}

core::SpringNetwork springs_beside_volume(const core::Body &body, const SpringLaw &law) {
    return spring_network(for_springs_beside_volume(body), law);
}

double modulus_beside_springs(const core::Material &material) {
    return material.lame_lambda() - material.shear_modulus();
}

bool needs_volume(const core::Body &body) {
    constexpr double rounding = 1e-12;
    return std::ranges::any_of(body.materials, [](const auto &material) {
        return std::abs(modulus_beside_springs(material)) > rounding * material.shear_modulus();
    });
}

std::shared_ptr<const ElasticTerm> volume_beside_springs(const core::Body &body, const VolumeTerm &term) {
    std::vector<double> modulus;
    std::ranges::transform(body.materials, std::back_inserter(modulus), modulus_beside_springs);
    return term.make(body, modulus);
}

MassSprings springs_with_volume(const core::Body &body, core::SpringNetwork springs, const VolumeTerm &term,
                                const ForceCurve &curve) {
    std::vector<std::shared_ptr<const ElasticTerm>> terms{spring_term(springs, curve)};
    if (needs_volume(body))
        terms.push_back(volume_beside_springs(body, term));
    terms.push_back(inversion_guard(body));
    ElasticBody elastic(springs.node_mass, std::move(terms));
    return {std::move(springs), std::move(elastic)};
}

const VolumeTerm &find_volume_term(std::string_view name) {
    return support::find_named(all_volume_terms(), std::string(name), "volume term");
}

namespace {

/// Part of its volume below which a tetrahedron is pushed back.
constexpr double smallest_part = 0.5;
/// Stiffness over that of the material: enough to hold a box pressed by 0.4 of its Young's modulus. Without the guard
/// it gives way below 0.2.
constexpr double stiffening = 4.0;

double modulus(const core::Material &material) {
    return stiffening * (material.lame_lambda() + 2.0 * material.shear_modulus());
}

class InversionGuard : public ElasticTerm {
  public:
    explicit InversionGuard(const core::Body &body) : tetrahedra_(body.mesh.tetrahedra) {
        const auto volumes = core::tetrahedron_volumes(body.mesh);
        for (std::size_t t = 0; t < volumes.size(); ++t) {
            const auto material = body.material_of(t);
            least_volume_.push_back(smallest_part * volumes[t]);
            modulus_per_volume_.push_back(modulus(material) / volumes[t]);
        }
    }

    double energy(const Eigen::VectorXd &x) const override {
        double energy = 0.0;
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const double deficit = least_volume_[t] - volume_gradient(x, tetrahedra_[t]).volume;
            if (deficit > 0.0)
                energy += 0.5 * modulus_per_volume_[t] * deficit * deficit;
        }
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd & /*v*/, double /*beta*/,
                   Eigen::VectorXd &force) const override {
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto [volume, gradient] = volume_gradient(x, tetrahedra_[t]);
            const double deficit = least_volume_[t] - volume;
            if (deficit > 0.0)
                for (int a = 0; a < 4; ++a)
                    node_part(force, tetrahedra_[t][a]) += modulus_per_volume_[t] * deficit * gradient[a];
        }
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        return sum_of_blocks(tetrahedra_, x.size(), [&](std::size_t t) { return tetrahedron_hessian(x, t, tangent); });
    }

    void add_block_bound(const Eigen::VectorXd & /*x*/, std::vector<Eigen::Matrix3d> & /*blocks*/) const override {}

    bool describe(StepParts &parts) const override {
        parts.tetrahedra = tetrahedra_;
        parts.least_volume = least_volume_;
        parts.guard_stiffness = modulus_per_volume_;
        return true;
    }

  private:
    Matrix12 tetrahedron_hessian(const Eigen::VectorXd &x, std::size_t t, Tangent tangent) const {
        const auto [volume, gradient] = volume_gradient(x, tetrahedra_[t]);
        const double deficit = least_volume_[t] - volume;
        if (tangent == Tangent::material || deficit <= 0.0)
            return Matrix12::Zero();
        Eigen::Matrix<double, 12, 1> slope;
        for (int a = 0; a < 4; ++a)
            slope.segment<3>(3 * a) = gradient[a];
        Matrix12 hessian = slope * slope.transpose();
        if (tangent == Tangent::exact)
            hessian -= deficit * volume_hessian(x, tetrahedra_[t]);
        return modulus_per_volume_[t] * hessian;
    }

    std::vector<std::array<int, 4>> tetrahedra_;
    std::vector<double> least_volume_;       // (M) [m^3]
    std::vector<double> modulus_per_volume_; // (M) [Pa/m^3]
};

} // namespace

std::shared_ptr<const ElasticTerm> inversion_guard(const core::Body &body) {
    return std::make_shared<InversionGuard>(body);
}

std::shared_ptr<const ElasticTerm> pressed_guard(const core::Body &body) {
    ControlVolumes tetrahedra;
    tetrahedra.share.resize(body.mesh.num_tetrahedra(), body.mesh.num_tetrahedra());
    tetrahedra.share.setIdentity();
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
        tetrahedra.modulus.push_back(modulus(body.material_of(t)));
    return volume_penalty(body.mesh, tetrahedra);
}

} // namespace livermark::msm
