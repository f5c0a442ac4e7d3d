#pragma once

#include <cstdint>
#include <string>

/// What the writer and the reader of result files must agree on beyond results/schema.md.
namespace livermark::results {

inline constexpr std::int64_t schema_version = 1;

inline const std::string reference_group = "/reference";
inline std::string solution_group(const std::string &model) {
    return "/solutions/" + model;
}
inline std::string comparison_group(const std::string &model) {
    return "/comparisons/" + model;
}

} // namespace livermark::results
