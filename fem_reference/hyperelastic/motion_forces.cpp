#include "fem_reference/hyperelastic/motion_forces.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <stdexcept>
#include <utility>

#include "fem_reference/dynamics/modes.hpp"

namespace livermark::hyperelastic {

EffectiveMass::EffectiveMass(const Elements &elements, std::vector<bool> is_free)
    : elements_(&elements), is_free_(std::move(is_free)),
      mass_(fem_reference::consistent_mass(elements.body(), elements.system())), tangent_(elements.zero_tangent()) {
    number_.assign(is_free_.size(), -1);
    for (std::size_t dof = 0; dof < is_free_.size(); ++dof)
        if (is_free_[dof])
            number_[dof] = num_free_++;
    const auto &rows = tangent_.stiffness.rows;
    for (std::size_t a = 0; a < rows.num_nodes(); ++a)
        for (int i = 0; i < 3; ++i) {
            if (!is_free_[3 * a + i])
                continue;
            start_.push_back(static_cast<int>(entry_.size()));
            for (int k = rows.row_start[a]; k < rows.row_start[a + 1]; ++k)
                for (int j = 0; j < 3; ++j)
                    if (const int column = number_[3 * rows.column[k] + j]; column >= 0)
                        entry_.push_back(column);
            for (int j = 0; j <= i; ++j)
                if (const int column = number_[3 * a + j]; column >= 0)
                    entry_.push_back(column);
        }
    start_.push_back(static_cast<int>(entry_.size()));
}

void EffectiveMass::multiply_mass(std::span<const double> x, std::span<double> out) const {
    fem_reference::multiply_mass(mass_, x, out);
}

void EffectiveMass::factorise(double m, double k, const std::vector<double> &displacement,
                              const SurfaceStiffness &surface) {
    elements_->assemble_tangent({displacement, {}}, tangent_);
    surface.add_to(tangent_.stiffness);
    if (factorise(m, k))
        return;
    elements_->assemble_tangent(elements_->rest(), tangent_);
    surface.add_to(tangent_.stiffness);
    if (!factorise(m, k))
        throw std::logic_error("a body with mass has a stiffness at rest that is not positive semidefinite");
}

bool EffectiveMass::factorise(double m, double k) {
    const auto &rows = tangent_.stiffness.rows;
    std::vector<double> value;
    value.reserve(entry_.size());
    for (std::size_t a = 0; a < rows.num_nodes(); ++a) {
        // Of the mass, columns up to that of the diagonal come in the order of the blocks.
        const int first = mass_.row_start[a];
        const int num_below = rows.row_start[a + 1] - rows.row_start[a];
        for (int i = 0; i < 3; ++i) {
            if (!is_free_[3 * a + i])
                continue;
            for (int below = 0; below < num_below; ++below) {
                const int block = rows.row_start[a] + below;
                for (int j = 0; j < 3; ++j)
                    if (is_free_[3 * rows.column[block] + j])
                        value.push_back(k * tangent_.stiffness.below[block][3 * i + j] +
                                        (i == j ? m * mass_.value[first + below] : 0.0));
            }
            for (int j = 0; j <= i; ++j)
                if (is_free_[3 * a + j])
                    value.push_back(k * tangent_.stiffness.diagonal[a][3 * i + j] +
                                    (i == j ? m * mass_.value[first + num_below] : 0.0));
        }
    }
    const Eigen::Map<const Eigen::SparseMatrix<double>> upper(
        num_free_, num_free_, static_cast<Eigen::Index>(value.size()), start_.data(), entry_.data(), value.data());
    if (!is_ordered_)
        cholesky_.order(upper);
    is_ordered_ = true;
    return cholesky_.factorise(upper);
}

void EffectiveMass::solve(std::span<const double> b, std::span<double> x) const {
    Eigen::VectorXd of_free(num_free_);
    for (std::size_t dof = 0; dof < b.size(); ++dof)
        if (number_[dof] >= 0)
            of_free[number_[dof]] = b[dof];
    of_free = cholesky_.solve_single_precision(of_free);
    for (std::size_t dof = 0; dof < b.size(); ++dof)
        x[dof] = number_[dof] >= 0 ? of_free[number_[dof]] : 0.0;
}

namespace {

/// Stress and energy at a point.
struct Response {
    Matrix3 stress; ///< second Piola-Kirchhoff [Pa]
    double energy;  ///< [Pa]
};

/// @param jacobian  det F > 0
Response response(const MaterialLaw &law, const core::Material &material, const Matrix3 &f, double jacobian) {
    const Matrix3 inverse = f.inverse();
    const auto volume = law.volume(jacobian);
    const double modulus = law.volume_modulus(material);
    const Matrix3 first =
        law.stress(material, f) + modulus * volume.value * volume.slope * jacobian * inverse.transpose();
    return {inverse * first, law.energy(material, f) + 0.5 * modulus * volume.value * volume.value};
}

/// S(C) of an objective law: any F with F^T F = C has it.
Matrix3 stress_of(const MaterialLaw &law, const core::Material &material, const Matrix3 &c) {
    const Matrix3 f = c.llt().matrixU();
    return response(law, material, f, f.diagonal().prod()).stress;
}

/// Displacements of the nodes of a tetrahedron, one per column.
template <int nodes>
Eigen::Matrix<double, 3, nodes> gather(std::span<const int> numbers, std::span<const double> displacement) {
    Eigen::Matrix<double, 3, nodes> result;
    for (int a = 0; a < nodes; ++a)
        result.col(a) = core::Vector3::Map(&displacement[3 * numbers[a]]);
    return result;
}

/// Where a step changes C by less, S(C_m) is the derivative of W along it to rounding, and the differences of W are
/// nothing else.
constexpr double small_change = 1e-4;

} // namespace

MotionForces::MotionForces(const Elements &elements, TetrahedronRule rule, double viscosity)
    : elements_(&elements), reference_(reference_tetrahedron(elements.degree(), rule)), viscosity_(viscosity) {
    if (elements.num_pressures() > 0)
        throw std::invalid_argument("elements with a pressure do not move in time; take displacements alone");
    const auto &mesh = elements.body().mesh;
    for (const auto &corners : mesh.tetrahedra) {
        Matrix3 edges;
        for (int k = 0; k < 3; ++k)
            edges.col(k) = mesh.points[corners[k + 1]] - mesh.points[corners[0]];
        volume_.push_back(edges.determinant() / 6.0);
        inverse_edges_.emplace_back(edges.inverse());
    }
    start_.resize(volume_.size() * reference_.weight.size());
}

double MotionForces::begin_at(std::span<const double> displacement) {
    return elements_->degree() == 1 ? begin<4>(displacement) : begin<10>(displacement);
}

void MotionForces::end_at(std::span<const double> displacement, double time_step, AtEnd &result) const {
    if (elements_->degree() == 1)
        end<4>(displacement, time_step, result);
    else
        end<10>(displacement, time_step, result);
}

template <int nodes> double MotionForces::begin(std::span<const double> displacement) {
    const auto &body = elements_->body();
    const auto &law = elements_->law();
    double energy = 0.0;
    auto point = start_.begin();
    for (std::size_t t = 0; t < volume_.size(); ++t) {
        const auto numbers = std::span(elements_->system().cell_nodes).subspan(t * nodes, nodes);
        const auto u = gather<nodes>(numbers, displacement);
        for (std::size_t q = 0; q < reference_.weight.size(); ++q, ++point) {
            const Eigen::Map<const Eigen::Matrix<double, 3, nodes>> gradient(reference_.gradient[q].data());
            const Matrix3 slope = u * gradient.transpose();
            point->deformation = Matrix3::Identity() + slope * inverse_edges_[t];
            const auto here = response(law, body.materials[body.mesh.region[t]], point->deformation,
                                       point->deformation.determinant());
            point->stress = here.stress;
            point->energy = here.energy;
            energy += reference_.weight[q] * volume_[t] * here.energy;
        }
    }
    return energy;
}

template <int nodes>
void MotionForces::end(std::span<const double> displacement, double time_step, AtEnd &result) const {
    const auto &body = elements_->body();
    const auto &law = elements_->law();
    result.is_possible = false;
    result.energy = 0.0;
    result.force.assign(displacement.size(), 0.0);
    auto point = start_.begin();
    for (std::size_t t = 0; t < volume_.size(); ++t) {
        const auto numbers = std::span(elements_->system().cell_nodes).subspan(t * nodes, nodes);
        const auto &material = body.materials[body.mesh.region[t]];
        const auto u = gather<nodes>(numbers, displacement);
        Eigen::Matrix<double, 3, nodes> force = Eigen::Matrix<double, 3, nodes>::Zero();
        for (std::size_t q = 0; q < reference_.weight.size(); ++q, ++point) {
            const Eigen::Map<const Eigen::Matrix<double, 3, nodes>> gradient(reference_.gradient[q].data());
            const Matrix3 slope = u * gradient.transpose();
            const Matrix3 f = Matrix3::Identity() + slope * inverse_edges_[t];
            const double jacobian = f.determinant();
            if (!(jacobian > 0.0)) // nor NaN
                return;
            const auto here = response(law, material, f, jacobian);
            const Matrix3 before = point->deformation.transpose() * point->deformation;
            const Matrix3 after = f.transpose() * f;
            const Matrix3 change = after - before;
            Matrix3 stress = stress_of(law, material, 0.5 * (before + after));
            const double missing = here.energy - point->energy - 0.5 * stress.cwiseProduct(change).sum();
            stress += 2.0 * missing / (change.squaredNorm() + small_change * small_change) * change;
            stress += viscosity_ / time_step * (here.stress - point->stress);
            const Matrix3 middle = 0.5 * (point->deformation + f);
            const double weight = reference_.weight[q] * volume_[t];
            const Matrix3 on_reference = weight * (middle * stress) * inverse_edges_[t].transpose();
            force.noalias() += on_reference * gradient;
            result.energy += weight * here.energy;
        }
        for (int a = 0; a < nodes; ++a)
            core::Vector3::Map(&result.force[3 * numbers[a]]) += force.col(a);
    }
    result.is_possible = true;
}

} // namespace livermark::hyperelastic
