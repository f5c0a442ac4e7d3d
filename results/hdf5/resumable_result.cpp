#include "results/hdf5/resumable_result.hpp"

#include <algorithm>

#include "results/hdf5/result_file.hpp"
#include "support/input_error.hpp"

namespace livermark::results {

namespace {

bool is_same_body(const core::Body &a, const core::Body &b) {
    const auto same_material = [](const core::Material &x, const core::Material &y) {
        return x.density == y.density && x.young_modulus == y.young_modulus && x.poisson_ratio == y.poisson_ratio;
    };
    return a.name == b.name && a.mesh.points == b.mesh.points && a.mesh.tetrahedra == b.mesh.tetrahedra &&
           a.mesh.region == b.mesh.region && a.mesh.boundary_triangles == b.mesh.boundary_triangles &&
           std::ranges::equal(a.materials, b.materials, same_material);
}

/// The definition says the rest: what is recorded, and where.
bool is_same_load(const core::LoadCase &a, const core::LoadCase &b) {
    return a.name == b.name && a.definition == b.definition && a.constraint_names == b.constraint_names &&
           core::are_statically_equal(a, b);
}

} // namespace

std::optional<Result> resumable_result(const std::filesystem::path &file, const core::Problem &problem,
                                       const Provenance &provenance) {
    std::error_code error;
    if (!std::filesystem::exists(file, error))
        return {};
    try {
        auto kept = read_result(file);
        if (kept.provenance.command == provenance.command && kept.provenance.git_commit == provenance.git_commit &&
            kept.provenance.build_type == provenance.build_type && is_same_body(*kept.problem.body, *problem.body) &&
            is_same_load(kept.problem.load_case, problem.load_case))
            return kept;
    } catch (const support::InputError &) {
        return {}; // not a whole result file, so nothing to go on from
    }
    return {};
}

} // namespace livermark::results
