#include "results/problem_key.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <functional>
#include <span>
#include <string_view>
#include <type_traits>

#include "core/support/files.hpp"

namespace livermark::results {

namespace {

/// Hash of numbers that count with nine digits.
class RoundedHash : public support::FnvHash {
  public:
    template <class Value> void add_all(const Value &value) {
        if constexpr (std::is_floating_point_v<Value>)
            add(fmt::format("{:.8e}", value == 0.0 ? 0.0 : value));
        else if constexpr (std::is_integral_v<Value> || std::is_enum_v<Value>)
            add(fmt::format("{}", static_cast<int>(value)));
        else
            for (const auto &part : value)
                add_all(part);
    }
};

/// Hash of every bit. The library's hash takes eight bytes at a time, and meshes are large.
class ExactHash : public support::FnvHash {
  public:
    template <class Values> void add_all(const Values &values) {
        const auto bytes = std::as_bytes(std::span(values));
        const std::string_view letters(reinterpret_cast<const char *>(bytes.data()), bytes.size());
        add(fmt::format("{:x}", std::hash<std::string_view>()(letters)));
    }
};

template <class Hash> void add_events(Hash &hash, const core::LoadCase &load_case, bool in_time) {
    core::for_each_event(load_case, [&](const auto &event) {
        if (event.in_time == in_time)
            event.add_to(hash);
    });
}

/// The one list of what a solution depends on beside the model. Its order is in the names of stored references.
template <class Hash> void add_problem(Hash &hash, const core::Problem &problem) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    const auto facets = facet_arrays(load_case);
    hash.add_all(mesh.points);
    hash.add_all(mesh.tetrahedra);
    hash.add_all(mesh.boundary_triangles);
    hash.add_all(mesh.region);
    for (const auto &material : problem.body->materials)
        hash.add_all(std::array{material.density, material.young_modulus, material.poisson_ratio});
    hash.add(core::to_string(load_case.regime));
    hash.add_all(facets.condition);
    hash.add_all(facets.constraint);
    hash.add_all(facets.follows);
    hash.add_all(load_case.value);
    hash.add_all(load_case.node_factor);
    hash.add_all(load_case.node_shift);
    hash.add_all(facets.round_load);
    for (const auto &load : facets.round_loads) {
        hash.add_all(std::array{load.middle});
        hash.add_all(std::array{load.radius});
    }
    if (load_case.press_depth != 0.0) // others keep the name that they had before there was one
        hash.add_all(std::array{load_case.press_depth});
    add_events(hash, load_case, false);
    hash.add_all(std::array{load_case.acceleration});
    hash.add_all(load_case.path);
    for (const auto &name : facets.constraint_names)
        hash.add(name);
    add_events(hash, load_case, true);
}

std::string digits_of(const support::FnvHash &hash) {
    return fmt::format("{:016x}", hash.value());
}

} // namespace

FacetArrays facet_arrays(const core::LoadCase &load_case) {
    FacetArrays arrays;
    arrays.constraint_names = load_case.constraint_names();
    arrays.load_names = load_case.load_names();
    arrays.round_loads = load_case.round_loads();
    const auto num_facets = load_case.condition_on.size();
    const bool has_names =
        std::ranges::any_of(arrays.load_names, [](const std::string &name) { return !name.empty(); });
    if (has_names)
        arrays.load.assign(num_facets, -1);
    if (load_case.has(core::ConditionKind::pressure))
        arrays.follows.assign(num_facets, 0);
    if (!arrays.round_loads.empty())
        arrays.round_load.assign(num_facets, -1);
    std::vector<int> number_of_round;
    int num_round = 0;
    for (const auto &condition : load_case.conditions)
        number_of_round.push_back(condition.round ? num_round++ : -1);
    for (int f = 0; f < load_case.num_facets(); ++f) {
        const auto *condition = load_case.on(f);
        arrays.condition.push_back(!condition                 ? free_facet
                                   : condition->is_traction() ? traction_facet
                                                              : prescribed_facet);
        arrays.constraint.push_back(load_case.constraint_on(f));
        if (has_names)
            arrays.load[f] = load_case.load_on(f);
        if (load_case.follows_surface(f))
            arrays.follows[f] = 1;
        if (load_case.round_load_on(f))
            arrays.round_load[f] = number_of_round[load_case.condition_on[f]];
    }
    return arrays;
}

std::string problem_key(const core::Problem &problem) {
    ExactHash hash;
    hash.add(problem.body->name);
    hash.add(problem.load_case.name);
    hash.add(problem.load_case.definition);
    add_problem(hash, problem);
    hash.add_all(std::array{problem.load_case.load_scale});
    return digits_of(hash);
}

std::string fingerprint(const core::Problem &problem, const std::string &model) {
    RoundedHash hash;
    hash.add(model);
    add_problem(hash, problem);
    return digits_of(hash);
}

} // namespace livermark::results
