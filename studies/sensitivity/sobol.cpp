#include "studies/sensitivity/sobol.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>

#include "support/processes/python_program.hpp"
#include "support/toml_input.hpp"

namespace livermark::studies {

namespace {

toml::table ask_openturns(const std::string &part, const std::string &json) {
    constexpr auto program = "studies.sobol";
    return support::parse_toml(
        support::run_python(program, {part}, json, "a sensitivity study", "python3-openturns python3-numpy"), program);
}

std::string json_rows(const std::vector<std::vector<double>> &rows) {
    std::string text;
    for (const auto &row : rows)
        text += fmt::format("{}[{:.17g}]", text.empty() ? "" : ",", fmt::join(row, ","));
    return "[" + text + "]";
}

} // namespace

std::vector<std::vector<double>> sobol_points(std::size_t count, std::size_t dimension) {
    const auto answer = ask_openturns("points", fmt::format(R"({{"count": {}, "dimension": {}}})", count, dimension));
    const auto numbers = support::required_numbers(answer, "points");
    std::vector<std::vector<double>> points;
    for (auto row = numbers.begin(); row != numbers.end(); row += static_cast<std::ptrdiff_t>(dimension))
        points.emplace_back(row, row + static_cast<std::ptrdiff_t>(dimension));
    return points;
}

std::vector<SobolIndices> sobol_indices(const std::vector<std::vector<double>> &points,
                                        const std::vector<std::vector<double>> &values,
                                        const std::vector<std::vector<int>> &groups) {
    std::string group_rows;
    for (const auto &group : groups)
        group_rows += fmt::format("{}[{}]", group_rows.empty() ? "" : ",", fmt::join(group, ","));
    const auto answer =
        ask_openturns("indices", fmt::format(R"({{"dimension": {}, "points": {}, "values": {}, "groups": [{}]}})",
                                             points.front().size(), json_rows(points), json_rows(values), group_rows));
    std::vector<SobolIndices> found;
    for (const auto &node : *answer["output"].as_array()) {
        const auto &output = *node.as_table();
        const auto numbers = [&](const char *key) { return support::required_numbers(output, key); };
        found.push_back({numbers("first"), numbers("first_lower"), numbers("first_upper"), numbers("total"),
                         numbers("total_lower"), numbers("total_upper"), numbers("group_total"),
                         support::required_number(output, "unexplained")});
    }
    return found;
}

} // namespace livermark::studies
