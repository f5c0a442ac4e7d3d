#include "msm/kernels/equilibria/vector_springs.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

#include "msm/dynamics/step_parts.hpp"
#include "msm/kernels/equilibria/coupled_arrays.hpp"
#include "msm/springs/fixable_term.hpp"

namespace livermark::msm {

namespace {

using Terms = std::vector<std::shared_ptr<const ElasticTerm>>;

void put_in_rows(const Eigen::VectorXd &field, Aligned<double> &rows) {
    for (std::size_t i = 0; i < rows.size() / 4; ++i)
        std::copy_n(field.data() + 3 * i, 3, rows.data() + 4 * i);
}

void add_rows(const Aligned<double> &rows, double factor, Eigen::VectorXd &field) {
    for (std::size_t i = 0; i < rows.size() / 4; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            field.data()[3 * i + c] += factor * rows[4 * i + c];
}

/// The arrays of a body, and one workspace for whoever asks.
class VectorKernel {
  public:
    VectorKernel(CoupledArrays arrays, Eigen::VectorXd rest)
        : arrays_(std::move(arrays)), rest_(std::move(rest)), workspace_(arrays_) {}

    double energy(const Eigen::VectorXd &x) const {
        const std::scoped_lock lock(mutex_);
        return energy_at(x);
    }

    /// @param is_asked  by the energy: whether the force is added
    template <class IsAsked>
    double add_force(const Eigen::VectorXd &x, Eigen::VectorXd &force, const IsAsked &is_asked) const {
        const std::scoped_lock lock(mutex_);
        const double energy = energy_at(x);
        if (is_asked(energy)) {
            coupled_force(arrays_, workspace_);
            add_rows(workspace_.force, 1.0, force);
        }
        return energy;
    }

    void add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u, Eigen::VectorXd &product) const {
        const std::scoped_lock lock(mutex_);
        if (!knows(x)) {
            energy_at(x);
            keep_coupled_stresses(arrays_, workspace_);
            stresses_at_ = x;
        }
        put_in_rows(u, workspace_.direction);
        coupled_product(arrays_, workspace_);
        add_rows(workspace_.force, -1.0, product);
    }

    void add_force_at_rest(const Eigen::VectorXd &u, double factor, Eigen::VectorXd &force) const {
        const std::scoped_lock lock(mutex_);
        put_in_rows(u, workspace_.direction);
        coupled_product_at_rest(arrays_, workspace_);
        add_rows(workspace_.force, factor, force);
    }

    bool is_at_rest(const Eigen::VectorXd &x) const { return x == rest_; }

  private:
    double energy_at(const Eigen::VectorXd &x) const {
        stresses_at_.resize(0);
        put_in_rows(x - rest_, workspace_.displacement);
        return coupled_energy(arrays_, workspace_);
    }
    /// Whether means and stresses are those at x.
    bool knows(const Eigen::VectorXd &x) const { return stresses_at_.size() == x.size() && stresses_at_ == x; }

    CoupledArrays arrays_;
    Eigen::VectorXd rest_; // (3N) [m]
    mutable std::mutex mutex_;
    mutable CoupledWorkspace workspace_;
    mutable Eigen::VectorXd stresses_at_; // (3N) that the stresses in the workspace are of, or empty
};

/// The sum of the terms of a body.
class VectorTerm : public ElasticTerm, public FixableTerm {
  public:
    VectorTerm(Terms terms, std::shared_ptr<const VectorKernel> kernel, bool is_at_rest = false)
        : terms_(std::move(terms)), kernel_(std::move(kernel)), is_at_rest_(is_at_rest) {}

    double energy(const Eigen::VectorXd &x) const override { return kernel_->energy(x); }

    double add_force_and_energy(const Eigen::VectorXd &x, Eigen::VectorXd &force) const override {
        return kernel_->add_force(x, force, [](double energy) { return std::isfinite(energy); });
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        if (is_at_rest_)
            kernel_->add_force_at_rest(v, beta, force); // forces of rest are zero
        else if (beta == 0.0)
            kernel_->add_force(x, force, [](double) { return true; });
        else
            for (const auto &term : terms_)
                term->add_force(x, v, beta, force);
    }

    std::shared_ptr<const ElasticTerm> fixed_at(const Eigen::VectorXd &x) const override {
        return std::make_shared<VectorTerm>(terms_, kernel_, kernel_->is_at_rest(x));
    }

    void add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                             Eigen::VectorXd &product) const override {
        kernel_->add_hessian_product(x, u, product);
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        Eigen::SparseMatrix<double> sum = terms_.front()->hessian(x, tangent);
        for (std::size_t k = 1; k < terms_.size(); ++k)
            sum += terms_[k]->hessian(x, tangent);
        return sum;
    }

    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        for (const auto &term : terms_)
            term->add_block_bound(x, blocks);
    }

  private:
    Terms terms_;
    std::shared_ptr<const VectorKernel> kernel_;
    bool is_at_rest_; // and asked at no other positions
};

} // namespace

ElasticBody in_vectors(const ElasticBody &body, const std::vector<core::Vector3> &positions) {
    const auto parts = step_parts(body);
    auto arrays = parts ? coupled_arrays(*parts, positions) : std::nullopt;
    if (!arrays)
        return body;
    auto kernel = std::make_shared<const VectorKernel>(std::move(*arrays), to_unknowns(positions));
    ElasticBody result(body.node_mass, {std::make_shared<VectorTerm>(body.terms, std::move(kernel))});
    result.preconditioner = body.preconditioner;
    return result;
}

} // namespace livermark::msm
