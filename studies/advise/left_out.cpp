#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/support/files.hpp"
#include "core/support/toml_input.hpp"
#include "studies/advise/advise.hpp"

namespace livermark::studies {

namespace {

bool is_liver(const core::Body &body) {
    const auto patches = core::patches_of(body.mesh);
    return std::ranges::find(patches, "right_lobe_dome") != patches.end();
}

/// Whether a body has a part, by its name in the file. What a load case says no body has.
bool has_part(const core::Body &body, std::string_view part) {
    if (part == "capsule")
        return body.capsule.has_value();
    if (part == "stiffness_map")
        return !body.modulus_factor.empty();
    if (part == "vessels")
        return body.vessels || std::ranges::any_of(body.mesh.region_names,
                                                   [](const std::string &name) { return name.starts_with("vessel"); });
    return false;
}

LeftOutPart part_of(const toml::table &table) {
    support::refuse_unknown_keys(table, {"part", "words", "remedy", "body", "load_cases", "at_tool", "relative_l2"});
    LeftOutPart part{.part = support::required_string(table, "part"),
                     .words = support::required_string(table, "words"),
                     .remedy = support::required_string(table, "remedy"),
                     .body = support::required_string(table, "body"),
                     .load_cases = support::required_string(table, "load_cases")};
    const auto read_both = [&](const char *key, double &median, double &worst) {
        const auto values = support::required_numbers(table, key);
        if (values.size() != 2)
            support::refuse(table, "'{}' has to be a median and the worst", key);
        median = values[0];
        worst = values[1];
    };
    read_both("at_tool", part.at_tool, part.worst_at_tool);
    read_both("relative_l2", part.relative_l2, part.worst_relative_l2);
    return part;
}

} // namespace

std::vector<LeftOutPart> parts_left_out(const core::Body &body) {
    std::vector<LeftOutPart> parts;
    if (!is_liver(body))
        return parts;
    const auto file = support::root_folder() / cohorts_folder / "left_out.toml";
    const auto table = support::parse_toml(support::read_text(file), file);
    const auto *rows = table["row"].as_array();
    for (std::size_t r = 0; rows && r < rows->size(); ++r) {
        auto part = part_of(*rows->get(r)->as_table());
        const bool is_known = std::ranges::find(parts, part.part, &LeftOutPart::part) != parts.end();
        if (!is_known && !has_part(body, part.part)) // the first row of a part is the one that is quoted
            parts.push_back(std::move(part));
    }
    std::ranges::stable_sort(parts, std::ranges::greater(), &LeftOutPart::relative_l2);
    return parts;
}

} // namespace livermark::studies
