#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/capsule.hpp"
#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/vessels.hpp"

namespace livermark::core {

/// Isotropic elastic material.
struct Material {
    double density;       ///< rho [kg/m^3], > 0
    double young_modulus; ///< E [Pa], > 0, at small strain
    double poisson_ratio; ///< nu, in (-1, 0.5), at small strain
    /// Dimensionless constants of hyperelastic laws, by the name of the law, where a source gives them for this
    /// material.
    std::map<std::string, std::vector<double>> law_constants{};

    /// First Lame parameter, lambda = E nu / ((1 + nu)(1 - 2 nu)) [Pa].
    double lame_lambda() const {
        return young_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
    }
    /// Shear modulus, mu = E / (2 (1 + nu)) [Pa].
    double shear_modulus() const { return young_modulus / (2.0 * (1.0 + poisson_ratio)); }
};

/// The axes of a patient in the coordinates of a mesh. Load cases of livers have directions in LPS: x to the patient's
/// left, y posterior, z superior.
struct BodyAxes {
    Eigen::Matrix3d from_lps = Eigen::Matrix3d::Identity().eval(); ///< rotation of a direction
    /// Load cases that name one of these patches have such directions; those of others are along the axes of the mesh.
    /// Empty: every load case has them.
    std::vector<std::string> patches{};
    std::string doubt{}; ///< why the rotation is not known, a clause; empty where it is
};

/// A mesh with what it is made of.
struct Body {
    std::string name;
    TetraMesh mesh;
    std::vector<Material> materials; ///< (R) one per mesh.region_names
    /// Sentences on what its files do not say and somebody had to assume: units, materials, patches.
    std::vector<std::string> assumptions{};
    /// Clearness of the orientation in which its patches were found, from 0 to 1; none where its files name them.
    std::optional<double> patch_confidence{};
    BodyAxes axes{};
    std::optional<Capsule> capsule{};
    std::optional<VesselTree> vessels{}; ///< that the mesh has no elements of
    /// (M) moduli of each tetrahedron over those of the material of its region, > 0, as a map of stiffness has them;
    /// empty where all are 1.
    std::vector<double> modulus_factor{};

    double modulus_factor_of(std::size_t t) const { return modulus_factor.empty() ? 1.0 : modulus_factor[t]; }
    /// Material of a tetrahedron: that of its region, with its own Young's modulus.
    Material material_of(std::size_t t) const {
        auto material = materials[static_cast<std::size_t>(mesh.region[t])];
        material.young_modulus *= modulus_factor_of(t);
        return material;
    }
    double shear_modulus_of(std::size_t t) const {
        return materials[static_cast<std::size_t>(mesh.region[t])].shear_modulus() * modulus_factor_of(t);
    }
    double young_modulus_of(std::size_t t) const {
        return materials[static_cast<std::size_t>(mesh.region[t])].young_modulus * modulus_factor_of(t);
    }
};

/// Problem that every model gets: a body and the load case put on its mesh. The body is shared between load cases.
struct Problem {
    std::shared_ptr<const Body> body;
    LoadCase load_case;
};

} // namespace livermark::core
