#include "results/hdf5/result_file.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <sys/resource.h>

#include "core/support/input_error.hpp"
#include "results/problem_key.hpp"
#include "tests/result_folder.hpp"
#include "tests/same_bits.hpp"
#include "tests/samples/records/sample_result.hpp"

namespace livermark::results {
namespace {

using tests::same_bits;

namespace fs = std::filesystem;

using ResultFile = tests::ResultFolder;

std::string content(const fs::path &path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void expect_equal(const core::TetraMesh &a, const core::TetraMesh &b) {
    EXPECT_TRUE(same_bits(a.points, b.points));
    EXPECT_EQ(a.tetrahedra, b.tetrahedra);
    EXPECT_EQ(a.region, b.region);
    EXPECT_EQ(a.region_names, b.region_names);
    EXPECT_EQ(a.boundary_triangles, b.boundary_triangles);
    EXPECT_EQ(a.boundary_patch, b.boundary_patch);
    EXPECT_EQ(a.patch_names, b.patch_names);
}

void expect_equal(const core::Release &a, const core::Release &b) {
    EXPECT_EQ(a.num_steps, b.num_steps);
    EXPECT_EQ(a.output_interval, b.output_interval);
    EXPECT_EQ(a.damping.alpha, b.damping.alpha);
    EXPECT_EQ(a.damping.beta, b.damping.beta);
    ASSERT_EQ(a.probes.size(), b.probes.size());
    for (std::size_t q = 0; q < a.probes.size(); ++q) {
        EXPECT_EQ(a.probes[q].name, b.probes[q].name);
        EXPECT_EQ(a.probes[q].node, b.probes[q].node);
    }
}

void expect_equal(const core::History &a, const core::History &b) {
    EXPECT_TRUE(same_bits(a.time, b.time));
    EXPECT_TRUE(same_bits(a.displacement, b.displacement));
    EXPECT_TRUE(same_bits(a.kinetic_energy, b.kinetic_energy));
    EXPECT_TRUE(same_bits(a.strain_energy, b.strain_energy));
    EXPECT_TRUE(same_bits(a.frames, b.frames));
    EXPECT_EQ(a.observed_error, b.observed_error);
    EXPECT_EQ(a.integrator, b.integrator);
    EXPECT_EQ(a.kernel, b.kernel);
    EXPECT_EQ(a.forces_per_step, b.forces_per_step);
    EXPECT_EQ(a.time_step, b.time_step);
    EXPECT_EQ(a.setup_seconds, b.setup_seconds);
    EXPECT_EQ(a.solve_seconds, b.solve_seconds);
}

void expect_equal(const core::LoadCase &a, const core::LoadCase &b) {
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.title, b.title);
    EXPECT_EQ(a.definition, b.definition);
    EXPECT_EQ(a.target_peak_displacement, b.target_peak_displacement);
    EXPECT_EQ(a.load_scale, b.load_scale);
    EXPECT_EQ(a.regime, b.regime);
    EXPECT_EQ(a.path, b.path);
    EXPECT_EQ(a.slow_history, b.slow_history);
    EXPECT_EQ(a.node_factor, b.node_factor);
    EXPECT_EQ(a.node_shift, b.node_shift);
    ASSERT_EQ(a.yielded.size(), b.yielded.size());
    for (std::size_t y = 0; y < a.yielded.size(); ++y) {
        EXPECT_EQ(a.yielded[y].name, b.yielded[y].name);
        EXPECT_EQ(a.yielded[y].lost_area, b.yielded[y].lost_area);
    }
    EXPECT_EQ(a.conditions, b.conditions);
    EXPECT_EQ(a.condition_on, b.condition_on);
    EXPECT_TRUE(same_bits(a.value, b.value));
    EXPECT_EQ(a.acceleration, b.acceleration);
    EXPECT_EQ(a.press_depth, b.press_depth);
    EXPECT_EQ(a.touching, b.touching);
    ASSERT_EQ(a.release.has_value(), b.release.has_value());
    if (a.release)
        expect_equal(*a.release, *b.release);
}

void expect_equal(const core::Solution &a, const core::Solution &b) {
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.message, b.message);
    EXPECT_EQ(a.solver, b.solver);
    EXPECT_TRUE(same_bits(a.displacement, b.displacement));
    EXPECT_TRUE(same_bits(a.reaction, b.reaction));
    EXPECT_TRUE(same_bits(a.strain_energy, b.strain_energy));
    EXPECT_TRUE(same_bits(a.nonlinearity, b.nonlinearity));
    ASSERT_EQ(a.explicit_steps.has_value(), b.explicit_steps.has_value());
    if (a.explicit_steps) {
        EXPECT_TRUE(same_bits(a.explicit_steps->critical_time_step, b.explicit_steps->critical_time_step));
        EXPECT_TRUE(same_bits(a.explicit_steps->seconds_per_step, b.explicit_steps->seconds_per_step));
        EXPECT_EQ(a.explicit_steps->kernel, b.explicit_steps->kernel);
    }
    EXPECT_EQ(a.degrees_of_freedom, b.degrees_of_freedom);
    EXPECT_EQ(a.setup_seconds, b.setup_seconds);
    EXPECT_EQ(a.solve_seconds, b.solve_seconds);
    EXPECT_EQ(a.observed_error, b.observed_error);
    ASSERT_EQ(a.path.size(), b.path.size());
    for (std::size_t k = 0; k < a.path.size(); ++k) {
        EXPECT_TRUE(same_bits(a.path[k].displacement, b.path[k].displacement));
        EXPECT_TRUE(same_bits(a.path[k].reaction, b.path[k].reaction));
        EXPECT_EQ(a.path[k].strain_energy, b.path[k].strain_energy);
        EXPECT_TRUE(same_bits(a.path[k].work, b.path[k].work));
        EXPECT_TRUE(same_bits(a.path[k].dissipated_energy, b.path[k].dissipated_energy));
    }
    ASSERT_EQ(a.history.has_value(), b.history.has_value());
    if (a.history)
        expect_equal(*a.history, *b.history);
    ASSERT_EQ(a.springs.has_value(), b.springs.has_value());
    if (!a.springs)
        return;
    EXPECT_TRUE(same_bits(a.springs->node_mass, b.springs->node_mass));
    EXPECT_EQ(a.springs->edges, b.springs->edges);
    EXPECT_TRUE(same_bits(a.springs->stiffness, b.springs->stiffness));
    EXPECT_TRUE(same_bits(a.springs->rest_length, b.springs->rest_length));
}

void expect_equal(const core::Comparison &a, const core::Comparison &b) {
    EXPECT_EQ(a.reference, b.reference);
    EXPECT_TRUE(same_bits(a.relative_l2, b.relative_l2));
    EXPECT_TRUE(same_bits(a.max_error, b.max_error));
    EXPECT_TRUE(same_bits(a.max_error_relative, b.max_error_relative));
    EXPECT_TRUE(same_bits(a.energy_error, b.energy_error));
    EXPECT_TRUE(same_bits(a.reaction_error, b.reaction_error));
    EXPECT_EQ(a.history, b.history);
    ASSERT_EQ(a.path.has_value(), b.path.has_value());
    if (a.path) {
        EXPECT_TRUE(same_bits(a.path->percentile_95, b.path->percentile_95));
        EXPECT_TRUE(same_bits(a.path->worst_relative_l2, b.path->worst_relative_l2));
        EXPECT_TRUE(same_bits(a.path->worst_reaction_error, b.path->worst_reaction_error));
        EXPECT_TRUE(same_bits(a.path->reaction_bias, b.path->reaction_bias));
        EXPECT_TRUE(same_bits(a.path->volume_error, b.path->volume_error));
        EXPECT_TRUE(same_bits(a.path->centroid_error, b.path->centroid_error));
    }
    EXPECT_EQ(a.slow, b.slow);
    EXPECT_EQ(a.load_fraction, b.load_fraction);
    ASSERT_EQ(a.tool.has_value(), b.tool.has_value());
    if (a.tool) {
        ASSERT_EQ(a.tool->places.size(), b.tool->places.size());
        for (std::size_t g = 0; g < a.tool->places.size(); ++g) {
            EXPECT_EQ(a.tool->places[g].name, b.tool->places[g].name);
            EXPECT_TRUE(same_bits(a.tool->places[g].stiffness, b.tool->places[g].stiffness));
            EXPECT_TRUE(same_bits(a.tool->places[g].relative_l2, b.tool->places[g].relative_l2));
            EXPECT_TRUE(same_bits(a.tool->places[g].path, b.tool->places[g].path));
        }
    }
    EXPECT_TRUE(same_bits(a.error, b.error));
}

void expect_equal(const Result &a, const Result &b) {
    EXPECT_EQ(a.provenance, b.provenance);
    EXPECT_EQ(a.problem.body->name, b.problem.body->name);
    expect_equal(a.problem.body->mesh, b.problem.body->mesh);
    EXPECT_TRUE(same_bits(a.problem.body->materials, b.problem.body->materials));
    EXPECT_EQ(a.problem.body->assumptions, b.problem.body->assumptions);
    EXPECT_EQ(a.problem.body->patch_confidence, b.problem.body->patch_confidence);
    EXPECT_EQ(a.problem.body->axes.from_lps, b.problem.body->axes.from_lps);
    expect_equal(a.problem.load_case, b.problem.load_case);
    EXPECT_EQ(problem_key(a.problem), problem_key(b.problem));
    EXPECT_EQ(a.reference_uncertainty, b.reference_uncertainty);
    EXPECT_EQ(a.motion_uncertainty, b.motion_uncertainty);
    ASSERT_EQ(a.models.size(), b.models.size());
    for (std::size_t m = 0; m < a.models.size(); ++m) {
        SCOPED_TRACE(a.models[m].name);
        EXPECT_EQ(a.models[m].name, b.models[m].name);
        EXPECT_EQ(a.models[m].summary, b.models[m].summary);
        EXPECT_EQ(a.models[m].source, b.models[m].source);
        expect_equal(a.models[m].solution, b.models[m].solution);
        ASSERT_EQ(a.models[m].comparison.has_value(), b.models[m].comparison.has_value());
        if (a.models[m].comparison)
            expect_equal(*a.models[m].comparison, *b.models[m].comparison);
    }
    ASSERT_EQ(a.modes.size(), b.modes.size());
    for (std::size_t m = 0; m < a.modes.size(); ++m) {
        EXPECT_EQ(a.modes[m].name, b.modes[m].name);
        EXPECT_EQ(a.modes[m].modes.angular_frequency, b.modes[m].modes.angular_frequency);
        EXPECT_TRUE(same_bits(a.modes[m].modes.shape, b.modes[m].modes.shape));
        EXPECT_EQ(a.modes[m].modes.degrees_of_freedom, b.modes[m].modes.degrees_of_freedom);
        EXPECT_EQ(a.modes[m].modes.seconds, b.modes[m].modes.seconds);
    }
}

TEST_F(ResultFile, GivesBackWhatWasWritten) {
    const Result written = tests::sample_result();
    write_result(path_, written);
    expect_equal(read_result(path_), written);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, GivesBackASolutionAlone) {
    const Result sample = tests::sample_result();
    for (const auto &model : sample.models) {
        write_solution(path_, model.solution, sample.problem.load_case);
        expect_equal(read_solution(path_, sample.problem), model.solution);
    }
    EXPECT_THROW(read_result(path_), support::InputError); // it is no result file
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, GivesBackWhatWasWrittenInChunks) {
    const Result written = tests::sample_result(1000);
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, GivesBackSpringsThatModelsShare) {
    Result written = tests::sample_result();
    written.models.push_back(tests::stiffer(written.models[1]));
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, KeepsTextsOfAnyLength) {
    Result written = tests::sample_result();
    written.problem.load_case.definition.assign(300'000, 'x'); // an attribute of old formats ends at 64 KiB
    written.models[1].summary = "";
    written.models[1].source = "Müller, \u00b5m";
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, KeepsNonFiniteDisplacementsOfADivergedSolution) {
    write_result(path_, tests::sample_result());
    const ModelResult model = read_result(path_).models[2];
    EXPECT_EQ(model.solution.status, core::SolutionStatus::diverged);
    EXPECT_TRUE(std::isnan(model.solution.displacement.front().x()));
    EXPECT_EQ(model.solution.displacement.front().y(), std::numeric_limits<double>::infinity());
    EXPECT_TRUE(std::isnan(model.comparison->relative_l2));
}

TEST_F(ResultFile, HoldsAProblemWithoutConstraintsAndModels) {
    Result written = tests::sample_result();
    written.models.clear();
    written.reference_uncertainty.reset();
    written.motion_uncertainty.reset();
    written.problem.load_case.touching.reset();
    written.problem.load_case.conditions.clear();
    std::ranges::fill(written.problem.load_case.condition_on, -1);
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, HoldsAStaticLoadCase) {
    const Result written = tests::without_motion(tests::sample_result());
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, HoldsPlatesThatTouch) {
    auto written = tests::sample_result();
    auto &touching = written.problem.load_case.touching.value();
    for (const auto face : {core::ToolFace::round, core::ToolFace::square}) {
        touching.shape = {face, 0.3, 0.03, touching.press};
        write_result(path_, written);
        expect_equal(read_result(path_), written);
    }
}

TEST_F(ResultFile, HoldsWhatPressesToADepth) {
    auto written = tests::without_motion(tests::sample_result());
    auto &load_case = written.problem.load_case;
    load_case.press_depth = -0.003;
    load_case.conditions[1].kind = core::ConditionKind::press;
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, HoldsAComparisonOfAPartOfTheLoad) {
    auto written = tests::along_a_path(tests::sample_result());
    written.models[1].comparison->load_fraction = 0.8;
    write_result(path_, written);
    const auto read = read_result(path_);
    expect_equal(read, written);
    EXPECT_EQ(read.models[1].comparison->load_fraction, 0.8);
}

/// A reference that was kept has the probes and no frames; there is no error in frames then.
TEST_F(ResultFile, HoldsAMotionWithoutFrames) {
    Result written = tests::sample_result();
    written.models[0].solution.history->frames.clear();
    written.models[1].comparison->history->error.clear();
    written.models[1].comparison->history->frames_reference.clear();
    write_result(path_, written);
    expect_equal(read_result(path_), written);
}

TEST_F(ResultFile, ReplacesAnEarlierFile) {
    Result result = tests::sample_result();
    write_result(path_, result);
    result.provenance.command = "another command";
    write_result(path_, result);
    EXPECT_EQ(read_result(path_).provenance.command, "another command");
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, RefusesADirectoryThatIsMissing) {
    EXPECT_THROW(write_result(directory_ / "nowhere" / "result.h5", tests::sample_result()), support::InputError);
    EXPECT_TRUE(files().empty());
}

TEST_F(ResultFile, LeavesNothingBehindWhenTheNameIsTaken) {
    fs::create_directories(path_ / "a directory");
    EXPECT_THROW(write_result(path_, tests::sample_result()), support::InputError);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
    EXPECT_TRUE(fs::is_directory(path_));
}

TEST_F(ResultFile, LeavesTheEarlierFileWhenTheDiskIsFull) {
    const Result result = tests::sample_result();
    write_result(path_, result);
    const std::string before = content(path_);

    // A limit on the size of files fails in the middle of the writing, like a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small{before.size() / 2, limit.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_THROW(write_result(path_, result), support::InputError);
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);

    EXPECT_EQ(content(path_), before);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

TEST_F(ResultFile, LeavesTheEarlierFileWhenTheResultIsInconsistent) {
    Result result = tests::sample_result();
    write_result(path_, result);
    const std::string before = content(path_);
    const auto spoiled = [&](const std::function<void(Result &)> &spoil) {
        Result copy = result;
        spoil(copy);
        EXPECT_THROW(write_result(path_, copy), std::invalid_argument);
    };
    spoiled([](Result &r) { r.models[1].name = "fem_p2"; });
    spoiled([](Result &r) { r.models[1].name = "fem/p2"; });
    spoiled([](Result &r) { r.models[1].name = "fem.p2"; });
    spoiled([](Result &r) { r.models[1].name = ""; });
    spoiled([](Result &r) { r.models[1].comparison->reference = "nobody"; });
    spoiled([](Result &r) { r.reference_uncertainty->reference = "nobody"; });
    spoiled([](Result &r) { r.motion_uncertainty->refined = "nobody"; });
    spoiled([](Result &r) { r.models[1].solution.displacement.pop_back(); });
    spoiled([](Result &r) { r.models[1].solution.reaction.clear(); });
    spoiled([](Result &r) { r.models[1].solution.springs->stiffness.pop_back(); });
    spoiled([](Result &r) { r.models[1].comparison->error.pop_back(); });
    spoiled([](Result &r) { r.problem.load_case.value.pop_back(); });
    spoiled([](Result &r) { r.problem.load_case.release.reset(); });
    spoiled([](Result &r) { r.problem.load_case.release->num_steps = 3; });
    spoiled([](Result &r) { r.models[1].solution.history->displacement.pop_back(); });
    spoiled([](Result &r) { r.models[1].solution.history->strain_energy.pop_back(); });
    spoiled([](Result &r) { r.models[1].solution.history->frames.pop_back(); });
    spoiled([](Result &r) { r.models[1].comparison->history->error.pop_back(); });
    spoiled([](Result &r) { r.modes[0].modes.shape.pop_back(); });
    spoiled([](Result &r) { r.modes[0].name = "fem/p2"; });
    spoiled([](Result &r) { r.modes.push_back(r.modes[0]); });
    EXPECT_EQ(content(path_), before);
    EXPECT_EQ(files(), std::vector<std::string>{"result.h5"});
}

} // namespace
} // namespace livermark::results
