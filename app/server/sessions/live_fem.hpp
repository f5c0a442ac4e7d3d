#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "app/server/session.hpp"
#include "core/problem.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/linear_elasticity.hpp"

/// Finite elements that several sessions of the live page ask.
namespace livermark::server {

/// The stiffness of one body, constrained one way, and its factor, which fills hundreds of megabytes: all sessions that
/// are about the same share it, whatever file they have it from, and it goes with the last of them. Sessions in
/// several threads may ask at once; solutions wait for each other.
class SharedFem {
  public:
    /// Factor of a body, which is made now if nobody has it.
    /// @param constrained  see LiveBody::constrained
    /// @param report  called with what it waits for
    static std::shared_ptr<SharedFem> of(const std::shared_ptr<const core::Body> &body,
                                         const core::LoadCase &constrained, const ReportProgress &report);

    /// Static hyperelasticity of the elements that models::static_reference() of large loads names, on one mesh; while
    /// it is solved nobody else is served.
    /// @param report  called before the first and after each iteration of Newton's method
    /// @param inner   loads beside the load case
    /// @throws support::InputError if there is no equilibrium under the whole load
    static hyperelastic::PathSolution solve_hyperelastic(const core::Problem &problem, const ReportProgress &report,
                                                         const fem_reference::InnerForces &inner = {});

    /// Number of them, each with a factor.
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
                                                 const fem_reference::InnerForces &inner = {});

  private:
    struct Impl;
    explicit SharedFem(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Comparison for the springs of the live page: the solution of the reference of small motion, quadratic elements, for
/// the same tractions on the same body, constrained as open_live_body() says. Messages and their replies:
///
///     young_modulus=<Pa>&poisson_ratio=<nu>   other materials, see live::with_material(); until then those of the file
///     chosen=fem_p2                           the model
///
///     elements=<linear|hyperelastic>          what answers from here on: linear until others are chosen; the
///     chosen=fem_p2p1_neo_hookean             reference of large loads on the mesh, which takes seconds; or fem_p2
///
///     gone=<numbers with commas>              tetrahedra that cuts have taken away, of the whole body: from here on it
///     is
///                                             about what is left, of the file's materials until others are chosen
///     nodes=<number>                          of what is left; facets are those of the replies to cuts, see
///                                             app/live/messages.hpp; displacements are of all nodes, 0 of those that
///                                             are gone
///
///     binary float64, little-endian (1+L,4)   middle x y z of a round load and its radius [m]
///     (core/load_case.hpp),
///                                             then facet, and the mean traction on it x y z [Pa], which is spread as
///                                             that load, or evenly where its radius is 0; each facet once at most
///     binary, little-endian: float64          sum of f_i . u_i over the nodes of the elements, f being their forces
///                                             [J]: over the resultant it is the displacement along it in the mean
///                                             weighted with the tractions, as a load case with `press` prescribes it
///             float32 (N,3)                   displacement of the nodes [m]
///
///     needle=<x,y,z,x,y,z,radius>&forces=<3 K numbers>
///                                             a needle from entry to target, the radius over which its
///                                             forces are spread [m], and those on the tissue at the places of
///                                             core::needle_line() [N]
///     binary, little-endian: float64 (1+3)    sum of f_i . u_i [J], and the displacement of the target [m]
///             float32 (N,3)                   displacement of the nodes [m]
///
/// A facet that is not in the message has no traction, and nothing has after a message without rows; tractions on
/// facets that are constrained move nothing. The first solution pays for the factor of the stiffness, and so does the
/// first one after another Poisson's ratio, unless another session has it already: they share it, see SharedFem.
/// Solutions of several sessions wait for each other. Before a reply that takes long there are texts
///
///     progress=<sentence>                     what it waits for: another page, the assembly, the factor, iterations
///
/// which are no replies. A message that comes meanwhile ends the work on the one before, at the next iteration of
/// hyperelastic elements or while another page is served:
///
///     interrupted=by the next message         the reply then
///
/// Beyond RepeatedLoads::largest_factor unknowns solutions are those of iterations to a relative
/// residual of RepeatedLoads::tolerance, and begin with the last one of the session.
/// @param folder  that is served; absolute, without symlinks and dots
/// @param query   `file=<path>`, of the server's list
/// @throws support::InputError for what open_live_body() refuses; the session, for what is not as above
Session live_fem(const std::filesystem::path &folder, const Fields &query, const ReportProgress &report);

} // namespace livermark::server
