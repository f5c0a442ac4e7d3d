#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/support/input_error.hpp"
#include "meshes/generators/box_generator.hpp"
#include "msm/elastic_body.hpp"
#include "msm/engine_parameters.hpp"
#include "tests/bad_input.hpp"
#include "tests/samples/bodies_with_vessels.hpp"
#include "tests/samples/covered_bodies.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;
using msm::EngineParameters;

const core::Material tissue_of_engines{1060.0, 5000.0, 0.45};

const msm::EngineArray &array_named(const EngineParameters &parameters, const std::string &name) {
    const auto found = std::ranges::find(parameters.arrays, name, &msm::EngineArray::name);
    EXPECT_NE(found, parameters.arrays.end()) << parameters.engine << " has no " << name;
    return *found;
}

const std::vector<double> &numbers_of(const EngineParameters &parameters, const std::string &name) {
    return std::get<std::vector<double>>(array_named(parameters, name).values);
}

const std::vector<int> &nodes_of(const EngineParameters &parameters, const std::string &name) {
    return std::get<std::vector<int>>(array_named(parameters, name).values);
}

double setting_named(const EngineParameters &parameters, const std::string &name) {
    const auto found = std::ranges::find(parameters.settings, name, &msm::EngineSetting::name);
    EXPECT_NE(found, parameters.settings.end()) << parameters.engine << " has no " << name;
    return found->value;
}

/// Many substeps, so that what depends on them does not count.
const msm::EngineChoices finest_substeps{.substeps = 100000};

/// Energy that Jolt's constraints have where a body is strained evenly, over the elastic energy of the material.
double energy_of_jolt(const core::Body &body, const EngineParameters &jolt, const Eigen::Matrix3d &strain) {
    const Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity() + strain;
    const auto &points = body.mesh.points;
    const auto &edges = nodes_of(jolt, "edges"), &tetrahedra = nodes_of(jolt, "volume_tetrahedra");
    double energy = 0.0;
    for (std::size_t e = 0; e < edges.size() / 2; ++e) {
        const Vector3 span = gradient * (points[edges[2 * e + 1]] - points[edges[2 * e]]);
        const double constraint = span.norm() - numbers_of(jolt, "rest_length")[e];
        energy += 0.5 * constraint * constraint / numbers_of(jolt, "edge_compliance")[e];
    }
    for (std::size_t t = 0; t < tetrahedra.size() / 4; ++t) {
        std::array<Vector3, 4> x;
        for (std::size_t c = 0; c < 4; ++c)
            x[c] = gradient * points[tetrahedra[4 * t + c]];
        const double constraint =
            std::abs((x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0])) - numbers_of(jolt, "six_rest_volume")[t];
        energy += 0.5 * constraint * constraint / numbers_of(jolt, "volume_compliance")[t];
    }
    double volume = 0.0;
    for (const double part : core::tetrahedron_volumes(body.mesh))
        volume += part;
    const auto &material = body.materials.front();
    return energy / (volume * (material.shear_modulus() * strain.squaredNorm() +
                               0.5 * material.lame_lambda() * strain.trace() * strain.trace()));
}

/// Strains without change of volume: tension along the three axes, then shear.
std::array<Eigen::Matrix3d, 6> strains_of_one_volume() {
    constexpr double size = 1e-5;
    std::array<Eigen::Matrix3d, 6> strains;
    for (int a = 0; a < 3; ++a) {
        strains[a] = -0.5 * size * Eigen::Matrix3d::Identity();
        strains[a](a, a) = size;
        strains[3 + a].setZero();
        strains[3 + a](a, (a + 1) % 3) = strains[3 + a]((a + 1) % 3, a) = size;
    }
    return strains;
}

double mean_ratio_of(const EngineParameters &jolt, const core::Body &body) {
    auto stiffness = numbers_of(jolt, "edge_compliance");
    for (double &value : stiffness)
        value = 1.0 / value;
    return msm::mean_shear_modulus_ratio(stiffness, numbers_of(jolt, "rest_length"), body);
}

// Springs are no isotropic solid on any one mesh. Averaged over all strains without change of volume, of which there
// are two tensions and three shears, their modulus is the tissue's times mean_shear_modulus_ratio().
TEST(EngineParameters, JoltsConstraintsHaveTheBulkModulusAndTheMeanShearModulusThatTheySay) {
    const auto body = tests::make_body(meshes::generate_box({0.09, 0.06, 0.05}, 0.01), tissue_of_engines);
    const double mu = tissue_of_engines.shear_modulus(), lambda = tissue_of_engines.lame_lambda();
    const Eigen::Matrix3d swelling = 1e-5 * Eigen::Matrix3d::Identity();
    for (const std::string law : {"lloyd", "van_gelder"}) {
        auto choices = finest_substeps;
        choices.law = law;
        const auto jolt = msm::engine_parameters(*body, "jolt", choices);
        const double springs_sum = mean_ratio_of(jolt, *body);
        const auto strains = strains_of_one_volume();
        double mean = 0.0;
        for (std::size_t s = 0; s < strains.size(); ++s) {
            const double ratio = energy_of_jolt(*body, jolt, strains[s]);
            EXPECT_NEAR(ratio, springs_sum, 0.2) << law << ": 0.16 is observed\n" << strains[s];
            mean += ratio * (s < 3 ? 2.0 / 15.0 : 1.0 / 5.0);
        }
        EXPECT_NEAR(mean, springs_sum, 1e-4) << law;
        const double part_of_springs = 7.5 * mu / (3.0 * mu + 4.5 * lambda); // of the energy of swelling
        EXPECT_NEAR(energy_of_jolt(*body, jolt, swelling), 1.0 + (springs_sum - 1.0) * part_of_springs, 1e-4) << law;
        // Lloyd's formula takes edges for shorter than they are where tetrahedra are not regular.
        EXPECT_NEAR(springs_sum, law == "lloyd" ? 1.17 : 1.0, law == "lloyd" ? 0.03 : 1e-6);
    }
}

TEST(EngineParameters, SpringsOfARegularTetrahedronHaveTheMeanModulusOfTheirLaw) {
    const auto body = tests::make_body(tests::regular_tetrahedron(0.01), {1060.0, 5000.0, 0.25});
    const auto ratio = [&](const std::string &law) {
        auto choices = finest_substeps;
        choices.law = law;
        const auto jolt = msm::engine_parameters(*body, "jolt", choices);
        EXPECT_TRUE(nodes_of(jolt, "volume_tetrahedra").empty()) << "nothing is left of lambda at 1/4";
        return mean_ratio_of(jolt, *body);
    };
    EXPECT_NEAR(ratio("lloyd"), 0.96, 1e-6);
    EXPECT_NEAR(ratio("van_gelder"), 1.0, 1e-6);
}

TEST(EngineParameters, CompliancesOfJoltLeaveOutWhatSubstepsSoften) {
    const auto body = tests::make_body(tests::box_mesh({0.04, 0.03, 0.02}, {4, 3, 2}), tissue_of_engines);
    const auto with = [&](int substeps) { return msm::engine_parameters(*body, "jolt", {.substeps = substeps}); };
    const auto few = with(100), many = with(200);
    const auto &inverse_mass = numbers_of(few, "inverse_mass");
    for (std::size_t e = 0; e < numbers_of(few, "edge_compliance").size(); ++e) {
        const double w = inverse_mass[nodes_of(few, "edges")[2 * e]] + inverse_mass[nodes_of(few, "edges")[2 * e + 1]];
        const double h = 1.0 / 6000.0;
        const double difference = numbers_of(many, "edge_compliance")[e] - numbers_of(few, "edge_compliance")[e];
        EXPECT_NEAR(difference, 0.5 * w * h * h * 0.75, 1e-9 * difference);
    }
    for (const double compliance : numbers_of(with(1), "edge_compliance"))
        EXPECT_GE(compliance, 0.0);
}

TEST(EngineParameters, CoefficientsOfGodotAreThoseThatItsSourcesTurnIntoTheCompliance) {
    constexpr double point_mass = 2e-3, step = 1.0 / 300.0;
    for (const double stiffness : {0.3, 30.0, 3000.0}) {
        const double s = msm::godot_linear_stiffness(stiffness, point_mass, step);
        EXPECT_NEAR(1.0 / (step * step * (1.0 / s - 1.0) * 2.0 / point_mass), stiffness, 1e-9 * stiffness);
        for (const double largest : {1e5, 1e6}) {
            const double cube = msm::godot_linear_stiffness_by_cube(stiffness, largest);
            EXPECT_NEAR(std::max(std::pow(cube, 3) * largest, 1e-6), stiffness, 1e-9 * stiffness);
        }
    }
    EXPECT_EQ(msm::godot_linear_stiffness_by_cube(2e5, 1e5), 1.0);
}

TEST(EngineParameters, GodotGetsAClosedSurfaceWithTheMassOfTheBody) {
    const auto body = tests::make_body(tests::box_mesh({0.04, 0.03, 0.02}, {4, 3, 2}), tissue_of_engines);
    const auto godot = msm::engine_parameters(*body, "godot", {});
    const auto &points = numbers_of(godot, "points");
    const auto &corners = nodes_of(godot, "triangles");
    const auto point = [&](int i) { return Vector3(points[3 * i], points[3 * i + 1], points[3 * i + 2]); };
    double volume = 0.0;
    for (std::size_t f = 0; f < corners.size(); f += 3)
        volume += point(corners[f]).dot(point(corners[f + 1]).cross(point(corners[f + 2]))) / 6.0;
    EXPECT_NEAR(volume, -0.04 * 0.03 * 0.02, 1e-12) << "clockwise seen from outside";
    EXPECT_NEAR(setting_named(godot, "total_mass"), 1060.0 * 0.04 * 0.03 * 0.02, 1e-9);
    // Euler's formula of a sphere.
    EXPECT_EQ(points.size() / 3 + corners.size() / 3 - nodes_of(godot, "surface_edges").size() / 2, 2U);
}

/// Stress of the stable neo-Hookean law with a logarithm under a strain, over the strain, by its derivative.
Eigen::Matrix3d stress_of_stable(const msm::LameParameters &lame, const Eigen::Matrix3d &strain) {
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + strain;
    const double first = f.squaredNorm(), alpha = 1.0 + 0.75 * lame.mu / lame.lambda, j = f.determinant();
    const Eigen::Matrix3d cofactor = j * f.inverse().transpose();
    return lame.mu * (1.0 - 1.0 / (first + 1.0)) * f + lame.lambda * (j - alpha) * cofactor;
}

TEST(EngineParameters, StableNeoHookeanLawIsTheMaterialAtSmallStrains) {
    const auto lame = msm::stable_neo_hookean(tissue_of_engines);
    Eigen::Matrix3d strain;
    strain << 1.0, 0.3, -0.2, 0.3, -0.5, 0.4, -0.2, 0.4, 0.7;
    strain *= 1e-6;
    const Eigen::Matrix3d linear = 2.0 * tissue_of_engines.shear_modulus() * strain +
                                   tissue_of_engines.lame_lambda() * strain.trace() * Eigen::Matrix3d::Identity();
    EXPECT_LT((stress_of_stable(lame, strain) - linear).norm(), 1e-4 * linear.norm());
    const auto body = tests::make_body(tests::regular_tetrahedron(0.01), tissue_of_engines);
    const auto bullet = msm::engine_parameters(*body, "bullet", {});
    EXPECT_EQ(setting_named(bullet, "neo_hookean_mu"), lame.mu);
    EXPECT_EQ(setting_named(bullet, "mu"), tissue_of_engines.shear_modulus());
    EXPECT_EQ(setting_named(bullet, "lambda"), tissue_of_engines.lame_lambda());
}

TEST(EngineParameters, EveryEngineHasFiniteNumbersAndNodesThatAreThere) {
    const auto body = tests::make_body(tests::box_mesh({0.04, 0.03, 0.02}, {4, 3, 2}), tissue_of_engines);
    for (const auto &engine : msm::all_engines()) {
        const auto parameters = msm::engine_parameters(*body, engine.name, {});
        EXPECT_EQ(parameters.engine, engine.name);
        EXPECT_FALSE(parameters.notes.empty() || parameters.cannot.empty()) << engine.name;
        for (const auto &setting : parameters.settings) {
            EXPECT_TRUE(std::isfinite(setting.value)) << engine.name << ' ' << setting.name;
            EXPECT_FALSE(setting.meaning.empty()) << engine.name << ' ' << setting.name;
        }
        for (const auto &array : parameters.arrays) {
            EXPECT_GT(array.rows(), 0U) << engine.name << ' ' << array.name;
            if (const auto *numbers = std::get_if<std::vector<double>>(&array.values))
                EXPECT_TRUE(std::ranges::all_of(*numbers, [](double x) { return std::isfinite(x); })) << array.name;
            else
                for (const int node : std::get<std::vector<int>>(array.values))
                    EXPECT_TRUE(node >= 0 && node < body->mesh.num_nodes()) << array.name;
        }
    }
}

/// Springs that SOFA has beside its tetrahedra store what the capsule as springs and the fibres of vessels store.
TEST(EngineParameters, SofaGetsTheCapsuleAndTheVesselsAsSprings) {
    const auto bare = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {3, 3, 3}), tissue_of_engines);
    const auto body = tests::vessels::with_vessels(tests::covered::with_capsule(bare));
    const auto sofa = msm::engine_parameters(*body, "sofa", {});
    Eigen::Matrix3d f;
    f << 1.2, 0.1, 0.0, 0.0, 0.9, 0.2, 0.1, 0.0, 1.1;
    const auto energy = [&](const std::string &kind, const std::string &ends, const auto &point) {
        double sum = 0.0;
        for (std::size_t s = 0; s < numbers_of(sofa, kind + "stiffness").size(); ++s) {
            const Vector3 span = point(nodes_of(sofa, ends)[2 * s + 1]) - point(nodes_of(sofa, ends)[2 * s]);
            const double longer = (f * span).norm() - numbers_of(sofa, kind + "length")[s];
            sum += 0.5 * numbers_of(sofa, kind + "stiffness")[s] * longer * longer;
        }
        return sum;
    };
    double fibres = 0.0;
    for (const auto &point : core::vessel_points(*body))
        fibres += point.energy(f * point.direction);
    const auto &places = numbers_of(sofa, "vessel_points");
    EXPECT_NEAR(energy("vessel_", "vessel_springs",
                       [&](int p) { return Vector3(places[3 * p], places[3 * p + 1], places[3 * p + 2]); }),
                fibres, 1e-9 * fibres);
    const auto node = [&](int n) { return body->mesh.points[n]; };
    const auto edges_of = [&](const core::Body &other) {
        const auto parameters = msm::engine_parameters(other, "sofa", {});
        double sum = 0.0;
        for (std::size_t e = 0; e < numbers_of(parameters, "stiffness").size(); ++e) {
            const Vector3 span =
                node(nodes_of(parameters, "edges")[2 * e + 1]) - node(nodes_of(parameters, "edges")[2 * e]);
            const double longer = (f * span).norm() - numbers_of(parameters, "rest_length")[e];
            sum += 0.5 * numbers_of(parameters, "stiffness")[e] * longer * longer;
        }
        return sum;
    };
    const double capsule = edges_of(*body) - edges_of(*bare);
    EXPECT_GT(capsule, 0.0);
    EXPECT_NEAR(energy("capsule_", "capsule_edges", node), capsule, 1e-9 * capsule);
}

TEST(EngineParameters, EveryEngineHasACapsuleAndVesselsOrSaysThatItHasNot) {
    const auto bare = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {2, 2, 2}), tissue_of_engines);
    const auto body = tests::vessels::with_vessels(tests::covered::with_capsule(bare));
    const auto says = [](const EngineParameters &parameters, const std::string &words) {
        return std::ranges::count_if(parameters.cannot,
                                     [&](const auto &sentence) { return sentence.starts_with(words); });
    };
    for (const auto &engine : msm::all_engines()) {
        const auto with = msm::engine_parameters(*body, engine.name, {}),
                   without = msm::engine_parameters(*bare, engine.name, {});
        EXPECT_EQ(says(with, "the capsule is left out"), engine.has_capsule ? 0 : 1) << engine.name;
        EXPECT_EQ(says(with, "vessels as lines are left out"), engine.has_vessels ? 0 : 1) << engine.name;
        EXPECT_EQ(says(without, "the capsule") + says(without, "vessels"), 0) << engine.name;
        if (!engine.has_capsule || engine.name == "jolt") // whose arrays are compliances
            continue;
        const auto *const stiffness = engine.name == "godot" ? "surface_stiffness" : "stiffness";
        EXPECT_GT(numbers_of(with, stiffness)[0], numbers_of(without, stiffness)[0]);
    }
}

TEST(EngineParameters, StepsOfMuJoCoFillTheFrameAndItsModelHasAllPoints) {
    const auto body = tests::make_body(tests::box_mesh({0.04, 0.03, 0.02}, {4, 3, 2}), tissue_of_engines);
    const auto mujoco = msm::engine_parameters(*body, "mujoco", {});
    EXPECT_NEAR(setting_named(mujoco, "timestep") * setting_named(mujoco, "steps"), 1.0 / 60.0, 1e-12);
    EXPECT_EQ(setting_named(mujoco, "steps"), 9.0);
    EXPECT_EQ(setting_named(msm::engine_parameters(*body, "mujoco", {.substeps = 40}), "steps"), 40.0);
    ASSERT_TRUE(mujoco.text);
    EXPECT_EQ(mujoco.text->ending, ".xml");
    const auto &text = mujoco.text->text;
    const auto from = text.find("element=\"") + 9, to = text.find('"', from);
    EXPECT_EQ(std::count(text.begin() + static_cast<std::ptrdiff_t>(from),
                         text.begin() + static_cast<std::ptrdiff_t>(to), ' '),
              4 * body->mesh.num_tetrahedra() - 1);
}

/// The stress of a flex along x and across it, under a strain along x, was found in MuJoCo: 8000 and 4000 Pa for E = 5
/// kPa and nu = 1/4, where it should be 6000 and 2000 Pa.
TEST(EngineParameters, OfMuJoCoHaveHalfOfLambda) {
    const core::Material tissue{.density = 1060.0, .young_modulus = 5000.0, .poisson_ratio = 0.25};
    const auto typed = msm::mujoco_material(tissue);
    EXPECT_NEAR(typed.shear_modulus(), tissue.shear_modulus(), 1e-9);
    EXPECT_NEAR(2.0 * typed.lame_lambda(), tissue.lame_lambda(), 1e-9);
    EXPECT_NEAR(2.0 * tissue.shear_modulus() + 2.0 * tissue.lame_lambda(), 8000.0, 1e-9)
        << "as it is typed by its users";
    EXPECT_NEAR(2.0 * typed.shear_modulus() + 2.0 * typed.lame_lambda(), 6000.0, 1e-9);
    EXPECT_NEAR(msm::mujoco_material({.density = 1.0, .young_modulus = 1.0, .poisson_ratio = 0.45}).poisson_ratio,
                0.4091, 5e-5);
}

TEST(EngineParameters, WrongChoicesAreRefused) {
    const auto body = tests::make_body(tests::regular_tetrahedron(0.01), tissue_of_engines);
    const auto refuse = [&](const std::string &engine, const msm::EngineChoices &choices,
                            const std::vector<std::string> &parts) {
        tests::expect_input_error([&] { msm::engine_parameters(*body, engine, choices); }, parts);
    };
    refuse("unreal", {}, {"no engine 'unreal'", "bullet, godot, jolt, mujoco, newton, sofa"});
    refuse("jollt", {}, {"did you mean 'jolt'?"});
    refuse("jolt", {.law = "loyd"}, {"no spring law 'loyd'"});
    refuse("jolt", {.substeps = 0}, {"0 substeps", "1 to"});
    refuse("jolt", {.frame = -1.0}, {"a frame of -1 s"});
}

} // namespace
} // namespace livermark
