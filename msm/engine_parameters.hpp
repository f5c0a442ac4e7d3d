#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/problem.hpp"

namespace livermark::msm {

// Parameters of engines that people run: the numbers to type in, so that an engine comes as near to tissue of the
// body's materials as its own model of a soft body can. Each engine is a function and a line of a table. Formulas are
// of the sources of the engines (Engine::sources), and tested in
// tests/msm/fast/engine_parameters_test.cpp.

/// A number to type in.
struct EngineSetting {
    std::string name; ///< the engine's own
    double value = 0.0;
    std::string unit; ///< SI; empty if it has none
    std::string meaning;
};

/// An array to hand over.
struct EngineArray {
    std::string name;
    std::string unit; ///< SI; empty if it has none
    std::string meaning;
    std::variant<std::vector<double>, std::vector<int>> values; ///< (rows * columns), row by row; ints are node numbers
    std::size_t columns = 1;

    std::size_t rows() const;
};

/// A text to paste, such as a model file.
struct EngineText {
    std::string ending; ///< of its file, with the dot
    std::string text;
};

/// All that an engine has to be told of a body.
struct EngineParameters {
    std::string engine;
    std::vector<EngineSetting> settings;
    std::vector<EngineArray> arrays;
    std::vector<std::string> notes;  ///< how to use them, a sentence each
    std::vector<std::string> cannot; ///< what the engine cannot do, a sentence each
    std::optional<EngineText> text{};
};

struct EngineChoices {
    std::string law = "lloyd";     ///< of the springs, see all_spring_laws()
    std::optional<int> substeps{}; ///< in a frame, >= 1; that of the engine's function if it is left out
    double frame = 1.0 / 60.0;     ///< [s], > 0
};

struct Engine {
    std::string name;
    std::string summary; ///< the model of a soft body that it has, half a line
    std::string sources; ///< version of the sources that the formulas are of
    /// @param body  at rest, positive volumes
    EngineParameters (*parameters)(const core::Body &body, const EngineChoices &choices);
    bool has_capsule = false; ///< as springs on edges; others leave it out, which `cannot` says
    bool has_vessels = false; ///< as springs between points of tetrahedra
};

/// Every engine, in alphabetical order.
std::span<const Engine> all_engines();

/// @throws support::InputError if there is no engine or no spring law of that name, or a choice is out of range
EngineParameters engine_parameters(const core::Body &body, const std::string &engine, const EngineChoices &choices);

/// Mean shear modulus of springs over that of the material that they stand for. Averaged over all directions, springs
/// have the energy density of lambda = mu with 15 mu V = sum of k l^2. (Van Gelder's have 1 on every mesh where they
/// are made for lambda = mu; Lloyd's have 0.96 on regular tetrahedra, and more on others.)
/// @param stiffness  (S) [N/m]
/// @param length     (S) at rest [m]
/// @param body       whose shear modulus is meant
double mean_shear_modulus_ratio(const std::vector<double> &stiffness, const std::vector<double> &length,
                                const core::Body &body);

/// Stiffness coefficient of Godot's SoftBody3D (linear_stiffness, from 0 to 1) for edges of a stiffness. From version
/// 4.7 on it is the part of an elongation that a substep takes away:
///   compliance = step^2 (1 / s - 1) 2 / m,   so s = x / (1 + x) with x = 2 k step^2 / m.
/// @param stiffness   k [N/m], > 0
/// @param point_mass  m, of each point [kg]
/// @param step        a frame over simulation_precision [s]
double godot_linear_stiffness(double stiffness, double point_mass, double step);

/// The same before: k = largest s^3, with largest = 1e5 N/m in Godot 4.4 to 4.6 with Jolt, and 1e6 N/m in the extension
/// Godot Jolt; 1 where k is larger.
/// @param largest  [N/m]
double godot_linear_stiffness_by_cube(double stiffness, double largest);

/// Lame parameters to type in for the stable neo-Hookean law with a logarithm,
///   W = mu' / 2 (I - 3) + lambda' / 2 (J - a)^2 - mu' / 2 ln(I + 1),   a = 1 + 3 mu' / (4 lambda'),
/// so that it is the material at small strains: mu' = 4/3 mu, lambda' = lambda + 5/6 mu.
/// (Smith, de Goes, Kim 2018, ACM Trans. Graph. 37(2), section 3.4.)
struct LameParameters {
    double mu = 0.0;     ///< [Pa]
    double lambda = 0.0; ///< [Pa]
};
LameParameters stable_neo_hookean(const core::Material &material);

/// Material to type into a flex of MuJoCo, whose force has lambda twice, so that it is the material at small strains:
/// nu' = nu / (2 - 2 nu), E' = E (1 + nu') / (1 + nu), which is mu' = mu and lambda' = lambda / 2.
core::Material mujoco_material(const core::Material &material);

} // namespace livermark::msm
