#include "meshes/segmentation/program/vessel_lines.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <vector>

#include "core/mesh/plausible_liver.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "meshes/io/vessel_files.hpp"
#include "meshes/segmentation/images/centrelines.hpp"
#include "meshes/segmentation/images/label_roles.hpp"
#include "meshes/segmentation/images/segmentation.hpp"

namespace livermark::segmentation {

namespace {

void say(const std::string &sentence) {
    fmt::print(stderr, "livermark: {}\n", sentence);
}

/// Whether a segment of --role, a name in any case of letters or the number of a label, is a label of an image.
bool is_meant(const ChosenRole &chosen, const LabelImage &image, int label) {
    const auto name = image.label_names.find(label);
    return chosen.segment == fmt::format("{}", label) ||
           (name != image.label_names.end() &&
            support::lower_case(name->second) == support::lower_case(chosen.segment));
}

std::vector<ChosenRole> chosen_roles(const VesselCommand &command, const LabelImage &image,
                                     const std::vector<int> &labels) {
    std::vector<ChosenRole> roles;
    for (const auto &words : command.roles) {
        roles.push_back(chosen_role(words));
        if (std::ranges::none_of(labels, [&](int label) { return is_meant(roles.back(), image, label); }))
            throw support::InputError("{}: --role names '{}', which is no segment and no label of it; it has {}",
                                      image.name, support::shown(roles.back().segment), shown_labels(image, labels));
    }
    return roles;
}

/// Labels of vessels.
struct VesselLabels {
    std::vector<int> inside;
    std::vector<int> beside; ///< such as the vena cava, unless --role says more
};

/// Vessels among labels, by choice, codes and names. Unlike a body, lines need no label of a liver.
VesselLabels vessel_labels(const LabelImage &image, const std::vector<int> &labels,
                           const std::vector<ChosenRole> &roles) {
    VesselLabels vessels;
    for (const int label : labels) {
        const auto chosen =
            std::ranges::find_if(roles, [&](const ChosenRole &role) { return is_meant(role, image, label); });
        if (chosen != roles.end()) {
            if (chosen->role == core::SegmentRole::vessel)
                vessels.inside.push_back(label);
            continue;
        }
        const auto name = image.label_names.find(label);
        const auto code = image.label_codes.find(label);
        const auto words = name == image.label_names.end() ? std::string() : name->second;
        const auto concept_of_it = code == image.label_codes.end() ? core::SegmentCode{} : code->second;
        if (core::role_of_segment(words, concept_of_it) == core::SegmentRole::vessel)
            (core::kind_of_vessel(words, concept_of_it) == core::VesselKind::beside ? vessels.beside : vessels.inside)
                .push_back(label);
    }
    return vessels;
}

/// Adds a tree to another one of the same wall.
void join(core::VesselTree &all, const core::VesselTree &tree) {
    const auto first = static_cast<int>(all.points.size());
    all.points.insert(all.points.end(), tree.points.begin(), tree.points.end());
    all.radius.insert(all.radius.end(), tree.radius.begin(), tree.radius.end());
    for (const auto &[a, b] : tree.segments)
        all.segments.push_back({first + a, first + b});
}

/// Parts of a tree between ends and branch points.
int num_branches(const core::VesselTree &tree) {
    std::vector<int> num_at(tree.points.size(), 0);
    for (const auto &segment : tree.segments)
        for (const int point : segment)
            ++num_at[static_cast<std::size_t>(point)];
    return static_cast<int>(std::ranges::count_if(
        tree.segments, [&](const auto &segment) { return num_at[static_cast<std::size_t>(segment[1])] != 2; }));
}

/// The part of a sentence that says how large the lines are.
std::string size_of(const core::VesselTree &tree) {
    const auto [thin, thick] = std::ranges::minmax(tree.radius);
    const int branches = num_branches(tree);
    return fmt::format("{} branch{} of {:.3g} m together, with radii of {:.2g} to {:.2g} mm", branches,
                       branches == 1 ? "" : "es", meshes::length_of(tree), 1e3 * thin, 1e3 * thick);
}

} // namespace

int write_vessel_lines(const VesselCommand &command) {
    const auto image = read_label_image(command.labels);
    for (const auto &sentence : image.remarks)
        say(sentence);
    const auto labels = labels_in(image);
    if (labels.empty())
        throw support::InputError("{}: every voxel is background, so there is no vessel in it", image.name);
    const auto vessels = vessel_labels(image, labels, chosen_roles(command, image, labels));
    if (vessels.inside.empty())
        throw support::InputError("{}: none of its labels is a vessel of the liver by its name: {}; if one is, give it "
                                  "with --role, such as --role {}=vessel_portal",
                                  image.name, shown_labels(image, labels), labels.back());
    if (!vessels.beside.empty())
        say(fmt::format("vessels beside the liver are left out: {}; --role takes one as a vessel",
                        shown_labels(image, vessels.beside)));
    core::VesselTree tree;
    CentrelineOptions options;
    options.largest_radius = command.largest_radius;
    std::vector<char> is_vessel(image.label.size());
    for (const int label : vessels.inside) {
        std::ranges::transform(image.label, is_vessel.begin(), [&](int each) { return each == label ? 1 : 0; });
        const auto lines = centrelines(image.grid, is_vessel, options);
        if (lines.segments.empty())
            say(fmt::format("label {} has no line: it is shorter than {:g} mm{}", shown_label(image, label),
                            1e3 * options.least_length,
                            std::isfinite(command.largest_radius) ? " or thicker than --largest-radius" : ""));
        join(tree, lines);
    }
    if (tree.segments.empty())
        throw support::InputError(
            "{}: no line is left of its vessels, {}; {}", image.name, shown_labels(image, vessels.inside),
            std::isfinite(command.largest_radius) ? "give a larger --largest-radius, or vessels that are longer"
                                                  : "give vessels that are longer, or finer voxels");
    const auto file = std::filesystem::path(command.output).filename().string();
    support::write_whole(
        command.output, meshes::swc_text(tree, fmt::format("lines of the vessels of {}, in metres and in its patient's "
                                                           "axes (LPS)",
                                                           support::shown(image.name))));
    fmt::print("{}: {}, of label{} {}\n\nFor a body of the same patient, with the file beside its .toml:\n\n[vessels]\n"
               "file = \"{}\"\nunit = \"m\"\n",
               command.output, size_of(tree), vessels.inside.size() == 1 ? "" : "s",
               shown_labels(image, vessels.inside), file);
    return 0;
}

} // namespace livermark::segmentation
