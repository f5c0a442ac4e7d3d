#pragma once

#include <Eigen/Core>
#include <memory>

#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// A term of which some stresses relax, one by one where they are: s, with strains e that they do work on. The stress
/// of the elastic law is s_e(x) + s(x), where s_e stays. What relaxes in which term, see core::PronySeries:
///
/// - Springs: the whole tension of each along itself [N]. All springs with one part, so the body keeps the Poisson's
///   ratio of its lattice, and its bulk modulus fades with its shear modulus. That is not what the series says of
///   tissue, but springs alone cannot do better.
/// - Springs coupled around nodes, around edges or inside tetrahedra: of each mean the second Piola-Kirchhoff stress
///   that resists changes of shape, in the six components of edge_stretches.hpp [Pa]. Its pressure stays, also that of
///   means of F, where the stress turns with the body.
/// - Volumes (volume_penalty.hpp) and the guard against inversion are no such terms: they stay elastic. Beside central
///   springs they hold lambda - mu alone, so of the bulk modulus lambda + 2/3 mu the springs' part of 5/3 mu fades.
class RelaxingTerm : public ElasticTerm {
  public:
    /// s at positions x, all behind each other.
    /// @return shape (S), here and below
    virtual Eigen::VectorXd relaxing_stress(const Eigen::VectorXd &x) const = 0;

    /// force -= sum over S of stress (d e / dx): what such stresses do to the nodes [N].
    virtual void add_force_of(const Eigen::VectorXd &x, const Eigen::VectorXd &stress,
                              Eigen::VectorXd &force) const = 0;

    /// What a stress has to be squared and multiplied with to be twice its energy, at rest: the volume over 2 mu, or
    /// one over the stiffness of a spring [J], per squared unit of s.
    virtual Eigen::VectorXd relaxing_compliance() const = 0;

    /// The same term with the stresses s_e + part s + added. It has the energy U_e + part U_s + sum of added e. What
    /// relaxes of it is part s.
    /// @param part   what is left of s, not negative
    /// @param added  does not depend on x; if empty, nothing
    virtual std::shared_ptr<const RelaxingTerm> relaxed(double part, const Eigen::VectorXd &added) const = 0;
};

} // namespace livermark::msm
