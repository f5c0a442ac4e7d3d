// Files of all kinds of records but results: they come back as they were written, and what they do not allow is
// refused.
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>
#include <hdf5.h>

#include "core/support/files.hpp"
#include "results/hdf5/hdf5_io.hpp"
#include "results/hdf5/references.hpp"
#include "results/hdf5/result_file.hpp"
#include "studies/models/model_table.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"
#include "tests/results/file_content.hpp"
#include "tests/samples/records/sample_records.hpp"
#include "tests/samples/test_meshes.hpp"
#include "tests/samples/tool_block.hpp"

namespace livermark::results {
namespace {

using RecordFile = tests::ResultFolder;
using Path = std::filesystem::path;

const auto springs_body = tests::make_body(tests::box_mesh({0.2, 0.1, 0.1}, {2, 1, 1}), {1060.0, 5e3, 0.45});

/// A kind of record: a sample, how it is written and read, and what may be wrong with one.
template <class Record> struct Kind {
    Record sample;
    void (*write)(const Path &, const Record &);
    Record (*read)(const Path &);
    FileKind kind;
};

const auto kinds = std::tuple(
    Kind<Arena>{tests::sample_arena(), write_arena, read_arena, FileKind::arena},
    Kind<Calibration>{tests::sample_calibration(*springs_body), write_calibration, read_calibration,
                      FileKind::calibration},
    Kind<Cohort>{tests::sample_cohort(), write_cohort, read_cohort, FileKind::cohort},
    Kind<CutFile>{tests::sample_cut(), write_cut, read_cut_file, FileKind::other},
    Kind<ExperimentResult>{tests::sample_experiment(), write_experiment, read_experiment, FileKind::experiment},
    Kind<NeedleFile>{tests::sample_needles(), write_needles, read_needles_file, FileKind::needle},
    Kind<Stability>{tests::sample_stability(), write_stability, read_stability, FileKind::stability},
    Kind<Timings>{tests::sample_timings(), write_timings, read_timings, FileKind::timings});

template <class Record> const Kind<Record> &kind_of() {
    return std::get<Kind<Record>>(kinds);
}

/// Goes over every kind of record.
void for_each_kind(const auto &check) {
    std::apply([&](const auto &...kind) { (check(kind), ...); }, kinds);
}

TEST_F(RecordFile, ComesBackAsItWasWritten) {
    for_each_kind([&](auto kind) {
        SCOPED_TRACE(testing::Message() << "kind " << static_cast<int>(kind.kind));
        kind.sample.provenance = current_provenance("livermark --some --options");
        kind.write(path_, kind.sample);
        EXPECT_EQ(kind_of_file(path_), kind.kind);
        const auto read = kind.read(path_);
        EXPECT_EQ(read.provenance, kind.sample.provenance);
        kind.write(directory_ / "again.h5", read);
        tests::expect_same_content(directory_ / "again.h5", path_);
    });
}

/// All that is not always there is left out, as in files of older versions.
TEST_F(RecordFile, ComesBackWithoutWhatIsOptional) {
    const auto expect_back = [&]<class Record>(const Record &record) {
        const auto &kind = kind_of<Record>();
        kind.write(path_, record);
        kind.write(directory_ / "again.h5", kind.read(path_));
        tests::expect_same_content(directory_ / "again.h5", path_);
    };
    auto arena = tests::sample_arena();
    arena.series.clear();
    arena.methods.clear();
    expect_back(arena);
    auto cohort = tests::sample_cohort();
    cohort.errors.clear();
    for (auto &body : cohort.bodies)
        body.lesions.clear();
    expect_back(cohort);
    auto cut = tests::sample_cut();
    cut.motions.clear();
    cut.levels.clear();
    expect_back(cut);
    auto experiment = tests::sample_experiment();
    experiment.ring_downs.clear();
    expect_back(experiment);
    EXPECT_FALSE(hdf5::InputFile(path_).has("/experiment/ring_downs"));
    EXPECT_TRUE(is_shown_on_page(path_));
    auto needles = tests::sample_needles();
    needles.needles.front().arena.reset(); // of `livermark needle`
    expect_back(needles);
    EXPECT_FALSE(read_needles_file(path_).needles.front().arena.has_value());
}

TEST_F(RecordFile, IsRefusedWhereItIsNoneOrDamagedOrOfAnotherKind) {
    for_each_kind([&](const auto &kind) {
        SCOPED_TRACE(testing::Message() << "kind " << static_cast<int>(kind.kind));
        const auto read = [&] { kind.read(path_); };
        std::filesystem::remove(path_);
        tests::expect_input_error(read, {path_.string(), "there is no such file", "make it with `"});
        kind.write(path_, kind.sample);
        std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
        tests::expect_input_error(read, {path_.string(), "truncated or damaged"});
        hdf5::OutputFile file;
        file.group("/experiment");
        support::write_whole(path_, file.image());
        tests::expect_input_error(read, {path_.string(), "schema_version"});
    });
    write_stability(path_, {});
    tests::expect_input_error([&] { read_calibration(path_); },
                              {"holds no calibration; make the file again with `python3 -m livermark.calibration`"});
    EXPECT_THROW(write_timings(directory_ / "no such folder" / "timings.h5", tests::sample_timings()),
                 support::InputError);
}

TEST_F(RecordFile, IsRefusedWhereItContradictsItself) {
    int num_refused = 0;
    const auto expect_refused = [&]<class Record>(Record record, const auto &spoil, const std::string &place) {
        SCOPED_TRACE(place);
        spoil(record);
        kind_of<Record>().write(path_, record);
        tests::expect_input_error([&] { kind_of<Record>().read(path_); }, {path_.string(), place});
        ++num_refused;
    };
    const auto arena = tests::sample_arena();
    // As if of another number of records.
    expect_refused(
        arena, [](auto &a) { a.runs[1].force.resize(a.runs[1].force.size() - 4); }, "/arena/force");
    const auto calibration = tests::sample_calibration(*springs_body);
    expect_refused(
        calibration, [](auto &c) { c.springs.stiffness[3] = 0.0; }, "/springs/stiffness row 3 is 0");
    const auto cut = tests::sample_cut();
    expect_refused(
        cut, [](auto &c) { c.runs[1].work.pop_back(); }, "/cut/models/springs/work");
    expect_refused(
        cut, [](auto &c) { c.area.pop_back(); }, "/cut/area");
    const auto experiment = tests::sample_experiment();
    expect_refused(
        experiment, [](auto &e) { e.ring_downs.front().displacement.resize(40); },
        "/experiment/ring_downs/0/runs/displacement");
    expect_refused(
        experiment, [](auto &e) { e.runs.back().state = 2; }, "/experiment/runs/state");
    const auto needles = tests::sample_needles();
    expect_refused(
        needles, [](auto &n) { n.needles[0].runs[1].insertion.at_plan = 1; }, "has models with different");
    expect_refused(
        needles, [](auto &n) { n.needles[0].runs[0].insertion.force.pop_back(); }, "/models/judge/force");
    expect_refused(
        needles, [](auto &n) { n.needles[0].arena->at_plan = 5; }, "/needles/0/arena");
    EXPECT_EQ(num_refused, 9);
}

/// Files of before what holding loses was written.
TEST_F(RecordFile, OfNeedlesOfOlderVersionsIsRead) {
    write_needles(path_, tests::sample_needles());
    const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    for (const char *model : {"judge", "springs"})
        EXPECT_GE(H5Ldelete(file, fmt::format("/needles/0/models/{}/holding", model).c_str(), H5P_DEFAULT), 0);
    EXPECT_GE(H5Adelete(file, "regime"), 0);
    H5Fclose(file);
    const auto read = read_needles_file(path_);
    EXPECT_TRUE(read.needles.front().runs[1].insertion.holding.empty());
    EXPECT_EQ(read.needles.front().runs[1].insertion.tearing.size(), 5U);
    EXPECT_EQ(read.regime, core::Regime::small);
}

TEST_F(RecordFile, OfAReferenceUnderAToolFitsItsProblemAlone) {
    auto problem = tests::tool_block();
    ToolReference reference{.model = "elements",
                            .level = 2,
                            .steps_per_frame = 4,
                            .history = {},
                            .last_refinement = {.contact = 0.01, .after = 0.02, .force = 0.03, .over_time = {}},
                            .half_steps = {.contact = 0.04, .after = 0.05, .force = 0.06, .over_time = {}}};
    for (int k = 0; k <= problem.load_case.tool->num_frames; ++k) {
        reference.history.time.push_back(k * problem.load_case.tool->frame_interval);
        reference.history.force.emplace_back(k, 0.0, 0.0);
        if (core::ToolHistory::has_field(k))
            for (std::size_t i = 0; i < problem.body->mesh.points.size(); ++i)
                reference.history.displacement.emplace_back(0.0F, 0.5F, static_cast<float>(k));
    }
    write_tool_reference(path_, reference, problem, current_provenance("livermark arena --solve-reference"));
    const auto read = read_tool_reference(path_, problem, "elements");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->level, 2);
    EXPECT_EQ(read->history.force, reference.history.force);
    EXPECT_EQ(read->history.displacement, reference.history.displacement);
    EXPECT_EQ(read->last_refinement, reference.last_refinement);
    EXPECT_EQ(read->half_steps, reference.half_steps);
    EXPECT_FALSE(read_tool_reference(path_, problem, "springs"));
    problem.load_case.tool->slide.y() *= 1.001;
    EXPECT_FALSE(read_tool_reference(path_, problem, "elements"));
    EXPECT_FALSE(read_tool_reference(directory_ / "none.h5", problem, "elements"));
}

TEST(CalibratedSprings, AreRefusedForAnotherMeshOrMaterial) {
    const auto &body = springs_body;
    const auto springs = tests::sample_calibration(*body).springs;
    EXPECT_NO_THROW(core::check_fit(springs, *body));
    auto heavier = *body;
    heavier.materials[0].density = 2000.0;
    EXPECT_NO_THROW(core::check_fit(springs, heavier));

    auto other_nodes = *body;
    other_nodes.mesh.points[0].x() -= 1e-6;
    const auto other_edges = tests::make_body(tests::box_mesh({0.2, 0.1, 0.1}, {3, 1, 1}), body->materials[0]);
    for (const core::Body *other : {static_cast<const core::Body *>(&other_nodes), other_edges.get()})
        tests::expect_input_error([&] { core::check_fit(springs, *other); },
                                  {"another mesh", "`python3 -m livermark.calibration`"});
    for (const core::Material &other : {core::Material{1060.0, 5e3, 0.3}, core::Material{1060.0, 6e3, 0.45}})
        tests::expect_input_error([&] { core::check_fit(springs, *tests::make_body(body->mesh, other)); },
                                  {"was made for Young's modulus and Poisson's ratio 5000 Pa and 0.45"});
}

TEST(CalibratedSprings, AreAModelWhereThereAreAny) {
    const auto &body = springs_body;
    models::ModelOptions options;
    const auto find = [&]() -> std::optional<core::Model> {
        for (const auto &model : models::all_models(options))
            if (model.name == "calibrated_nodal_volume")
                return model;
        return std::nullopt;
    };
    EXPECT_FALSE(find());
    const auto springs = tests::sample_calibration(*body).springs;
    options.calibration = std::make_shared<const core::CalibratedSprings>(springs);
    const auto model = find();
    ASSERT_TRUE(model);
    auto load_case = tests::empty_load_case(body->mesh);
    tests::prescribe(load_case, body->mesh, "x_min", core::Vector3::Zero());
    load_case.acceleration = {0.0, 0.0, -0.01};
    EXPECT_NO_THROW(model->check({body, load_case}));
    const auto solution = model->solve({body, load_case});
    ASSERT_TRUE(solution.springs);
    EXPECT_EQ(solution.springs->stiffness, springs.stiffness);

    const auto other = tests::make_body(body->mesh, {1060.0, 5e3, 0.3});
    EXPECT_THROW(model->check({other, load_case}), support::InputError);
}

TEST(CohortHalf, IsTrainingOfOddNumbersAndUnseenOfEvenOnes) {
    EXPECT_EQ(cohort_half("liver_variant_7"), "training");
    EXPECT_EQ(cohort_half("liver_variant_10"), "unseen");
    EXPECT_EQ(cohort_half("liver_healthy"), std::nullopt);
}

} // namespace
} // namespace livermark::results
