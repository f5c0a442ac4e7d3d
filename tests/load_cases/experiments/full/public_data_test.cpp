#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "load_cases/experiments/markers.hpp"
#include "load_cases/experiments/needle_curves.hpp"
#include "results/records/experiment.hpp"
#include "studies/experiments/experiments.hpp"
#include "studies/models/model_table.hpp"
#include "studies/needle/needle_study.hpp"
#include "tests/result_folder.hpp"

namespace livermark::experiments {
namespace {

/// An experiment whose data may not be there: its tests are skipped then, with a sentence.
struct WithPublicData : testing::Test {
    void read(const std::string &name) {
        const auto &entry = support::find_named(all_public_data(), name, "experiment");
        if (!public_data(entry.data))
            GTEST_SKIP() << where_to_get(entry);
        experiment_ = read_public(entry);
    }
    Experiment experiment_;
};

struct TruthCube : WithPublicData {
    void SetUp() override { read("truth_cube"); }
};

struct DragonSkinBeam : WithPublicData {
    void SetUp() override { read("dragon_skin_beam"); }
};

const results::ExperimentRun &run_of(const results::ExperimentResult &result, const std::string &model, int state,
                                     int tetrahedra) {
    return *std::ranges::find_if(result.runs, [&](const auto &run) {
        return run.model == model && run.state == state && (tetrahedra == 0 || run.tetrahedra == tetrahedra);
    });
}

struct EcoflexCylinder : WithPublicData {
    void SetUp() override { read("ecoflex_EF10_75T"); }
};

/// Between plates without friction the stress is uniform, so elements have the force of the closed form.
TEST_F(EcoflexCylinder, HasAUniformStressBetweenFreePlates) {
    ASSERT_EQ(experiment_.states.size(), 2u);
    experiment_.states.resize(1);
    EXPECT_NEAR(experiment_.states[0].force->force[0], 0.92, 0.01); // as the table of the owners says at 1.5 mm
    EXPECT_NEAR(experiment_.states[0].force->force[4], 23.7, 0.1);
    studies::ExperimentOptions options;
    options.models = {"fem_p1_neo_hookean", "nodal_neo_hookean_f"};
    options.refines_reference = false;
    const auto result = studies::evaluate_experiment(experiment_, options, "test", {});
    const auto &measured = result.forces.at(0);
    const auto uniform = results::errors_of_shape(measured, measured.uniform);
    for (const auto &run : measured.runs) {
        EXPECT_EQ(run.status, core::SolutionStatus::ok) << run.message;
        const auto errors = results::errors_of_shape(measured, run.force);
        for (std::size_t j = 0; j < errors.size(); ++j)
            EXPECT_NEAR(errors[j], uniform[j], 0.003) << run.model << ' ' << measured.way[j + 1];
    }
}

TEST_F(TruthCube, HasTheBeadsOfItsFile) {
    EXPECT_EQ(experiment_.markers.size(), 343u);
    EXPECT_EQ(std::ranges::count(experiment_.markers, "", &Marker::drives), 245);
    EXPECT_EQ(std::ranges::count(experiment_.markers, "z_max", &Marker::drives), 49);
    ASSERT_EQ(experiment_.states.size(), 3u);
    const std::array<double, 3> moved{4.34e-3, 10.16e-3, 15.02e-3}; // the layer on the plate, up
    for (std::size_t s = 0; s < moved.size(); ++s) {
        double mean = 0.0;
        for (std::size_t k = 0; k < 343; ++k)
            if (experiment_.markers[k].drives == "z_min")
                mean += experiment_.states[s].displacement[k].z() / 49.0;
        EXPECT_NEAR(mean, moved[s], 1e-5);
    }
}

/// An independent solution with quadratic neo-Hookean elements is 0.33, 0.37 and 0.42 mm off, a straight line 0.49,
/// 0.91 and 1.50 mm; the noise is 0.29 mm.
TEST_F(TruthCube, IsMetByTheReferenceUpToTheNoise) {
    studies::ExperimentOptions options;
    options.models = {"fem_p2p1_neo_hookean"};
    options.refines_reference = false;
    const auto result = studies::evaluate_experiment(experiment_, options, "test", {});
    const std::array<double, 3> independent{0.33e-3, 0.37e-3, 0.42e-3}, line{0.49e-3, 0.91e-3, 1.50e-3};
    for (int s = 0; s < 3; ++s) {
        const auto &run = run_of(result, "fem_p2p1_neo_hookean", s, 0);
        EXPECT_EQ(run.status, core::SolutionStatus::ok) << run.message;
        EXPECT_NEAR(run.error, independent[s], 0.05e-3) << s;
        EXPECT_NEAR(result.states[s].straight_line, line[s], 0.05e-3) << s;
    }
}

TEST_F(DragonSkinBeam, HasTheDisplacementsOfItsFiles) {
    ASSERT_EQ(experiment_.states.size(), 3u);
    const std::array<double, 3> sunk{6.7e-3, 17.6e-3, 27.2e-3}, differ{0.06e-3, 0.4e-3, 1.2e-3}; // of marker 0
    for (std::size_t s = 0; s < sunk.size(); ++s) {
        EXPECT_NEAR(experiment_.states[s].displacement[0].norm(), sunk[s], 0.1e-3);
        EXPECT_LT(experiment_.states[s].displacement[0].z(), -0.97 * sunk[s]);    // down, in the directions of the beam
        EXPECT_GT(experiment_.states[s].noise, 0.5 * differ[s] / std::sqrt(3.0)); // of three markers, in all directions
        EXPECT_LT(experiment_.states[s].noise, 1.5e-3);
    }
    EXPECT_NEAR(experiment_.markers[0].position.z(), 0.036, 0.002); // on a peg above the beam
}

/// A slender beam with shear sinks by 7.3, 17.3 and 26.2 mm at its tip.
TEST_F(DragonSkinBeam, SinksLikeASlenderBeam) {
    studies::ExperimentOptions options;
    options.models = {"fem_p2p1_neo_hookean"};
    options.refines_reference = false;
    options.rings_down = false;
    const auto result = studies::evaluate_experiment(experiment_, options, "test", {});
    const std::array<double, 3> slender{7.3e-3, 17.3e-3, 26.2e-3};
    for (int s = 0; s < 3; ++s) {
        const auto &run = run_of(result, "fem_p2p1_neo_hookean", s, 0);
        EXPECT_EQ(run.status, core::SolutionStatus::ok) << run.message;
        EXPECT_NEAR(run.displacement[0].z(), -slender[s], 0.1 * slender[s]) << s;
    }
}

/// Read off the files with another program: 7.7, 4.3 and 3.35 Hz, a damping ratio near 0.06.
TEST_F(DragonSkinBeam, RingsAsItsFilesSay) {
    ASSERT_EQ(experiment_.ring_downs.size(), 3u);
    EXPECT_EQ(experiment_.damping_from, "0.510 N");
    const std::array<double, 3> frequency{7.71, 4.32, 3.35};
    const std::array<int, 3> all{0, 1, 2};
    for (std::size_t n = 0; n < 3; ++n) {
        const auto ringing = measured_ringing(experiment_.ring_downs[n].repeats, all);
        EXPECT_NEAR(ringing.value.frequency, frequency[n], 0.015 * frequency[n]);
        EXPECT_NEAR(ringing.value.ratio, 0.06, 0.015);
        EXPECT_LT(ringing.frequency_uncertainty, 0.04 * frequency[n]);
        EXPECT_GT(ringing.frequency_uncertainty, 0.0);
    }
}

/// A body that is let go rings at about the measured frequency only with the mass of what hangs at it.
TEST_F(DragonSkinBeam, RingsWithTheMassOfItsWeight) {
    studies::ExperimentOptions options;
    const auto model = support::find_named(models::all_models(), std::string("van_gelder"), "model");
    std::vector<core::Vector3> positions;
    for (const auto &marker : experiment_.markers)
        positions.push_back(marker.position);
    const std::array<int, 3> all{0, 1, 2};
    auto ring_down = experiment_.ring_downs[1];
    const auto measured = studies::measured_ring_down(ring_down, positions, all);
    const auto damping = studies::fitted_damping(studies::DampingForces::mass, 0.05, measured.frequency,
                                                 measured.frequency, measured.frequency);
    const auto frequency = [&] {
        const auto runs =
            studies::ring_down_of_model(model, ring_down, measured, 0.012, damping, measured.frequency, positions, all);
        EXPECT_EQ(runs.size(), 1u);
        EXPECT_EQ(runs.front().status, core::SolutionStatus::ok) << runs.front().message;
        return runs.front().frequency;
    };
    EXPECT_NEAR(frequency(), measured.frequency, 0.15 * measured.frequency);
    ring_down.body = experiment_.ring_downs[0].body;
    EXPECT_GT(frequency(), 1.4 * measured.frequency);
}

/// A record of a needle that may not be there.
struct WithNeedleRecord : testing::Test {
    void read(const std::string &name) {
        const auto &record = support::find_named(all_needle_records(), name, "record of a needle");
        if (!is_there(record))
            GTEST_SKIP() << "the measured needle is not there; 'livermark needle --measured " << name
                         << "' says where to get it";
        curve_ = read_needle_curve(record);
    }
    results::MeasuredNeedle beside_linear_tetrahedra() const {
        studies::NeedleOptions options;
        options.bodies = {"liver_healthy"};
        options.load_case = "puncture";
        options.models = {"fem_p1"};
        options.reference_on_mesh = true;
        return studies::compare_with_measured(options, curve_, {});
    }
    NeedleCurve curve_;
};

struct MeasuredNeedles : WithNeedleRecord {
    void SetUp() override { read("depth_force"); }
};

struct HeldNeedles : WithNeedleRecord {
    void SetUp() override { read("time_force"); }
};

TEST_F(MeasuredNeedles, ArePuncturedWhereThePublishedOneIs) {
    EXPECT_EQ(curve_.depth.size(), 371U);
    const auto puncture = puncture_of(curve_);
    EXPECT_NEAR(puncture.depth, 0.0191, 1e-4);
    EXPECT_NEAR(puncture.force, 1.41, 0.01);
    const auto bins = binned(curve_, 0.002);
    for (std::size_t b = 0; b < bins.size(); ++b) {
        EXPECT_LE(bins[b].lowest, bins[b].mean);
        EXPECT_GE(bins[b].highest, bins[b].mean);
        EXPECT_GE(bins[b].from, b > 0 ? bins[b - 1].to - 1e-12 : 0.0);
    }
}

/// Fitted to the depth and the force of the puncture, and to the work behind it. What is not fitted is the force right
/// behind the puncture, which is that of tearing.
TEST_F(MeasuredNeedles, AreMetWhereTheyAreFittedAndBehindThePuncture) {
    const auto measured = beside_linear_tetrahedra();
    ASSERT_EQ(measured.runs.size(), 2U);
    EXPECT_TRUE(measured.changed.empty());
    for (const auto &run : measured.runs) {
        EXPECT_NEAR(run.insertion.puncture_depth, measured.puncture_depth, 2.0 * measured.needle.step) << run.model;
        EXPECT_TRUE(run.has_friction && run.friction > 0.0);
        EXPECT_GT(run.stiffness, 0.0);
        EXPECT_LT(run.error, 0.5 * *std::ranges::max_element(measured.mean));
        const auto behind =
            std::ranges::find_if(measured.from, [&](double from) { return from > measured.puncture_depth; }) -
            measured.from.begin();
        EXPECT_GT(run.force[behind], measured.needle.tip_force());
        EXPECT_LT(run.force[behind], 2.5 * measured.highest[behind]);
    }
    EXPECT_GT(measured.runs[1].stiffness / measured.runs[0].stiffness, 0.1);
    EXPECT_LT(measured.runs[1].stiffness, measured.runs[0].stiffness) << "linear tetrahedra are too stiff already";
}

/// The numbers were found with another program, from the two tables.
TEST_F(HeldNeedles, HaveThePhasesOfTheirTables) {
    EXPECT_EQ(curve_.depth.size(), 332U);
    EXPECT_NEAR(*std::ranges::max_element(curve_.depth), 5.655e-3, 1e-6);
    const auto phases = phases_of(curve_);
    EXPECT_NEAR(phases.puncture.depth, 3.699e-3, 1e-6);
    EXPECT_NEAR(phases.puncture.force, 0.1787, 1e-4);
    EXPECT_NEAR(phases.touched_at, 2.512e-3, 1e-6);
    EXPECT_NEAR(phases.lowest, 0.0480, 1e-4);
    EXPECT_NEAR(phases.slope, 242.6, 0.2);
    EXPECT_NEAR(phases.pull, 0.1474, 1e-4);
    EXPECT_NEAR(curve_.held.seconds, 7.894, 1e-3);
    EXPECT_NEAR(curve_.held.first_force, 0.346, 1e-3);
    EXPECT_NEAR(curve_.held.last_force, 0.254, 1e-3);
}

/// The way is short and the surface weak, so that numbers of the load case do not fit.
TEST_F(HeldNeedles, AreMetWithANarrowerForceAndLessToughness) {
    const auto measured = beside_linear_tetrahedra();
    EXPECT_EQ(measured.changed.size(), 2U);
    EXPECT_LE(measured.needle.spread, 0.5 * measured.needle.depth());
    EXPECT_NEAR(measured.needle.tip_force(), measured.needle.puncture_force, 1e-9);
    ASSERT_EQ(measured.runs.size(), 2U);
    for (const auto &run : measured.runs) {
        EXPECT_NEAR(run.insertion.puncture_depth, measured.puncture_depth, 2.0 * measured.needle.step) << run.model;
        EXPECT_GT(run.stiffness, 0.0);
        EXPECT_GT(run.pull, 0.0);
        for (const double force : run.force)
            EXPECT_TRUE(std::isfinite(force)) << run.model;
    }
}

struct NeedleOfAModel : tests::ResultFolder {};

/// A model meets the curve that it made with its own stiffness and its own friction.
TEST_F(NeedleOfAModel, IsMetWithTheNumbersOfTheModel) {
    studies::NeedleOptions options;
    options.bodies = {"beam"};
    options.load_case = written("beam.toml", R"(title = "Beam"
[[condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
[[needle]]
name = "from above"
entry = "z_max"
depth = 0.028
diameter = 0.00127
spread = 0.008
toughness = 60.0
friction = 15.0
puncture_force = 0.5
)")
                            .string();
    options.models = {"fem_p1"};
    options.reference_on_mesh = true;
    options.output = (directory_ / "out").string();
    const auto driven = studies::drive_needles(options, "test", {});
    const auto &insertion = driven.records.front().needles.front().runs.front().insertion;
    NeedleCurve curve{.name = "model",
                      .source = "a model",
                      .unknown = {},
                      .diameter = 0.00127,
                      .stretch = 0.002,
                      .depth = {},
                      .force = {}};
    for (int j = 0; j <= insertion.at_plan && insertion.depth[j] < 0.025; ++j) {
        curve.depth.push_back(insertion.depth[j]);
        curve.force.push_back(insertion.force[j]);
    }
    const auto measured = studies::compare_with_measured(options, curve, {});
    const auto &run = measured.runs.front();
    EXPECT_NEAR(run.stiffness, 1.0, 0.02);
    EXPECT_NEAR(run.friction, 15.0, 0.1 * 15.0);
    EXPECT_LT(run.error, 0.03);
    EXPECT_LT(run.error_before, 0.03);
    EXPECT_TRUE(measured.changed.empty());
}

/// The block behind its name in docs/howto/bring_your_own_experiment.md.
std::string block_of_page(const std::string &name, const std::string &language) {
    const auto page = support::read_text(LIVERMARK_SOURCE_DIR "/docs/howto/bring_your_own_experiment.md");
    const auto fence = "```" + language + "\n";
    const auto first = page.find(fence, page.find("`" + name + "`:")) + fence.size();
    return page.substr(first, page.find("```", first) - first);
}

using PageOfExperiments = tests::ResultFolder;

/// A slender neo-Hookean column under its own weight: at each height rho g (h - z) = E (1 / s^2 - s) / 3 for the
/// stretch s. A base that cannot widen takes a little from what it sinks.
double sink_of_column(double weight_per_volume, double height, double young_modulus) {
    constexpr int num_slices = 1000;
    double sink = 0.0;
    for (int slice = 0; slice < num_slices; ++slice) {
        const double load = weight_per_volume * height * (slice + 0.5) / num_slices;
        double low = 0.1, high = 1.0;
        for (int step = 0; step < 60; ++step) {
            const double s = 0.5 * (low + high);
            (young_modulus * (1.0 / (s * s) - s) / 3.0 > load ? low : high) = s;
        }
        sink += (1.0 - low) * height / num_slices;
    }
    return sink;
}

TEST_F(PageOfExperiments, HasAnExampleThatRuns) {
    for (const auto &[name, language] : {std::pair{"cylinder.toml", "toml"}, {"cylinder.csv", "csv"}})
        std::ofstream(directory_ / name) << block_of_page(name, language);
    studies::ExperimentOptions options;
    options.names = {(directory_ / "cylinder.toml").string()};
    options.models = {"nodal_neo_hookean_f"};
    options.output = (directory_ / "out").string();
    const auto found = studies::run_experiments(options, "test", {});
    ASSERT_EQ(found.records.size(), 1u);
    const auto &result = found.records.front();
    ASSERT_EQ(result.runs.size(), 3u);
    const double column = sink_of_column(1000.0 * 9.81, 0.08, 5000.0);
    for (const auto &run : result.runs) {
        EXPECT_EQ(run.status, core::SolutionStatus::ok) << run.message;
        const double sunk = -run.displacement.back().z(); // in the middle of the top
        EXPECT_LT(sunk, column) << run.model;
        EXPECT_GT(sunk, 0.9 * column) << run.model;
    }
    EXPECT_LT(result.states.front().reference_uncertainty, 0.1e-3);
    EXPECT_EQ(results::read_experiment(found.files.front()).runs, result.runs);
}

} // namespace
} // namespace livermark::experiments
