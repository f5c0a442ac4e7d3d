#include "app/live/springs.hpp"

#include <algorithm>
#include <utility>

#include "app/live/parameters.hpp"
#include "core/support/input_error.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"

namespace livermark::live {

namespace {

using Terms = std::vector<std::shared_ptr<const msm::ElasticTerm>>;

constexpr double reference_young_modulus = 1000.0; // [Pa]
constexpr double largest_poisson_ratio_of_guard = 0.45;

/// Nobody presses a tumour to half its volume when it lies in something softer, and a guard as stiff as it is would ask
/// for shorter steps. Springs alone get a guard as well: they would stay inside out. It does nothing before a
/// tetrahedron has lost half its volume.
std::shared_ptr<const msm::ElasticTerm> guard(const core::Body &body) {
    return msm::inversion_guard(with_material_of_guard(body));
}

/// Body with the Young's modulus that laws are asked with; springs are in proportion to it.
core::Body reference_of(const core::Body &own) {
    return with_material(own, reference_young_modulus, 0.25);
}

/// Factor by which springs of a law are stiffer than those of the reference.
double factor_of_springs(const core::Body &body, const Settings &settings) {
    const auto &material = body.materials[largest_region(body.mesh)];
    const double carried = settings.keeps_volume ? 2.5 * material.shear_modulus() : material.young_modulus;
    return carried / reference_young_modulus;
}

msm::MassSprings springs_of_law(const core::Body &own, const core::Body &body, const Settings &settings,
                                SpringsOfLaws &kept) {
    auto known = kept.find(settings.springs);
    if (known == kept.end()) {
        const auto &law = support::find_named(msm::all_spring_laws(), settings.springs, "spring law");
        known = kept.emplace(settings.springs, msm::spring_network(reference_of(own), law)).first;
    }
    auto springs = known->second;
    const double factor = factor_of_springs(body, settings);
    for (double &k : springs.stiffness)
        k *= factor;
    Terms terms{msm::spring_term(springs), guard(body)};
    // At Poisson's ratio 1/4 springs alone are the material.
    if (settings.keeps_volume && settings.poisson_ratio != 0.25)
        terms.push_back(msm::volume_beside_springs(body, msm::find_volume_term("nodal_volume")));
    msm::ElasticBody elastic(springs.node_mass, std::move(terms));
    return {std::move(springs), std::move(elastic)};
}

/// Springs that are coupled around nodes or edges; those with an energy get the guard as well, because a hand that
/// presses hard takes explicit steps past the state in which a tetrahedron is flat.
msm::MassSprings coupled_springs_of(const core::Body &body, const Settings &settings) {
    const auto material = settings.keeps_volume
                              ? body
                              : with_material(body, body.materials[largest_region(body.mesh)].young_modulus, 0.25);
    const auto &coupled = msm::find_coupled_springs(settings.springs);
    Terms terms{msm::coupled_springs(material, coupled)};
    if (auto volume = msm::volume_beside_coupled_springs(material, coupled))
        terms.push_back(std::move(volume));
    terms.push_back(guard(material));
    core::SpringNetwork springs{.node_mass = msm::lumped_masses(material),
                                .edges = core::edge_table(body.mesh.tetrahedra).edges,
                                .stiffness = {},
                                .rest_length = {}};
    msm::ElasticBody elastic(springs.node_mass, std::move(terms));
    return {std::move(springs), std::move(elastic)};
}

bool is_law(const std::string &springs) {
    const auto laws = msm::all_spring_laws();
    return std::ranges::any_of(laws, [&](const auto &law) { return law.name == springs; });
}

} // namespace

bool keep_from_inverting(const std::string &springs) {
    const auto coupled = msm::all_coupled_springs();
    const auto found = std::ranges::find(coupled, springs, &msm::CoupledSprings::name);
    return found != coupled.end() && !found->energy.is_finite;
}

const std::vector<std::string> &spring_names() {
    static const auto names = [] {
        std::vector<std::string> found;
        for (const auto &law : msm::all_spring_laws())
            found.push_back(law.name);
        for (const auto &springs : msm::all_coupled_springs())
            if (msm::are_in_kernels(springs))
                found.push_back(springs.name);
        return found;
    }();
    return names;
}

core::Body with_material_of_guard(core::Body body) {
    auto material = body.materials[largest_region(body.mesh)];
    material.poisson_ratio = std::min(material.poisson_ratio, largest_poisson_ratio_of_guard);
    body.materials.assign(body.materials.size(), material);
    return body;
}

msm::MassSprings mass_springs(const core::Body &own, const Settings &settings, SpringsOfLaws &kept) {
    const auto body = with_material(own, settings.young_modulus, settings.poisson_ratio);
    return is_law(settings.springs) ? springs_of_law(own, body, settings, kept) : coupled_springs_of(body, settings);
}

std::optional<msm::SpringSource> spring_source(const core::Body &own, const Settings &settings) {
    if (!is_law(settings.springs))
        return std::nullopt;
    const auto body = with_material(own, settings.young_modulus, settings.poisson_ratio);
    return msm::SpringSource{support::find_named(msm::all_spring_laws(), settings.springs, "spring law"),
                             reference_of(own), factor_of_springs(body, settings)};
}

} // namespace livermark::live
