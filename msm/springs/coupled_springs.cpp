#include "msm/springs/springs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "core/support/input_error.hpp"
#include "msm/elastic_body.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

namespace {

/// The parts of a body over which coupled springs take means of strains, of all kinds behind each other: around nodes,
/// around edges, and tetrahedra. Kinds without weight are left out. Where two materials meet stress jumps, so each has
/// parts of its own.
struct MeanParts {
    /// A part with some of a tetrahedron.
    struct Member {
        int part;
        double share;   ///< share of the tetrahedron that belongs to the part, times the weight of its kind
        double in_mean; ///< weight of the tetrahedron in the mean: its volume in the part over that of the part
    };

    std::vector<double> volume;  ///< (C) at rest, times the weight of their kind [m^3]
    std::vector<double> modulus; ///< (C) shear modulus, its mean over the volume [Pa]
    std::vector<Member> members; ///< of each tetrahedron behind each other
    std::vector<int> start;      ///< (M + 1) where these begin

    int num_parts() const { return static_cast<int>(volume.size()); }
};

MeanParts mean_parts(const core::Body &body, const StrainDomains &domains) {
    /// Parts around places that tetrahedra share: nodes, edges, or nothing.
    struct Kind {
        double weight;
        std::size_t num_places; ///< of a tetrahedron, each with an equal share of it
        std::vector<int> part;  ///< at each place of each tetrahedron
    };
    const auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    MeanParts parts;
    std::vector<Kind> kinds;
    std::vector<double> whole; // (C) volume of each part
    const auto add_kind = [&](double weight, std::size_t num_places, const auto &places_of) {
        if (weight == 0.0)
            return;
        auto &kind = kinds.emplace_back(Kind{weight, num_places, {}});
        std::map<std::pair<int, int>, int> number; // of each place and region
        for (std::size_t t = 0; t < volumes.size(); ++t)
            for (const int place : places_of(t)) {
                const int region = mesh.region[t];
                const auto [at, is_new] = number.try_emplace({place, region}, static_cast<int>(whole.size()));
                if (is_new) {
                    whole.push_back(0.0);
                    parts.modulus.push_back(body.modulus_factor.empty() ? body.shear_modulus_of(t) : 0.0);
                }
                const double share = volumes[t] / static_cast<double>(num_places);
                whole[at->second] += share;
                if (!body.modulus_factor.empty())
                    parts.modulus[at->second] += share * body.shear_modulus_of(t);
                kind.part.push_back(at->second);
            }
        for (std::size_t c = parts.volume.size(); c < whole.size(); ++c) {
            parts.volume.push_back(weight * whole[c]);
            if (!body.modulus_factor.empty())
                parts.modulus[c] /= whole[c];
        }
    };
    add_kind(domains.nodes, 4, [&](std::size_t t) { return mesh.tetrahedra[t]; });
    const auto edges = domains.edges > 0.0 ? core::edge_table(mesh.tetrahedra) : core::EdgeTable{};
    add_kind(domains.edges, 6, [&](std::size_t t) { return edges.tetrahedron_edge[t]; });
    add_kind(domains.tetrahedra, 1, [](std::size_t t) { return std::array{static_cast<int>(t)}; });
    parts.start.push_back(0);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        for (const auto &[weight, num_places, part] : kinds)
            for (std::size_t k = t * num_places; k < (t + 1) * num_places; ++k) {
                const auto shares = static_cast<double>(num_places);
                parts.members.push_back(
                    {.part = part[k], .share = weight / shares, .in_mean = volumes[t] / (shares * whole[part[k]])});
            }
        parts.start.push_back(static_cast<int>(parts.members.size()));
    }
    return parts;
}

template <class Measure> class CoupledTerm : public RelaxingTerm, public FixableTerm {
    using Value = typename Measure::Value;
    using Values = std::vector<Value>;
    static constexpr int size = Measure::size;

  public:
    CoupledTerm(const core::Body &body, CoupledSprings springs)
        : springs_(std::move(springs)), parts_(mean_parts(body, springs_.domains)), nodal_(nodal_parts(body)),
          nodes_(body.mesh.tetrahedra), volume_(core::tetrahedron_volumes(body.mesh)) {
        const auto rest = to_unknowns(body.mesh.points);
        for (const auto &nodes : nodes_)
            tetrahedra_.emplace_back(nodes, rest);
        for (std::size_t t = 0; t < body.modulus_factor.size(); ++t)
            tetrahedron_modulus_.push_back(body.shear_modulus_of(t));
    }

    double energy(const Eigen::VectorXd &x) const override {
        if (!is_possible(x))
            return std::numeric_limits<double>::infinity();
        const auto mean = means(values(x));
        double energy = 0.0;
        for (int c = 0; c < parts_.num_parts(); ++c)
            energy += parts_.volume[c] * Measure::energy(law(c), mean[c]);
        return energy;
    }

    double add_force_and_energy(const Eigen::VectorXd &x, Eigen::VectorXd &force) const override {
        if (!is_possible(x))
            return std::numeric_limits<double>::infinity();
        auto stress = means(values(x));
        double energy = 0.0;
        for (int c = 0; c < parts_.num_parts(); ++c) {
            const Value mean = stress[c];
            energy += parts_.volume[c] * Measure::energy(law(c), mean);
            stress[c] = Measure::stress(law(c), mean);
        }
        if (std::isfinite(energy))
            add_gathered_force(x, stress, force);
        return energy;
    }

    void add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                   Eigen::VectorXd &force) const override {
        add_gathered_force(x, stresses(x, v, beta), force);
    }

    Eigen::VectorXd relaxing_stress(const Eigen::VectorXd &x) const override {
        const auto mean = means(values(x));
        Eigen::VectorXd stress(6 * static_cast<Eigen::Index>(mean.size()));
        for (int c = 0; c < parts_.num_parts(); ++c)
            stress.segment<6>(6 * static_cast<Eigen::Index>(c)) =
                part_ * components(springs_.energy.isochoric_stress(parts_.modulus[c], Measure::strain(mean[c])));
        return stress;
    }

    void add_force_of(const Eigen::VectorXd &x, const Eigen::VectorXd &stress, Eigen::VectorXd &force) const override {
        auto pushed = means(values(x));
        for (int c = 0; c < parts_.num_parts(); ++c)
            pushed[c] = Measure::push(pushed[c], stress.segment<6>(6 * static_cast<Eigen::Index>(c)));
        add_gathered_force(x, pushed, force);
    }

    Eigen::VectorXd relaxing_compliance() const override {
        Eigen::VectorXd compliance = Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(parts_.num_parts()));
        for (int c = 0; part_ > 0.0 && c < parts_.num_parts(); ++c)
            compliance.segment<6>(6 * static_cast<Eigen::Index>(c))
                .setConstant(parts_.volume[c] / (2.0 * part_ * parts_.modulus[c]));
        return compliance;
    }

    std::shared_ptr<const RelaxingTerm> relaxed(double part, const Eigen::VectorXd &added) const override {
        auto term = std::make_shared<CoupledTerm>(*this);
        term->part_ = part * part_;
        term->added_ = added;
        return term;
    }

    std::shared_ptr<const ElasticTerm> fixed_at(const Eigen::VectorXd &x) const override {
        auto term = std::make_shared<CoupledTerm>(*this);
        auto mean = means(values(x));
        term->fixed_stiffness_.reserve(mean.size());
        for (int c = 0; c < parts_.num_parts(); ++c) {
            term->fixed_stiffness_.push_back(stiffness(c, mean[c], Tangent::material));
            mean[c] = Measure::stress(law(c), mean[c]);
        }
        term->fixed_stress_ = std::move(mean);
        return term;
    }

    /// Forces of the stresses that small displacements add, and of those that are there when edges turn.
    void add_hessian_product(const Eigen::VectorXd &x, const Eigen::VectorXd &u,
                             Eigen::VectorXd &product) const override {
        const auto mean = means(values(x));
        auto added = means(rates(x, u));
        for (int c = 0; c < parts_.num_parts(); ++c)
            added[c] = stiffness(c, mean[c], Tangent::exact) * added[c];
        const auto more = gathered(added), there = gathered(stresses(x, x, 0.0));
        Eigen::VectorXd force = Eigen::VectorXd::Zero(x.size());
        for (std::size_t t = 0; t < nodes_.size(); ++t) {
            tetrahedra_[t].add_force(x, more[t], force);
            tetrahedra_[t].add_turning(x, u, there[t], force);
        }
        product -= force;
    }

    Eigen::SparseMatrix<double> hessian(const Eigen::VectorXd &x, Tangent tangent) const override {
        const auto mean = means(values(x));
        const auto slopes = mean_slopes(x);
        Eigen::SparseMatrix<double> stiffnesses(slopes.rows(), slopes.rows());
        stiffnesses.reserve(Eigen::VectorXi::Constant(slopes.rows(), size));
        for (int c = 0; c < parts_.num_parts(); ++c) {
            const typename Measure::Stiffness block = parts_.volume[c] * stiffness(c, mean[c], tangent);
            const auto first = size * static_cast<Eigen::Index>(c);
            for (int column = 0; column < size; ++column)
                for (int row = 0; row < size; ++row)
                    stiffnesses.insert(first + row, first + column) = block(row, column);
        }
        const Eigen::SparseMatrix<double> stress_slope = stiffnesses * slopes;
        Eigen::SparseMatrix<double> hessian = Eigen::SparseMatrix<double>(slopes.transpose()) * stress_slope;
        hessian += turning_hessian(x, tangent);
        return hessian;
    }

    /// The mean of a rate costs no more than the mean of what each rate costs, so u^T K u is at most what it would be
    /// with all stiffness inside the tetrahedra, and there u^T K_t u <= 4 sum of u_a^T (K_t)_aa u_a.
    void add_block_bound(const Eigen::VectorXd &x, std::vector<Eigen::Matrix3d> &blocks) const override {
        const auto mean = means(values(x));
        for (int t = 0; t < static_cast<int>(nodes_.size()); ++t) {
            typename Measure::Stiffness material = Measure::Stiffness::Zero();
            for (const auto &member : members(t))
                material += member.share * stiffness(member.part, mean[member.part], Tangent::material);
            const auto slope = tetrahedra_[t].slope(x);
            const Matrix12 block = volume_[t] * slope.transpose() * material * slope;
            for (int a = 0; a < 4; ++a)
                blocks[nodes_[t][a]] += 4.0 * block.template block<3, 3>(3 * a, 3 * a);
        }
    }

    bool describe(StepParts &parts) const override {
        if (!are_in_kernels(springs_) || part_ != 1.0 || added_.size() > 0)
            return false;
        parts.measure = springs_.measure;
        parts.kernels = springs_.energy.kernels;
        parts.beside = springs_.energy.volume;
        parts.tetrahedra = nodes_;
        parts.tetrahedron_modulus = tetrahedron_modulus_;
        parts.part_of_means = springs_.domains.edges > 0.0 ? springs_.domains.edges : springs_.domains.nodes;
        return springs_.domains.edges > 0.0 ? describe_edges(parts) : describe_nodes(parts);
    }

  private:
    /// Whether the energy has a value there.
    bool is_possible(const Eigen::VectorXd &x) const {
        return springs_.energy.is_finite ||
               std::ranges::all_of(nodes_, [&](const auto &nodes) { return volume_gradient(x, nodes).volume > 0.0; });
    }

    MeanLaw law(int part) const {
        MeanLaw law{.spring_energy = springs_.energy, .mu = parts_.modulus[part], .part = part_};
        if (added_.size() > 0)
            law.added = added_.segment<6>(6 * static_cast<Eigen::Index>(part));
        return law;
    }

    /// @param stress  of each part
    void add_gathered_force(const Eigen::VectorXd &x, const Values &stress, Eigen::VectorXd &force) const {
        const auto borne = gathered(stress);
        for (std::size_t t = 0; t < nodes_.size(); ++t)
            tetrahedra_[t].add_force(x, borne[t], force);
    }

    bool describe_nodes(StepParts &parts) const {
        const auto &domains = springs_.domains;
        std::vector<std::array<int, 4>> part_at_corner(nodes_.size());
        std::vector<int> part_node;
        for (std::size_t t = 0; t < nodes_.size(); ++t) {
            const auto around = members(t);
            for (int corner = 0; corner < 4; ++corner) {
                const int part = part_at_corner[t][corner] = around[corner].part; // those around nodes come first
                if (part == static_cast<int>(part_node.size())) {
                    part_node.push_back(nodes_[t][corner]);
                    parts.coupled_modulus.push_back(parts.part_of_means * parts_.modulus[part]);
                }
            }
            parts.inner_modulus.push_back(domains.tetrahedra * parts_.modulus[around.back().part]); // of itself
        }
        return describe_volumes(part_node, part_at_corner, parts);
    }

    /// Parts around edges come first, six of each tetrahedron.
    bool describe_edges(StepParts &parts) const {
        const auto &domains = springs_.domains;
        for (std::size_t t = 0; t < nodes_.size(); ++t) {
            const auto around = members(t);
            auto &edge_part = parts.edge_part.emplace_back();
            for (std::size_t e = 0; e < 6; ++e) {
                edge_part[e] = around[e].part;
                if (around[e].part == static_cast<int>(parts.edge_modulus.size()))
                    parts.edge_modulus.push_back(parts.part_of_means * parts_.modulus[around[e].part]);
            }
            parts.inner_modulus.push_back(domains.tetrahedra * parts_.modulus[around.back().part]); // of itself
        }
        return describe_volumes(nodal_.node, nodal_.at_corner, parts);
    }

    std::span<const MeanParts::Member> members(std::size_t tetrahedron) const {
        return std::span(parts_.members)
            .subspan(parts_.start[tetrahedron], parts_.start[tetrahedron + 1] - parts_.start[tetrahedron]);
    }

    typename Measure::Stiffness stiffness(int part, const Value &mean, Tangent tangent) const {
        return Measure::stiffness(law(part), mean, tangent);
    }

    Values values(const Eigen::VectorXd &x) const {
        Values value;
        value.reserve(nodes_.size());
        for (const auto &tetrahedron : tetrahedra_)
            value.push_back(tetrahedron.of(x));
        return value;
    }

    Values rates(const Eigen::VectorXd &x, const Eigen::VectorXd &u) const {
        Values rate;
        rate.reserve(nodes_.size());
        for (const auto &tetrahedron : tetrahedra_)
            rate.push_back(tetrahedron.rate(x, u));
        return rate;
    }

    Values means(const Values &value) const {
        Values mean(parts_.num_parts(), Value::Zero());
        for (std::size_t t = 0; t < value.size(); ++t)
            for (const auto &member : members(t))
                mean[member.part] += member.in_mean * value[t];
        return mean;
    }

    /// Stress of each part, and what its dashpots add [Pa].
    Values stresses(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta) const {
        const bool is_fixed = !fixed_stress_.empty();
        auto stress = is_fixed ? fixed_stress_ : means(values(x));
        Values mean_rate;
        if (beta != 0.0)
            mean_rate = means(rates(x, v));
        for (int c = 0; c < parts_.num_parts(); ++c) {
            const Value mean = stress[c];
            if (!is_fixed)
                stress[c] = Measure::stress(law(c), mean);
            if (beta != 0.0 && is_fixed)
                stress[c] += beta * (fixed_stiffness_[c] * mean_rate[c]);
            else if (beta != 0.0)
                stress[c] += beta * (stiffness(c, mean, Tangent::material) * mean_rate[c]);
        }
        return stress;
    }

    /// Stress that each tetrahedron bears of its parts, times its volume [J].
    Values gathered(const Values &stress) const {
        Values result(nodes_.size(), Value::Zero());
        for (std::size_t t = 0; t < result.size(); ++t)
            for (const auto &member : members(t))
                result[t] += volume_[t] * member.share * stress[member.part];
        return result;
    }

    /// (size C, 3N) of the means
    Eigen::SparseMatrix<double> mean_slopes(const Eigen::VectorXd &x) const {
        std::vector<Eigen::Triplet<double>> entries;
        entries.reserve(12 * size * parts_.members.size());
        for (std::size_t t = 0; t < nodes_.size(); ++t) {
            const auto slope = tetrahedra_[t].slope(x);
            for (const auto &member : members(t))
                for (int column = 0; column < 12; ++column)
                    for (int row = 0; row < size; ++row)
                        entries.emplace_back(size * member.part + row, 3 * nodes_[t][column / 3] + column % 3,
                                             member.in_mean * slope(row, column));
        }
        Eigen::SparseMatrix<double> slopes(size * static_cast<Eigen::Index>(parts_.num_parts()), x.size());
        slopes.setFromTriplets(entries.begin(), entries.end());
        return slopes;
    }

    /// Stiffness that the stresses of all add when edges turn.
    Eigen::SparseMatrix<double> turning_hessian(const Eigen::VectorXd &x, Tangent tangent) const {
        const auto stress = gathered(stresses(x, x, 0.0));
        return sum_of_blocks(nodes_, x.size(),
                             [&](std::size_t t) { return tetrahedra_[t].curvature(x, stress[t], tangent); });
    }

    CoupledSprings springs_;
    MeanParts parts_;
    NodalParts nodal_;                      // what fast kernels have to know beside edges
    std::vector<std::array<int, 4>> nodes_; // (M)
    std::vector<double> volume_;            // (M) at rest [m^3]
    std::vector<Measure> tetrahedra_;
    std::vector<double> tetrahedron_modulus_; // (M) [Pa]; empty where those of a region are one
    double part_ = 1.0;                       // see RelaxingTerm::relaxed()
    Eigen::VectorXd added_;                   // (6 C), or empty
    Values fixed_stress_;                     // (C) where the body stays, see FixableTerm; or empty
    std::vector<typename Measure::Stiffness> fixed_stiffness_;
};

} // namespace

std::span<const CoupledSprings> all_coupled_springs() {
    static const auto table = [] {
        const StrainDomains nodes{.nodes = 1.0 - part_inside_beside_nodes, .tetrahedra = part_inside_beside_nodes};
        const StrainDomains edges{.edges = 1.0 - part_inside_beside_edges, .tetrahedra = part_inside_beside_edges};
        std::vector<CoupledSprings> springs;
        for (const auto &energy : all_spring_energies()) {
            using enum StrainMeasure;
            if (energy.is_finite) {
                springs.push_back({"nodal_springs", nodes, elongation, energy, false});
                continue;
            }
            for (const auto &[measure, ending] : {std::pair(cauchy_green, ""), std::pair(deformation_gradient, "_f")}) {
                springs.push_back({"nodal_" + energy.name + ending, nodes, measure, energy, false});
                springs.push_back({"edge_" + energy.name + ending, edges, measure, energy, true});
            }
        }
        return springs;
    }();
    return table;
}

const CoupledSprings &find_coupled_springs(std::string_view name) {
    return support::find_named(all_coupled_springs(), std::string(name), "springs that are coupled");
}

bool are_in_kernels(const CoupledSprings &springs) {
    const bool are_around_nodes = springs.domains.nodes > 0.0, are_around_edges = springs.domains.edges > 0.0;
    if (are_around_nodes == are_around_edges || springs.averages_volumes != are_around_edges)
        return false;
    if (are_around_edges && springs.measure == StrainMeasure::elongation)
        return false;
    const auto &measures = springs.energy.in_kernels;
    return springs.energy.kernels && std::ranges::find(measures, springs.measure) != measures.end();
}

CoupledSprings with_part_inside(CoupledSprings springs, double part) {
    auto &[nodes, edges, tetrahedra] = springs.domains;
    const double others = (1.0 - part) / (nodes + edges);
    nodes *= others;
    edges *= others;
    tetrahedra = part;
    return springs;
}

std::shared_ptr<const ElasticTerm> coupled_springs(const core::Body &body, const CoupledSprings &springs) {
    switch (springs.measure) {
    case StrainMeasure::elongation:
        return std::make_shared<CoupledTerm<Elongations>>(body, springs);
    case StrainMeasure::cauchy_green:
        return std::make_shared<CoupledTerm<SquaredLengths>>(body, springs);
    case StrainMeasure::deformation_gradient:
        break;
    }
    return std::make_shared<CoupledTerm<Gradients>>(body, springs);
}

std::shared_ptr<const ElasticTerm> volume_beside_coupled_springs(const core::Body &body,
                                                                 const CoupledSprings &springs) {
    if (!needs_volume(body))
        return nullptr;
    std::vector<double> modulus;
    std::ranges::transform(body.materials, std::back_inserter(modulus), modulus_beside_springs);
    const auto parts = nodal_parts(body);
    auto volumes =
        springs.averages_volumes ? mean_volumes_around_nodes(parts, modulus) : volumes_around_nodes(parts, modulus);
    volumes.measure = springs.energy.volume;
    return volume_penalty(body.mesh, volumes);
}

namespace {

/// Softness of facets below a tool, beside what the springs do. Means around nodes are too soft themselves where a
/// circle of contact has one edge in its radius, so that theirs fades earlier.
constexpr core::FacetSoftness softness_beside_nodes{.at_first = 0.25, .fades_at = 0.7},
    softness_beside_edges{.at_first = 0.28, .fades_at = 1.0};

} // namespace

core::FacetSoftness softness_below_tools(const CoupledSprings &springs) {
    if (springs.domains.edges > 0.0)
        return softness_beside_edges;
    return springs.domains.nodes > 0.0 ? softness_beside_nodes : core::softness_of_tetrahedra;
}

ElasticBody coupled_springs_with_volume(const core::Body &body, const CoupledSprings &springs) {
    std::vector<std::shared_ptr<const ElasticTerm>> terms{coupled_springs(body, springs)};
    if (auto volume = volume_beside_coupled_springs(body, springs))
        terms.push_back(std::move(volume));
    if (springs.energy.is_finite)
        terms.push_back(inversion_guard(body));
    ElasticBody elastic(lumped_masses(body), std::move(terms));
    elastic.preconditioner = [body](double part) { return stiffness_of_softer_volume(body, part); };
    elastic.softness = softness_below_tools(springs);
    if (const auto capsule = coupled_capsule(body))
        elastic.add(capsule);
    return elastic;
}

} // namespace livermark::msm
