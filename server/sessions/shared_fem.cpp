#include "server/sessions/shared_fem.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <mutex>
#include <string>
#include <utility>

#include "models/model_table.hpp"
#include "models/pushed_model.hpp"
#include "support/input_error.hpp"

namespace livermark::server {

namespace {

/// CHOLMOD, METIS and BLAS, as they are packaged, do not say that several threads may use them at once; and two factors
/// in the making need the memory of both.
std::unique_lock<std::mutex> alone(const ReportProgress &report) {
    static std::mutex mutex;
    std::unique_lock lock(mutex, std::try_to_lock);
    if (!lock) {
        report("Another page is being served.");
        lock.lock();
    }
    return lock;
}

bool are_equal(const core::Material &a, const core::Material &b) {
    return a.density == b.density && a.young_modulus == b.young_modulus && a.poisson_ratio == b.poisson_ratio;
}

/// Whether two bodies have the same stiffness, facet by facet.
bool are_equal(const core::Body &a, const core::Body &b) {
    return a.mesh.points == b.mesh.points && a.mesh.tetrahedra == b.mesh.tetrahedra && a.mesh.region == b.mesh.region &&
           a.mesh.boundary_triangles == b.mesh.boundary_triangles &&
           std::ranges::equal(a.materials, b.materials, [](const core::Material &of_a, const core::Material &of_b) {
               return are_equal(of_a, of_b);
           });
}

/// All that there are, for who asks next.
struct Known {
    std::mutex mutex;
    std::vector<std::weak_ptr<SharedFem>> all;
};

Known &known() {
    static Known known;
    return known;
}

} // namespace

struct SharedFem::Impl {
    std::shared_ptr<const core::Body> body;
    core::LoadCase constrained;
    fem_reference::RepeatedLoads loads;
};

SharedFem::SharedFem(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SharedFem::~SharedFem() = default;

std::shared_ptr<SharedFem> SharedFem::of(const std::shared_ptr<const core::Body> &body,
                                         const core::LoadCase &constrained, const ReportProgress &report) {
    // Whoever wants the same waits here until the first one has made it.
    const auto lock = alone(report);
    const std::lock_guard looking(known().mutex);
    auto &all = known().all;
    std::erase_if(all, [](const auto &one) { return one.expired(); });
    for (const auto &one : all)
        if (auto shared = one.lock(); shared && core::are_statically_equal(shared->impl_->constrained, constrained) &&
                                      are_equal(*shared->impl_->body, *body))
            return shared;
    std::unique_ptr<Impl> impl(new Impl{body, constrained, {*body, constrained, report}});
    std::shared_ptr<SharedFem> made(new SharedFem(std::move(impl)));
    all.push_back(made);
    return made;
}

hyperelastic::PathSolution SharedFem::solve_hyperelastic(const core::Problem &problem, const ReportProgress &report) {
    // Forces out of balance over the loads: the indentation is then right to fewer digits than a page shows.
    constexpr double tolerance = 1e-5;
    const auto lock = alone(report);
    report(fmt::format("Hyperelastic elements are being solved for the same forces: {} tetrahedra.",
                       problem.body->mesh.num_tetrahedra()));
    const auto elements = *models::hyperelastic_elements(models::static_reference(core::Regime::large).on_mesh);
    auto found = hyperelastic::solve(problem, hyperelastic::material_law(std::string(elements.law)),
                                     elements.discretisation, {.fractions = {1.0}, .tolerance = tolerance});
    if (found.solution.status != core::SolutionStatus::ok)
        throw support::InputError("they find no equilibrium under these forces; push less");
    return found;
}

int SharedFem::count() {
    const std::lock_guard looking(known().mutex);
    return static_cast<int>(std::ranges::count(known().all, false, &std::weak_ptr<SharedFem>::expired));
}

fem_reference::RepeatedLoads::Solution SharedFem::solve(const core::LoadCase &load_case, std::vector<double> &last,
                                                        const ReportProgress &report,
                                                        const fem_reference::RepeatedLoads::InnerForces &inner) {
    const auto lock = alone(report);
    auto solution = impl_->loads.solve(load_case, last, inner);
    if (!solution.is_unique)
        throw support::InputError(
            "what is constrained leaves the body, or a part of it, free to move as a rigid body; choose a "
            "result whose load case constrains it in all six ways");
    if (!solution.has_converged)
        throw support::InputError("the iterations do not come to an end; choose a smaller Poisson's ratio");
    return solution;
}

} // namespace livermark::server
