#include "msm/springs/springs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "msm/elastic_body.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

NodalParts nodal_parts(const core::Body &body) {
    const auto &mesh = body.mesh;
    NodalParts parts;
    parts.tetrahedron_volume = core::tetrahedron_volumes(mesh);
    parts.at_corner.resize(mesh.tetrahedra.size());
    std::map<std::pair<int, int>, int> number; // of each node and region
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (int corner = 0; corner < 4; ++corner) {
            const int node = mesh.tetrahedra[t][corner];
            const auto [place, is_new] = number.try_emplace({node, mesh.region[t]}, static_cast<int>(number.size()));
            if (is_new) {
                parts.node.push_back(node);
                parts.region.push_back(mesh.region[t]);
                parts.volume.push_back(0.0);
                parts.modulus_factor.push_back(0.0);
            }
            parts.at_corner[t][corner] = place->second;
            const double share = parts.tetrahedron_volume[t] / 4.0;
            parts.volume[place->second] += share;
            parts.modulus_factor[place->second] += share * body.modulus_factor_of(t);
        }
    for (std::size_t c = 0; c < parts.volume.size(); ++c)
        parts.modulus_factor[c] = body.modulus_factor.empty() ? 1.0 : parts.modulus_factor[c] / parts.volume[c];
    return parts;
}

namespace {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

class VolumePenalty : public ElasticTerm {
  public:
    VolumePenalty(const core::TetraMesh &mesh, const ControlVolumes &parts)
        : tetrahedra_(mesh.tetrahedra), share_(parts.share), centre_(parts.centre), mean_(parts.mean),
          measure_(parts.measure),
          modulus_(Eigen::VectorXd::Map(parts.modulus.data(), static_cast<Eigen::Index>(parts.modulus.size()))),
          tetrahedron_volume_(volumes(to_unknowns(mesh.points))), rest_volume_(share_ * tetrahedron_volume_) {}

    double energy(const Eigen::VectorXd &x) const override { return energy_of_change(resisted_change(volumes(x))); }

    double add_force_and_energy(const Eigen::VectorXd &x, Eigen::VectorXd &force) const override {
        const Eigen::VectorXd change = resisted_change(volumes(x));
        const double energy = energy_of_change(change);
        if (std::isfinite(energy))
            add_force_of(x, slopes(change), force);
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        Eigen::VectorXd volume(static_cast<Eigen::Index>(tetrahedra_.size()));
        Eigen::VectorXd rate = Eigen::VectorXd::Zero(beta != 0.0 ? volume.size() : 0);
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto [now, gradient] = volume_gradient(x, tetrahedra_[t]);
            volume[static_cast<Eigen::Index>(t)] = now;
            if (beta != 0.0)
                for (int a = 0; a < 4; ++a)
                    rate[static_cast<Eigen::Index>(t)] += gradient[a].dot(node_part(v, tetrahedra_[t][a]));
        }
        Eigen::VectorXd push = slopes(resisted_change(volume));
        if (beta != 0.0)
            push += beta * mean_change(share_ * rate);
        add_force_of(x, push, force);
    }

    void add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                             Eigen::VectorXd &product) const override {
        const Eigen::VectorXd change = resisted_change(volumes(x));
        Eigen::VectorXd added(static_cast<Eigen::Index>(tetrahedra_.size())); // to the volumes
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto gradient = volume_gradient(x, tetrahedra_[t]).gradient;
            double &sum = added[static_cast<Eigen::Index>(t)] = 0.0;
            for (int a = 0; a < 4; ++a)
                sum += gradient[a].dot(node_part(u, tetrahedra_[t][a]));
        }
        const Eigen::VectorXd there = share_.transpose() * pressure(slopes(change));
        const Eigen::VectorXd more =
            share_.transpose() * pressure(curvatures(change).cwiseProduct(mean_change(share_ * added)));
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto gradient = volume_gradient(x, tetrahedra_[t]).gradient;
            const auto turn = volume_gradient_change(x, u, tetrahedra_[t]);
            for (int a = 0; a < 4; ++a)
                node_part(product, tetrahedra_[t][a]) +=
                    more[static_cast<Eigen::Index>(t)] * gradient[a] + there[static_cast<Eigen::Index>(t)] * turn[a];
        }
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        const SparseRows gradient = resisted_change_gradients(x);
        Eigen::VectorXd factor = modulus_.cwiseProduct(rest_volume_);
        if (tangent != Tangent::material)
            factor = factor.cwiseProduct(curvatures(resisted_change(volumes(x))));
        if (tangent == Tangent::semi_definite)
            factor = factor.cwiseMax(0.0);
        const SparseRows scaled = factor.asDiagonal() * gradient;
        Eigen::SparseMatrix<double> hessian = SparseRows(gradient.transpose()) * scaled;
        if (tangent == Tangent::exact)
            hessian += geometric_part(x);
        return hessian;
    }

    /// (sum_j g_j . u_j)^2 <= (sum_j |g_j|) sum_j (g_j . u_j)^2 / |g_j|
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        const SparseRows gradient = resisted_change_gradients(x);
        for (Eigen::Index c = 0; c < gradient.outerSize(); ++c) {
            std::vector<std::pair<Eigen::Index, core::Vector3>> corners;
            double sum = 0.0;
            for (SparseRows::InnerIterator entry(gradient, c); entry; ++entry) {
                if (entry.col() % 3 == 0)
                    corners.emplace_back(entry.col() / 3, core::Vector3::Zero());
                corners.back().second[entry.col() % 3] = entry.value();
            }
            for (const auto &[node, g] : corners)
                sum += g.norm();
            const double factor = std::max(modulus_[c], 0.0) * rest_volume_[c] * sum;
            for (const auto &[node, g] : corners)
                if (g.norm() > 0.0)
                    blocks[node] += factor / g.norm() * g * g.transpose();
        }
    }

    bool describe(StepParts &parts) const override {
        const bool has_means = mean_.size() > 0;
        if ((parts.resisted_change && parts.resisted_change != measure_) || (has_means && !has_means_over_corners()))
            return false;
        parts.resisted_change = measure_;
        parts.averages_volumes = has_means;
        const Eigen::VectorXd stiffness = modulus_.cwiseQuotient(rest_volume_);
        parts.tetrahedra = tetrahedra_;
        if (centre_.empty())
            return describe_tetrahedra(stiffness, parts);
        parts.volume_stiffness.assign(stiffness.begin(), stiffness.end());
        std::vector<std::array<int, 4>> corner_volume(tetrahedra_.size());
        for (int c = 0; c < share_.rows(); ++c)
            for (SparseRows::InnerIterator entry(share_, c); entry; ++entry) {
                const auto &corners = tetrahedra_[entry.col()];
                corner_volume[entry.col()][std::ranges::find(corners, centre_[c]) - corners.begin()] = c;
            }
        return describe_volumes(centre_, corner_volume, parts);
    }

  private:
    /// Whether the means are those of mean_volumes_around_nodes().
    bool has_means_over_corners() const {
        const SparseRows volume = share_ * tetrahedron_volume_.asDiagonal() * SparseRows(share_.transpose());
        const SparseRows difference = mean_ - SparseRows(rest_volume_.cwiseInverse().asDiagonal() * volume);
        return !centre_.empty() && difference.norm() < 1e-12 * mean_.norm();
    }

    /// @return false unless each tetrahedron is a control volume of its own
    bool describe_tetrahedra(const Eigen::VectorXd &stiffness, StepParts &parts) const {
        if (share_.rows() != share_.cols() || share_.nonZeros() != share_.rows())
            return false;
        for (int c = 0; c < share_.rows(); ++c)
            if (share_.coeff(c, c) != 1.0)
                return false;
        parts.tetrahedron_stiffness.assign(stiffness.begin(), stiffness.end());
        return true;
    }

    double energy_of_change(const Eigen::VectorXd &change) const {
        double energy = 0.0;
        for (Eigen::Index c = 0; c < change.size(); ++c) {
            const double value = measure_(change[c]).value;
            energy += 0.5 * modulus_[c] * rest_volume_[c] * value * value;
        }
        return energy;
    }

    /// @param push  shape (C) slopes()
    void add_force_of(const Eigen::VectorXd &x, const Eigen::VectorXd &push, Eigen::VectorXd &force) const {
        // The gradients are found again because that costs less than to keep them in memory.
        const Eigen::VectorXd tetrahedron_pressure = share_.transpose() * pressure(push);
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto gradient = volume_gradient(x, tetrahedra_[t]).gradient;
            for (int a = 0; a < 4; ++a)
                node_part(force, tetrahedra_[t][a]) -= tetrahedron_pressure[static_cast<Eigen::Index>(t)] * gradient[a];
        }
    }

    Eigen::VectorXd volumes(const Eigen::VectorXd &x) const {
        Eigen::VectorXd volume(static_cast<Eigen::Index>(tetrahedra_.size()));
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            volume[static_cast<Eigen::Index>(t)] = volume_gradient(x, tetrahedra_[t]).volume;
        return volume;
    }

    /// Means of changes of control volumes [m^3], relative ones or the means of these.
    Eigen::VectorXd mean_change(const Eigen::VectorXd &change) const {
        const Eigen::VectorXd relative = change.cwiseQuotient(rest_volume_);
        return mean_.size() > 0 ? Eigen::VectorXd(mean_ * relative) : relative;
    }

    /// Changes that the energy is made of: e_c = V_c / V0_c - 1, or the means of these.
    Eigen::VectorXd resisted_change(const Eigen::VectorXd &tetrahedron_volume) const {
        return mean_change(share_ * tetrahedron_volume - rest_volume_);
    }

    /// g g' of each, the derivative of g^2 / 2
    Eigen::VectorXd slopes(const Eigen::VectorXd &change) const {
        return change.unaryExpr([this](double one) {
            const auto [value, slope, curvature] = measure_(one);
            return value * slope;
        });
    }

    /// The second derivative of g^2 / 2
    Eigen::VectorXd curvatures(const Eigen::VectorXd &change) const {
        return change.unaryExpr([this](double one) {
            const auto [value, slope, curvature] = measure_(one);
            return slope * slope + value * curvature;
        });
    }

    /// (C, 3N) its derivative [1/m]
    SparseRows resisted_change_gradients(const Eigen::VectorXd &x) const {
        const SparseRows gradient = rest_volume_.cwiseInverse().asDiagonal() * SparseRows(share_ * volume_gradients(x));
        return mean_.size() > 0 ? SparseRows(mean_ * gradient) : gradient;
    }

    /// Pressure in each control volume, dU/dV_c [Pa].
    /// @param push  shape (C) slopes()
    Eigen::VectorXd pressure(const Eigen::VectorXd &push) const {
        if (mean_.size() == 0)
            return modulus_.cwiseProduct(push);
        return (mean_.transpose() * modulus_.cwiseProduct(rest_volume_).cwiseProduct(push)).cwiseQuotient(rest_volume_);
    }

    /// (M, 3N) grad V_t
    SparseRows volume_gradients(const Eigen::VectorXd &x) const {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(12 * tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            const auto gradient = volume_gradient(x, tetrahedra_[t]).gradient;
            for (int a = 0; a < 4; ++a)
                for (int c = 0; c < 3; ++c)
                    entries.emplace_back(t, 3 * tetrahedra_[t][a] + c, gradient[a][c]);
        }
        SparseRows matrix(static_cast<Eigen::Index>(tetrahedra_.size()), x.size());
        matrix.setFromTriplets(entries.begin(), entries.end());
        return matrix;
    }

    Eigen::SparseMatrix<double> geometric_part(const Eigen::VectorXd &x) const {
        const Eigen::VectorXd tetrahedron_pressure = share_.transpose() * pressure(slopes(resisted_change(volumes(x))));
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(144 * tetrahedra_.size());
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t) {
            if (tetrahedron_pressure[static_cast<Eigen::Index>(t)] == 0.0)
                continue; // as at rest
            const auto block = volume_hessian(x, tetrahedra_[t]);
            add_block(entries, tetrahedra_[t], tetrahedron_pressure[static_cast<Eigen::Index>(t)] * block);
        }
        return square_matrix(entries, x.size());
    }

    std::vector<std::array<int, 4>> tetrahedra_;
    SparseRows share_;
    std::vector<int> centre_;
    SparseRows mean_;
    MeasureVolume measure_;
    Eigen::VectorXd modulus_;
    Eigen::VectorXd tetrahedron_volume_; // (M) at rest [m^3]
    Eigen::VectorXd rest_volume_;
};

} // namespace

VolumeMeasure change_of_volume(double change) {
    return {change, 1.0, 0.0};
}

VolumeMeasure logarithm_of_volume(double change) {
    if (change <= -1.0)
        return {-std::numeric_limits<double>::infinity(), 0.0, 0.0};
    const double inverse = 1.0 / (1.0 + change);
    return {std::log1p(change), inverse, -inverse * inverse};
}

ControlVolumes volumes_around_nodes(const NodalParts &parts, const std::vector<double> &modulus) {
    ControlVolumes result;
    result.centre = parts.node;
    for (std::size_t c = 0; c < parts.region.size(); ++c)
        result.modulus.push_back(modulus[parts.region[c]] * parts.modulus_factor[c]);
    std::vector<Eigen::Triplet<double>> share;
    for (std::size_t t = 0; t < parts.at_corner.size(); ++t)
        for (const int part : parts.at_corner[t])
            share.emplace_back(part, static_cast<int>(t), 0.25);
    result.share.resize(static_cast<Eigen::Index>(parts.node.size()),
                        static_cast<Eigen::Index>(parts.at_corner.size()));
    result.share.setFromTriplets(share.begin(), share.end());
    return result;
}

ControlVolumes mean_volumes_around_nodes(const NodalParts &parts, const std::vector<double> &modulus) {
    auto volumes = volumes_around_nodes(parts, modulus);
    std::vector<Eigen::Triplet<double>> mean;
    for (std::size_t t = 0; t < parts.at_corner.size(); ++t)
        for (const int part : parts.at_corner[t])
            for (const int other : parts.at_corner[t])
                mean.emplace_back(part, other, parts.tetrahedron_volume[t] / (16.0 * parts.volume[part]));
    const auto size = static_cast<Eigen::Index>(parts.node.size());
    volumes.mean.resize(size, size);
    volumes.mean.setFromTriplets(mean.begin(), mean.end());
    return volumes;
}

std::shared_ptr<const ElasticTerm> volume_penalty(const core::TetraMesh &mesh, const ControlVolumes &control_volumes) {
    return std::make_shared<VolumePenalty>(mesh, control_volumes);
}

} // namespace livermark::msm
