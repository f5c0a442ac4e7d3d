#pragma once

#include <cstdint>
#include <string>

/// What the writer and the reader of result files must agree on beyond results/schema.md.
namespace livermark::results {

inline constexpr std::int64_t schema_version = 1;

/// The model in a file of a single solution, see write_solution().
inline const std::string only_solution = "only";
inline std::string solution_group(const std::string &model) {
    return "/solutions/" + model;
}
inline std::string comparison_group(const std::string &model) {
    return "/comparisons/" + model;
}
/// Whole fields of a motion, frame after frame, and what they are off the reference.
inline std::string frames_of(const std::string &model) {
    return solution_group(model) + "/history/frames";
}
inline std::string error_frames_of(const std::string &model) {
    return comparison_group(model) + "/error_frames";
}
/// A path of loads in the large regime.
inline std::string path_group(const std::string &model) {
    return solution_group(model) + "/path";
}

} // namespace livermark::results
