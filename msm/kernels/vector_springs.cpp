#include "msm/kernels/vector_springs.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

namespace {

std::size_t in_slices(std::size_t count) {
    return (count + coupled_slice - 1) / coupled_slice * coupled_slice;
}

/// Place of line k of a number in slices of so many lines.
std::size_t place(std::size_t number, std::size_t lines, std::size_t k) {
    const std::size_t lane = number % coupled_slice;
    return lines * (number - lane) + k * coupled_slice + lane;
}

bool are_around_nodes_alone(const StepParts &parts) {
    return !parts.coupled_modulus.empty() && parts.edges.empty() && parts.tetrahedron_stiffness.empty() &&
           !parts.averages_volumes && parts.is_removed.empty();
}

void add_tetrahedra(const StepParts &parts, const Eigen::VectorXd &rest, CoupledArrays &arrays) {
    const std::size_t count = parts.tetrahedra.size();
    const bool has_guard = !parts.least_volume.empty();
    arrays.num_tetrahedra = in_slices(count);
    arrays.corner.resize(4 * arrays.num_tetrahedra);
    arrays.part.resize(4 * arrays.num_tetrahedra);
    arrays.gradient.resize(9 * arrays.num_tetrahedra);
    arrays.volume.resize(arrays.num_tetrahedra, 0.0);
    arrays.inner_modulus.resize(arrays.num_tetrahedra, 0.0);
    arrays.least_relative_volume.resize(has_guard ? arrays.num_tetrahedra : 0, 0.0);
    arrays.guard_modulus.resize(has_guard ? arrays.num_tetrahedra : 0, 0.0);
    for (std::size_t number = 0; number < arrays.num_tetrahedra; ++number) {
        const std::size_t t = std::min(number, count - 1);
        const auto [volume, gradient] = volume_gradient(rest, parts.tetrahedra[t]);
        for (std::size_t a = 0; a < 4; ++a) {
            arrays.corner[place(number, 4, a)] = 4 * parts.tetrahedra[t][a];
            arrays.part[place(number, 4, a)] = static_cast<std::int32_t>(arrays.row_size) * parts.corner_volume[t][a];
        }
        for (std::size_t k = 0; k < 9; ++k)
            arrays.gradient[place(number, 9, k)] = gradient[1 + k / 3][static_cast<Eigen::Index>(k % 3)] / volume;
        if (number != t)
            continue; // fills up the slice
        arrays.volume[t] = volume;
        arrays.inner_modulus[t] = parts.inner_modulus[t];
        if (has_guard) {
            arrays.least_relative_volume[t] = parts.least_volume[t] / volume;
            arrays.guard_modulus[t] = parts.guard_stiffness[t] * volume;
        }
    }
}

void add_parts(const StepParts &parts, const Eigen::VectorXd &rest, CoupledArrays &arrays) {
    arrays.num_parts = in_slices(parts.centre.size());
    for (auto *values : {&arrays.part_volume, &arrays.part_weight, &arrays.part_modulus, &arrays.volume_modulus})
        values->resize(arrays.num_parts, 0.0);
    const auto members = volume_members(parts);
    const auto volumes = rest_volumes(parts, rest);
    for (std::size_t c = 0; c < parts.centre.size(); ++c) {
        const double volume = rest_volume(parts, volumes, members.of(static_cast<int>(c)));
        arrays.part_volume[c] = volume;
        arrays.part_weight[c] = 0.25 / volume;
        arrays.part_modulus[c] = parts.coupled_modulus[c];
        if (!parts.volume_stiffness.empty())
            arrays.volume_modulus[c] = parts.volume_stiffness[c] * volume;
    }
}

} // namespace

std::optional<CoupledArrays> coupled_arrays(const StepParts &parts, const std::vector<core::Vector3> &positions) {
    const auto functions = parts.kernels ? parts.kernels().equilibrium(parts.measure) : EquilibriumFunctions{};
    if (!functions.energy || !are_around_nodes_alone(parts))
        return std::nullopt;
    const auto rest = to_unknowns(positions);
    CoupledArrays arrays;
    arrays.functions = functions;
    arrays.num_nodes = positions.size();
    arrays.row_size = parts.measure == StrainMeasure::deformation_gradient ? 12 : 8;
    arrays.rest.resize(4 * positions.size(), 0.0);
    for (std::size_t i = 0; i < positions.size(); ++i)
        std::copy_n(positions[i].data(), 3, arrays.rest.data() + 4 * i);
    add_tetrahedra(parts, rest, arrays);
    add_parts(parts, rest, arrays);
    return arrays;
}

CoupledWorkspace::CoupledWorkspace(const CoupledArrays &body)
    : displacement(4 * body.num_nodes), direction(4 * body.num_nodes), force(4 * body.num_nodes),
      mean(body.row_size * body.num_parts), push(body.row_size * body.num_parts),
      mean_rate(body.row_size * body.num_parts), stress(7 * body.num_tetrahedra) {}

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
            arrays_.functions.force(arrays_, workspace_);
            add_rows(workspace_.force, 1.0, force);
        }
        return energy;
    }

    void add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u, Eigen::VectorXd &product) const {
        const std::scoped_lock lock(mutex_);
        if (!knows(x)) {
            energy_at(x);
            arrays_.functions.keep_stresses(arrays_, workspace_);
            stresses_at_ = x;
        }
        put_in_rows(u, workspace_.direction);
        arrays_.functions.product(arrays_, workspace_);
        add_rows(workspace_.force, -1.0, product);
    }

    void add_force_at_rest(const Eigen::VectorXd &u, double factor, Eigen::VectorXd &force) const {
        const std::scoped_lock lock(mutex_);
        put_in_rows(u, workspace_.direction);
        arrays_.functions.product_at_rest(arrays_, workspace_);
        add_rows(workspace_.force, factor, force);
    }

    bool is_at_rest(const Eigen::VectorXd &x) const { return x == rest_; }

  private:
    double energy_at(const Eigen::VectorXd &x) const {
        stresses_at_.resize(0);
        put_in_rows(x - rest_, workspace_.displacement);
        return arrays_.functions.energy(arrays_, workspace_);
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
    auto result = body;
    result.terms = {std::make_shared<VectorTerm>(body.terms, std::move(kernel))};
    return result;
}

} // namespace livermark::msm
