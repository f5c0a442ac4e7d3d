#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/tool/touching_tool.hpp"
#include "fem_reference/hyperelastic/reference_element.hpp"
#include "fem_reference/hyperelastic/surface/surface_stiffness.hpp"

namespace livermark::hyperelastic {

/// How contact is enforced.
struct ContactSettings {
    /// Penalty eps over E / sqrt(R d) with the largest Young's modulus E of the body, the radius R of the ball and its
    /// depth d: Hertz's ball sinks in by 1 / stiffness of its depth beyond the surface.
    double stiffness = 100.0;
    double sunk_in = 1e-3;     ///< of the depth, weighted with pressure, where augmentation ends
    int max_augmentations = 4; ///< at each point of the path
};

/// What touches at a state.
struct TouchSums {
    core::Vector3 force = core::Vector3::Zero();    ///< on the body [N]
    core::Vector3 friction = core::Vector3::Zero(); ///< of that by friction [N]
    double area = 0.0;                              ///< of the surface at rest [m^2]
    double slipping_area = 0.0;                     ///< of that [m^2]
    double sunk_in = 0.0;                           ///< penetration in the mean weighted with pressure [m]
    /// sqrt(5/2) times the distance from the axis through the centre of the ball along its press, in the quadratic mean
    /// weighted with pressure: of Hertz's pressure the radius of contact [m].
    double radius = 0.0;
};

/// A rigid ball that touches a body (core::TouchingTool): the integrals
///     f_a = integral over the surface at rest of N_a (p n + tau) dA
/// at the seven points of ReferenceTriangle on each facet that may touch, with core::touch() at x = X + u. Pressures
/// are on the area at rest. Multipliers of augmentation and anchors of friction are kept at the points.
class TouchingBall {
  public:
    /// @param system  kept alive and unchanged by the caller
    /// @param body, load_case  that it was assembled on; with a ball that touches
    TouchingBall(const fem_reference::ElasticSystem &system, const core::Body &body, const core::LoadCase &load_case,
                 const ContactSettings &settings = {});

    const core::TouchingTool &tool() const { return tool_; }
    const core::ContactLaw &law() const { return law_; }
    const ContactSettings &settings() const { return settings_; }

    /// @param centre        where the ball is [m]
    /// @param displacement  shape (3 n) [m]
    /// @param force         shape (3 n) [N], added to
    void add_forces(const core::Vector3 &centre, std::span<const double> displacement,
                    std::vector<double> &force) const;
    /// The derivatives of minus the forces. Curvature and slip take no more than largest_pressure(), so that Newton's
    /// method has a direction where the ball has moved and the body not yet.
    /// @param expected  shape (num_points()) [Pa], of expected_pressure(): what the curvature of the ball takes where
    ///   the pressure is more; or empty, and the derivatives are exact up to largest_pressure()
    void add_stiffness(const core::Vector3 &centre, std::span<const double> displacement, SurfaceStiffness &stiffness,
                       std::span<const double> expected = {}) const;
    /// The pressure that the tangent expects after a change of the displacement, max(0, p - eps n . du), at points that
    /// touch before it, and zero at others. A small step along the ball makes the pressure of a stiff penalty
    /// much larger than that, so that the curvature of a tangent with it is wrong, and large enough to make the tangent
    /// indefinite. Newton's method converges in fewer iterations where the tangent has the expected one (D. Magisano,
    /// L. Leonetti, G. Garcea 2017, How to improve efficiency and robustness of the Newton method in geometrically
    /// non-linear structural problem discretized via displacement-based finite elements, Comput. Methods Appl. Mech.
    /// Eng. 313).
    /// @param change  shape (3 n) [m]; or empty for none
    /// @return shape (num_points()) [Pa]
    std::vector<double> expected_pressure(const core::Vector3 &centre, std::span<const double> displacement,
                                          std::span<const double> change = {}) const;
    TouchSums sums(const core::Vector3 &centre, std::span<const double> displacement) const;

    /// Pressures become multipliers (Uzawa), so that the ball sinks in less.
    void augment(const core::Vector3 &centre, std::span<const double> displacement);
    /// What sticks and what has slipped is kept for the steps to come.
    void end_step(const core::Vector3 &centre, std::span<const double> displacement);

    double largest_pressure() const { return largest_pressure_; } ///< [Pa]
    std::size_t num_points() const { return memory_.size(); }     ///< of all facets that may touch

  private:
    struct Facet {
        std::vector<int> nodes;
        double area; ///< [m^2]
    };
    template <class Visit>
    void visit(const core::Vector3 &centre, std::span<const double> displacement, const Visit &visit) const;

    const fem_reference::ElasticSystem *system_;
    core::TouchingTool tool_;
    ContactSettings settings_;
    core::ContactLaw law_;
    double largest_pressure_ = 0.0;
    std::vector<Facet> facets_;
    ReferenceTriangle reference_;
    std::vector<core::ContactMemory> memory_; ///< (facets, points)
};

} // namespace livermark::hyperelastic
