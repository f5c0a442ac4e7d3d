#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Records of one model while a blade goes on, K: before the first step and after each.
struct CutRun {
    std::string model;
    std::vector<double> stored{};  ///< (K) strain energy [J]
    std::vector<double> work{};    ///< (K) of the loads from rest, which are there from the beginning [J]
    std::vector<double> opening{}; ///< (K) of the wound, where it is widest [m]
    /// (K) stiffness where the body is touched, core::stiffness_at() the first tool [N/m]; NaN without one
    std::vector<double> tool_stiffness{};
    std::vector<double> setup_seconds{}; ///< (K) for all of the model that comes before the loads, set up anew [s]
    std::vector<double> solve_seconds{}; ///< (K) for the equilibrium, with that [s]; both 0 where nothing was parted
    /// Springs alone: critical step of symplectic Euler with nothing damped and nothing constrained [s], before the
    /// first step of the blade, after the last one, and after the exact cut where there is one. Empty of other models.
    std::vector<double> critical_time_step{};

    /// Energy that the cut has set free until then: work of the loads less what is stored, each less that before the
    /// cut [J].
    double released(std::size_t record) const { return (work[record] - work[0]) - (stored[record] - stored[0]); }
};

/// A method that moves a body while a blade goes on, within a budget. Records are as those of CutRun: taken when the
/// frames of a step of the blade are over, the last one when the body has come to rest after it. NaN from where the
/// body has left all bounds.
struct CutMotion {
    std::string method, setting;          ///< how it uses its time
    double budget = 0.0;                  ///< of one core, for a frame [s]
    int steps = 0;                        ///< in a frame
    int iterations = 0;                   ///< in a step
    double setup_seconds = 0.0;           ///< before the first frame [s]
    double frame_seconds = 0.0;           ///< of the processor, median over frames [s]
    double worst_frame_seconds = 0.0;     ///< with the time of the cut that comes before it, if there is one [s]
    std::vector<double> opening{};        ///< (K) of the wound, where it is widest [m]
    std::vector<double> tool_stiffness{}; ///< (K) [N/m]
    /// (K) from the body that the step has left to the next frame [s]; 0 where nothing was parted
    std::vector<double> ready_seconds{};

    bool operator==(const CutMotion &) const = default;
};

/// The reference on the body as the blade has left it in the end, on the mesh or on one that is finer at the rim of the
/// wound.
struct CutLevel {
    std::string way;             ///< how the body was cut: meshes::CutWay
    int tetrahedra = 0;          ///< of the mesh
    double area = 0.0;           ///< cut [m^2]
    double depth = 0.0;          ///< that the rim of the wound has along the way of the blade, its mean [m]
    double opening = 0.0;        ///< at the nodes of the coarsest mesh of this way [m]
    double tool_stiffness = 0.0; ///< [N/m]
    double solve_seconds = 0.0;  ///< for the equilibrium, with the set-up [s]

    bool operator==(const CutLevel &) const = default;
};

/// A number and its error, as core::observed_error() has it.
struct ErrorBar {
    double value = 0.0, error = 0.0;
};

/// Numbers that models are compared with in the end.
struct CutJudge {
    ErrorBar opening, tool_stiffness; ///< [m], [N/m]
    bool is_refined = false;          ///< or the reference on the mesh of the models, whose errors are not known (0)
};

/// A blade that goes into a body under load: the content of one cut file.
struct CutFile {
    Provenance provenance;
    std::string body, load_case, title;
    std::array<core::Vector3, 4> blade{};      ///< its edge goes from 0-1 to 3-2 [m]
    double toughness = 0.0;                    ///< [J/m^2]
    std::vector<double> depth{};               ///< (K) of the edge along its way [m]
    std::vector<double> area{};                ///< (K) cut so far [m^2]
    std::vector<double> cut_seconds{};         ///< (K) that dividing the body took [s]
    std::vector<int> nodes{};                  ///< (K) of the mesh
    std::vector<CutRun> runs{};                ///< the first is the reference
    core::Regime regime = core::Regime::small; ///< of deformations, in which models are compared
    std::vector<CutLevel> levels{};            ///< of each way from coarse to fine; none if nobody asked
    double frame_interval = 0.0;               ///< of the motions [s]; 0 if there are none
    int frames_per_step = 0;                   ///< of the blade
    std::vector<CutMotion> motions{};

    std::size_t num_records() const { return depth.size(); }
    /// The finest of a way, with what it still lacks; nothing where there are fewer than three.
    /// @param number  CutLevel::opening or CutLevel::tool_stiffness
    std::optional<ErrorBar> in_the_end(const std::string &way, double CutLevel::*number) const;
    /// The finest mesh of the cut along facets, which is that of the models, where there are three.
    CutJudge judge_in_the_end() const;
    /// Times from the blade to the next step's loads: dividing the body and setting a model up for it, a time for each
    /// step that has parted something [s].
    std::vector<double> ready_seconds(const CutRun &run) const;
    /// The same of the equilibrium that follows [s].
    std::vector<double> equilibrium_seconds(const CutRun &run) const;
    /// Energy of tearing for the cut until then [J].
    double tearing(std::size_t record) const { return toughness * area[record]; }
    /// Energy released over area cut in a step; NaN where nothing was cut [J/m^2].
    double release_rate(const CutRun &run, std::size_t record) const;
};

/// The "Cut files" of results/schema.md; errors as of write_result() and read_result().
void write_cut(const std::filesystem::path &path, const CutFile &cut);
CutFile read_cut_file(const std::filesystem::path &path);

/// A row for each record of the reference: numbers of its CutRun, and the part of tearing that the blade has to do
/// itself so far.
Layout cut_table(const CutFile &file);

/// A row for each model: its numbers in the end beside the reference, the median and the longest time from the blade
/// until the model is set up for the body that it leaves, and the median of the equilibrium that follows. The reference
/// is CutFile::judge_in_the_end(); a refined one has no released energy, and a row of its own with its error bars.
Layout cut_models_table(const CutFile &file);

/// A sentence: which reference errors of models and methods are against, and how exact it is.
std::string cut_judge_note(const CutFile &file);

/// A row for each CutLevel.
Layout cut_levels_table(const CutFile &file);

/// A sentence for each way to cut with three meshes: opening and stiffness on the finest one, with their errors, and
/// how far the reference on the coarsest one is from that. Empty if there is none.
std::string cut_levels_note(const CutFile &file);

/// A row for each model of springs: its critical step before the cut, after it along facets, and after the exact cut
/// [ms]. No rows where no model has springs.
Layout cut_steps_table(const CutFile &file);

/// A row for each method that moves within each budget, in the order of budgets, and of the larger one of the errors of
/// opening and stiffness in one; methods that are too slow for it come last. Of the settings of a method the best in
/// this order is shown.
Layout cut_motions_table(const CutFile &file);

/// A sentence: where the reference releases more than tearing takes.
std::string cut_note(const CutFile &file);

} // namespace livermark::results
