#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/interior_place.hpp"
#include "core/problem.hpp"

namespace livermark::fem_reference {

/// Static linear elasticity of one body with quadratic elements, as StaticSolver has it, for many load cases that
/// constrain the same facets and follow each other as somebody leads a tool: displacements only, the same factor for
/// all, and where iterations are cheaper than a factor, iterations that begin with the last solution.
class RepeatedLoads {
  public:
    /// Beyond so many unknowns, edge midpoints included, there is no factor of the quadratic elements but one of the
    /// linear ones on the same body, the coarse level of conjugate gradients. On the liver that ships (70,000 unknowns)
    /// a factor takes 685 MB and 6.8 s of a core, then 0.12 s for each solution; two levels take 92 MB and 0.9 s, then
    /// 0.25 s near the last solution (0.46 s at a Poisson's ratio of 0.49).
    static constexpr int largest_factor = 30'000;

    /// Norm of the residual over that of the loads at which iterations stop.
    static constexpr double tolerance = 1e-6;

    /// Assembles and factorises.
    /// @param body  as for StaticSolver
    /// @param constrained  what every load case to come constrains
    /// @param report  called with a sentence as each stage begins
    /// @throws std::invalid_argument if a boundary triangle is not an outer face, or the load case is not for the mesh
    /// @throws std::runtime_error if the memory does not hold the factor
    RepeatedLoads(const core::Body &body, const core::LoadCase &constrained,
                  const std::function<void(const std::string &sentence)> &report, int largest = largest_factor);
    ~RepeatedLoads();
    RepeatedLoads(const RepeatedLoads &) = delete;
    RepeatedLoads &operator=(const RepeatedLoads &) = delete;

    struct Solution {
        bool is_unique = false; ///< whether what is constrained keeps the body from moving as a rigid one
        bool has_converged = false;
        int iterations = 0;                      ///< 0 with a factor
        double work = 0.0;                       ///< sum of f_i . u_i over all nodes of the elements [J]
        std::vector<core::Vector3> displacement; ///< (N) of the mesh nodes [m]; empty unless unique
        std::vector<core::Vector3> at_places;    ///< (K) in the mean over the places inside [m]; empty unless unique
    };

    /// What acts inside the body.
    struct InnerForces {
        std::vector<core::InteriorPlace> places; ///< (K)
        std::vector<core::Vector3> forces;       ///< (K) [N]
    };

    /// @param load_case  constrains what the first one did, at zero
    /// @param last       (n) all unknowns of the solution before, from which iterations begin; empty before the first
    ///   one. It becomes those of this one.
    /// @param inner      beside the load case
    /// @throws std::invalid_argument if a place is outside the body
    Solution solve(const core::LoadCase &load_case, std::vector<double> &last, const InnerForces &inner = {});

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace livermark::fem_reference
