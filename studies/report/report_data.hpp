#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "results/records/arena.hpp"
#include "results/records/cohort.hpp"
#include "results/records/experiment.hpp"
#include "results/records/needle.hpp"
#include "results/records/result.hpp"
#include "results/records/springs.hpp"
#include "results/records/timings.hpp"

namespace livermark::studies {

/// Names of files relative to their folder, by what is in them, in the order of what ReportData has of them. Python
/// reads the sensitivities.
struct ReportFiles {
    std::vector<std::string> results, large, cohorts, arenas, stability, timings, experiments, needles, sensitivities;
    std::vector<std::string> others; ///< of other kinds, which no part of the report is about
};

/// Contents of the files below a folder.
struct ReportData {
    std::filesystem::path folder; ///< that was read
    ReportFiles files;
    std::vector<results::Result> results; ///< with models, of small deformations
    std::vector<results::Result> large;   ///< with models, of large deformations; never beside the others
    std::vector<results::Cohort> cohorts; ///< their bodies are not among the results
    std::vector<results::Arena> arenas;
    std::vector<results::Stability> stability;
    std::vector<results::Timings> timings;
    std::vector<results::ExperimentResult> experiments;
    std::vector<results::NeedleFile> needles;
    std::vector<std::string> faults; ///< a sentence for each file that cannot be read or is damaged, and is left out
};

/// Reads every .h5 below a folder. Result files of the bodies of a cohort stand below its file and are left out: they
/// are many, and what they come to is in that file. Of results against several references those of the one that most
/// files have stay; the others are faults.
/// @param left_out  names of files that are not to be read, and why: the sentences are faults
/// @throws support::InputError if the folder cannot be listed, or none of the files has anything for a report
ReportData read_report_data(const std::filesystem::path &folder,
                            const std::map<std::string, std::string> &left_out = {});

/// Input of the Python program livermark.report beside the files themselves, as JSON: which files there are, and
/// the tables that `livermark table` and others print too, so that each is made in one place.
/// python/livermark/report/data.py reads it.
/// @param command_line  that makes the report again
std::string report_tables(const ReportData &data, const std::string &command_line);

} // namespace livermark::studies
