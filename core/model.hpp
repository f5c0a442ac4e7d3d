#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/places.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::core {

/// A model on one body. What it has worked out for the body, such as factors, it keeps as long as it lives, and solves
/// every load case with. For one thread.
class PreparedModel {
  public:
    PreparedModel() = default;
    virtual ~PreparedModel() = default;
    PreparedModel(const PreparedModel &) = delete;
    PreparedModel &operator=(const PreparedModel &) = delete;

    /// Static solutions, and the histories of time-dependent load cases. Each is what it would be alone, but for
    /// rounding. Throws only for what is not the load's fault.
    /// @param load_cases  on the mesh of the body
    virtual std::vector<Solution> solve(std::span<const LoadCase> load_cases) = 0;
};

/// Makes a model ready for a body.
/// @param common  a load case that constrains what many of those to come constrain too, maybe among more; nullptr if
///   there is none. A factor of it may serve them all; solutions change by rounding only.
using PrepareModel =
    std::function<std::unique_ptr<PreparedModel>(const std::shared_ptr<const Body> &body, const LoadCase *common)>;

/// Role of a model among the others.
enum class Role : std::uint8_t {
    candidate,            ///< is compared with the reference
    baseline,             ///< one that springs have to beat; scales loads to their targets
    reference,            ///< what others are compared with
    substitute_reference, ///< the same where the reference finds no solution; has no finer meshes of its own
    refined_reference     ///< the reference on finer meshes: tells how good it is, and takes its place where it is not
                          ///< good enough
};

/// A deformable model of the suite.
struct Model {
    std::string name;    ///< on the command line, in the result file, in the tests
    std::string summary; ///< one line
    std::string source;  ///< literature reference
    PrepareModel prepare;
    std::size_t most_together = 1; ///< load cases that take less time together than one by one
    /// Its lowest modes, as many as asked for, with the constraints of the load case; empty if it cannot tell. Throws
    /// InputError if the body is free to move or has too few.
    std::function<Modes(const Problem &, int)> modes{};
    /// Compliance of the body at rest at some places inside, with the constraints of the load case; empty if it cannot
    /// tell. Throws InputError if the body is free to move.
    std::function<Compliance(const Problem &, std::span<const InteriorPlace>)> compliance{};
    /// Whether it can do what its user asked for on a problem; throws InputError if not. Called for every problem
    /// before the first one is solved. Empty if nothing can be wrong.
    std::function<void(const Problem &)> check{};
    Role at_rest = Role::candidate;   ///< in the regime that it judges
    Role in_motion = Role::candidate; ///< the same where something moves in time
    Regime judges = Regime::small;    ///< in the other one it is a candidate
    std::optional<Regime> only{};     ///< the regime that it takes part in; both if not set
    bool only_moving = false;         ///< whether it takes part only where something moves in time
    bool only_when_named = false;     ///< whether a run leaves it out unless its user names it
    /// The events that it follows; it takes no part where another one happens.
    EventSet follows = EventSet::of<Release, ToolMotion>();
    bool is_collective = false; ///< of several MPI ranks all have to call solve, and all get the solution

    /// Whether it takes part in a problem that it could; empty if it always does.
    std::function<bool(const Problem &)> is_wanted{};

    Role role_at_rest(Regime regime) const { return regime == judges ? at_rest : Role::candidate; }
    Role role_in_motion(Regime regime) const { return regime == judges ? in_motion : Role::candidate; }

    bool takes_part_in(const Problem &problem) const {
        return (!only || *only == problem.load_case.regime) && (!only_moving || problem.load_case.release) &&
               follows.has_all_of(problem.load_case.kinds()) && (!is_wanted || is_wanted(problem));
    }

    /// Prepares, solves one problem and keeps nothing.
    Solution solve(const Problem &problem) const;
};

/// For a model that has nothing to prepare.
PrepareModel solves_each(std::function<Solution(const Problem &)> solve);

/// Stiffnesses of springs that were fitted to the solutions of another model, and what they hold for.
struct CalibratedSprings {
    std::string origin;                    ///< the file that they come from, for messages
    std::vector<Material> materials;       ///< (R) that they were fitted for
    std::vector<std::array<int, 2>> edges; ///< (S) as in the EdgeTable of the mesh
    std::vector<double> rest_length;       ///< (S) [m]
    std::vector<double> stiffness;         ///< (S) [N/m], > 0
};

/// @throws InputError if they were fitted for a mesh with other edges or lengths, or for other elastic constants, than
///         the body has; the density has no part in them
void check_fit(const CalibratedSprings &springs, const Body &body);

} // namespace livermark::core
