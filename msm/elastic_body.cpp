#include "msm/elastic_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "msm/springs/springs.hpp"

namespace livermark::msm {

double ElasticTerm::add_force_and_energy(const Eigen::VectorXd &x, Eigen::VectorXd &force) const {
    const double value = energy(x);
    if (std::isfinite(value))
        add_force(x, x, 0.0, force);
    return value;
}

void ElasticTerm::add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                                      Eigen::VectorXd &product) const {
    product += hessian(x, Tangent::exact) * u;
}

ElasticBody::ElasticBody(std::vector<double> mass, std::vector<std::shared_ptr<const ElasticTerm>> energy_terms)
    : node_mass(std::move(mass)), terms(std::move(energy_terms)) {}

ElasticBody::ElasticBody(const core::SpringNetwork &springs)
    : node_mass(springs.node_mass), terms{spring_term(springs)} {}

void ElasticBody::add(const std::shared_ptr<const ElasticTerm> &term) {
    terms.push_back(term);
    if (const auto before = preconditioner)
        preconditioner = [=](double part) {
            auto stiffness = before(part);
            stiffness += term->hessian({}, Tangent::exact);
            return stiffness;
        };
}

double elastic_energy(const ElasticBody &body, const std::vector<core::Vector3> &positions) {
    const auto x = to_unknowns(positions);
    double energy = 0.0;
    for (const auto &term : body.terms)
        energy += term->energy(x);
    return energy;
}

std::vector<core::Vector3> elastic_gradient(const ElasticBody &body, const std::vector<core::Vector3> &positions) {
    const auto x = to_unknowns(positions);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
    for (const auto &term : body.terms)
        term->add_force(x, x, 0.0, force);
    return to_field(-force);
}

EnergyAndGradient elastic_energy_and_gradient(const ElasticBody &body, const std::vector<core::Vector3> &positions) {
    const auto x = to_unknowns(positions);
    EnergyAndGradient result;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
    for (const auto &term : body.terms)
        result.energy += term->add_force_and_energy(x, force);
    result.gradient = to_field(-force);
    return result;
}

Eigen::SparseMatrix<double> elastic_hessian(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                            Tangent tangent) {
    const auto x = to_unknowns(positions);
    Eigen::SparseMatrix<double> hessian(x.size(), x.size());
    for (const auto &term : body.terms) {
        auto added = term->hessian(x, tangent);
        if (hessian.nonZeros() == 0)
            hessian.swap(added); // a sum would be another copy, and these are large
        else if (added.nonZeros() > 0)
            hessian += added;
    }
    return hessian;
}

StiffnessProduct::StiffnessProduct(const ElasticBody &body, const std::vector<core::Vector3> &positions)
    : terms_(body.terms), rest_(to_unknowns(positions)) {
    for (auto &term : terms_)
        if (const auto *fixable = dynamic_cast<const FixableTerm *>(term.get()))
            term = fixable->fixed_at(rest_);
    at_rest_ = forces(Eigen::VectorXd::Zero(rest_.size()));
}

Eigen::VectorXd StiffnessProduct::times(const Eigen::VectorXd &displacement) const {
    return at_rest_ - forces(displacement);
}

Eigen::VectorXd StiffnessProduct::forces(const Eigen::VectorXd &velocity) const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(velocity.size());
    for (const auto &term : terms_)
        term->add_force(rest_, velocity, 1.0, force);
    return force;
}

Eigen::VectorXd to_unknowns(const std::vector<core::Vector3> &field) {
    Eigen::VectorXd unknowns(3 * static_cast<Eigen::Index>(field.size()));
    for (std::size_t i = 0; i < field.size(); ++i)
        node_part(unknowns, static_cast<int>(i)) = field[i];
    return unknowns;
}

std::vector<core::Vector3> to_field(const Eigen::VectorXd &unknowns) {
    std::vector<core::Vector3> field(static_cast<std::size_t>(unknowns.size() / 3));
    for (std::size_t i = 0; i < field.size(); ++i)
        field[i] = node_part(unknowns, static_cast<int>(i));
    return field;
}

std::vector<core::Vector3> moved(const std::vector<core::Vector3> &positions,
                                 const std::vector<core::Vector3> &displacement) {
    auto result = positions;
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] += displacement[i];
    return result;
}

bool describe_volumes(const std::vector<int> &centre, const std::vector<std::array<int, 4>> &corner_volume,
                      StepParts &parts) {
    if (parts.centre.empty()) {
        parts.centre = centre;
        parts.corner_volume = corner_volume;
    }
    return parts.centre == centre && parts.corner_volume == corner_volume;
}

namespace {

/// Springs with means of C or F keep strains and their rates apart, so the volume beside them has to do that too.
bool are_of_one_kind(const StepParts &parts) {
    const bool is_around_edges = !parts.edge_modulus.empty();
    if (is_around_edges && !(parts.coupled_modulus.empty() && parts.has_means_of_tensors()))
        return false;
    if (!parts.has_means_of_tensors() && parts.averages_volumes)
        return false;
    if (!parts.resisted_change)
        return true;
    const bool is_beside = parts.resisted_change == parts.beside;
    return is_beside && (!parts.has_means_of_tensors() ||
                         (parts.tetrahedron_stiffness.empty() && parts.averages_volumes == is_around_edges));
}

} // namespace

PartedTerms part_terms(const ElasticBody &body) {
    PartedTerms parted{body, {}};
    std::erase_if(parted.in_kernels.terms, [&](const auto &term) {
        if (term->is_beside_kernels())
            parted.beside.push_back(term);
        return term->is_beside_kernels();
    });
    return parted;
}

std::optional<StepParts> step_parts(const ElasticBody &body) {
    StepParts parts;
    const bool are_known = std::ranges::all_of(body.terms, [&](const auto &term) { return term->describe(parts); });
    return are_known && are_of_one_kind(parts) ? std::optional(std::move(parts)) : std::nullopt;
}

std::vector<double> lumped_masses(const core::Body &body) {
    const auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    std::vector<double> masses(mesh.points.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        for (const int node : mesh.tetrahedra[t])
            masses[node] += body.materials[mesh.region[t]].density * volumes[t] / 4.0;
    return masses;
}

NodalConditions free_nodes(std::size_t num_nodes) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    return {.displacement = std::vector<core::Vector3>(num_nodes, core::Vector3::Constant(nan)),
            .constraint = std::vector<std::array<int, 3>>(num_nodes, {-1, -1, -1}),
            .force = std::vector<core::Vector3>(num_nodes, core::Vector3::Zero())};
}

namespace {

/// Prescribes the components that a facet prescribes, unless a constraint of lower index has done so.
void prescribe(NodalConditions &nodes, int node, const core::Vector3 &value, int constraint) {
    for (int c = 0; c < 3; ++c) {
        int &owner = nodes.constraint[node][static_cast<std::size_t>(c)];
        if (!std::isnan(value[c]) && (owner < 0 || constraint < owner)) {
            owner = constraint;
            nodes.displacement[node][c] = value[c];
        }
    }
}

} // namespace

NodalConditions nodal_conditions(const core::Problem &problem, const std::vector<double> &node_mass) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    NodalConditions nodes;
    nodes.press_depth = load_case.press_depth;
    nodes.displacement.assign(mesh.points.size(), core::Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    nodes.constraint.assign(mesh.points.size(), {-1, -1, -1});
    nodes.force.reserve(mesh.points.size());
    for (const double mass : node_mass)
        nodes.force.push_back(mass * load_case.acceleration);

    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (load_case.is_loaded(f)) {
            const core::Vector3 force = area_vector(mesh, f).norm() * load_case.value[f];
            const auto part = core::linear_parts(load_case.round_load_on(f), core::corners_of(mesh, f));
            for (std::size_t k = 0; k < 3; ++k)
                nodes.force[mesh.boundary_triangles[f][k]] += part[k] * force;
        }
        if (load_case.is_constrained(f))
            for (const int node : mesh.boundary_triangles[f])
                prescribe(nodes, node, load_case.prescribed_at(f, node), load_case.constraint_on(f));
    }
    return nodes;
}

std::vector<core::Vector3> constraint_forces(const core::Problem &problem, const NodalConditions &conditions,
                                             const std::vector<core::Vector3> &force, double press,
                                             const std::vector<core::Vector3> &touch) {
    auto total = core::press_resultants(problem.load_case, problem.body->mesh);
    for (auto &resultant : total)
        resultant *= press;
    for (std::size_t i = 0; i < force.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            if (const int owner = conditions.constraint[i][c]; owner >= 0)
                total[owner][static_cast<Eigen::Index>(c)] += force[i][static_cast<Eigen::Index>(c)];
    const auto contacts = problem.load_case.contacts();
    for (std::size_t k = 0; k < touch.size(); ++k)
        total[contacts[k].constraint] += touch[k];
    return total;
}

} // namespace livermark::msm
