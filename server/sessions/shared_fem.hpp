#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/problem.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/repeated_loads.hpp"
#include "server/session.hpp"

/// Finite elements that several sessions of the live page ask.
namespace livermark::server {

/// The stiffness of one body, constrained one way, and its factor, which fills hundreds of megabytes: all sessions that
/// are about the same share it, whatever file they have it from, and it goes with the last of them. Sessions in
/// several threads may ask at once; solutions wait for each other.
class SharedFem {
  public:
    /// That of a body, which is made now if nobody has it.
    /// @param constrained  see LiveBody::constrained
    /// @param report  called with what it waits for
    static std::shared_ptr<SharedFem> of(const std::shared_ptr<const core::Body> &body,
                                         const core::LoadCase &constrained, const ReportProgress &report);

    /// Static hyperelasticity of the elements that models::static_reference() of large loads names, on one mesh; while
    /// it is solved nobody else is served.
    /// @throws support::InputError if there is no equilibrium under the whole load
    static hyperelastic::PathSolution solve_hyperelastic(const core::Problem &problem, const ReportProgress &report);

    /// How many there are, of which each has a factor.
    static int count();

    ~SharedFem();
    SharedFem(const SharedFem &) = delete;
    SharedFem &operator=(const SharedFem &) = delete;

    /// @param load_case  constrains what was said
    /// @param last, inner  of this session, see fem_reference::RepeatedLoads::solve()
    /// @return with displacements of the nodes, which have converged
    /// @throws support::InputError if the body is not constrained, or iterations do not come to an end
    fem_reference::RepeatedLoads::Solution solve(const core::LoadCase &load_case, std::vector<double> &last,
                                                 const ReportProgress &report,
                                                 const fem_reference::RepeatedLoads::InnerForces &inner = {});

  private:
    struct Impl;
    explicit SharedFem(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::server
