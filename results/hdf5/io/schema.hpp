#pragma once

#include <cstdint>
#include <string>

/// What the writer and the reader of result files must agree on beyond results/schema.md.
namespace livermark::results {

inline constexpr std::int64_t schema_version = 1;

inline const std::string reference_group = "/reference";
inline const std::string motion_reference_group = "/motion_reference";
/// The model in a file of a single solution, see write_solution().
inline const std::string only_solution = "only";
inline std::string solution_group(const std::string &model) {
    return "/solutions/" + model;
}
inline std::string comparison_group(const std::string &model) {
    return "/comparisons/" + model;
}
inline std::string history_group(const std::string &model) {
    return solution_group(model) + "/history";
}
/// Whole fields of a motion, frame after frame, and what they are off the reference.
inline std::string frames_of(const std::string &model) {
    return history_group(model) + "/frames";
}
inline std::string error_frames_of(const std::string &model) {
    return comparison_group(model) + "/error_frames";
}
/// A path of loads in the large regime.
inline std::string path_group(const std::string &model) {
    return solution_group(model) + "/path";
}
inline std::string modes_group(const std::string &model) {
    return "/modes/" + model;
}

} // namespace livermark::results
