#pragma once

#include <array>
#include <string>
#include <vector>

#include "results/records/result.hpp"

namespace livermark::results {

/// What one model says while a blade goes on, K records: before the first step and after each.
struct CutRun {
    std::string model;
    std::vector<double> stored{};  ///< (K) strain energy [J]
    std::vector<double> work{};    ///< (K) of the loads from rest, which are there from the beginning [J]
    std::vector<double> opening{}; ///< (K) of the wound, where it is widest [m]
    /// (K) stiffness where the body is touched, core::stiffness_at() the first tool [N/m]; NaN without one
    std::vector<double> tool_stiffness{};
    std::vector<double> setup_seconds{}; ///< (K) for all of the model that comes before the loads, set up anew [s]
    std::vector<double> solve_seconds{}; ///< (K) for the equilibrium, with that [s]; both 0 where nothing was parted

    /// What the cut has set free until then: work of the loads less what is stored, each less that before the cut [J].
    double released(std::size_t record) const { return (work[record] - work[0]) - (stored[record] - stored[0]); }
};

/// A blade that goes into a body under load: the content of one cut file.
struct CutFile {
    Provenance provenance;
    std::string body, load_case, title;
    std::array<core::Vector3, 4> blade{}; ///< its edge goes from 0-1 to 3-2 [m]
    double toughness = 0.0;               ///< [J/m^2]
    std::vector<double> depth{};          ///< (K) of the edge along its way [m]
    std::vector<double> area{};           ///< (K) cut so far [m^2]
    std::vector<double> cut_seconds{};    ///< (K) that dividing the body took [s]
    std::vector<int> nodes{};             ///< (K) of the mesh
    std::vector<CutRun> runs{};           ///< the first is the reference

    std::size_t num_records() const { return depth.size(); }
    /// From the blade to the next step's loads: dividing the body and setting a model up for it, a time for each step
    /// that has parted something [s].
    std::vector<double> ready_seconds(const CutRun &run) const;
    /// The same of the equilibrium that follows [s].
    std::vector<double> equilibrium_seconds(const CutRun &run) const;
    /// What has to be torn for the cut until then [J].
    double tearing(std::size_t record) const { return toughness * area[record]; }
    /// Energy released over area cut in a step; NaN where nothing was cut [J/m^2].
    double release_rate(const CutRun &run, std::size_t record) const;
};

} // namespace livermark::results
