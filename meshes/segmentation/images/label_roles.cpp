#include "meshes/segmentation/images/label_roles.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/format.h>
#include <iterator>
#include <span>
#include <string_view>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

namespace livermark::segmentation {

/// Labels that voxels have, but for the background, in ascending order.
std::vector<int> labels_in(const LabelImage &image) {
    std::vector<bool> is_there(65536, false);
    for (const auto label : image.label)
        is_there[label] = true;
    std::vector<int> labels;
    for (int label = 1; label < 65536; ++label)
        if (is_there[static_cast<std::size_t>(label)])
            labels.push_back(label);
    return labels;
}

/// Label and name: 3 'Hepatic vein'.
std::string shown_label(const LabelImage &image, int label) {
    const auto name = image.label_names.find(label);
    return name == image.label_names.end() ? fmt::format("{}", label)
                                           : fmt::format("{} '{}'", label, support::shown(name->second));
}

std::string shown_labels(const LabelImage &image, const std::vector<int> &labels) {
    constexpr std::size_t most_named = 10;
    std::vector<std::string> shown;
    for (const int label : std::span(labels).first(std::min(labels.size(), most_named)))
        shown.push_back(shown_label(image, label));
    if (labels.size() > most_named)
        shown.push_back(fmt::format("{} more", labels.size() - most_named));
    return fmt::format("{}", fmt::join(shown, ", "));
}

namespace {

using core::SegmentRole;

constexpr int max_labels_to_guess = 10;

/// Word for a role. That of a vessel is the name of its region as well.
struct RoleWord {
    std::string_view word;
    SegmentRole role;
    core::VesselKind kind = core::VesselKind::any; ///< of a vessel

    std::string region() const { return role == SegmentRole::vessel ? std::string(word) : std::string(); }
};
constexpr std::array role_words{
    RoleWord{"liver", SegmentRole::liver},
    RoleWord{"tumour", SegmentRole::lesion},
    RoleWord{"vessel", SegmentRole::vessel},
    RoleWord{"vessel_hepatic", SegmentRole::vessel, core::VesselKind::hepatic},
    RoleWord{"vessel_portal", SegmentRole::vessel, core::VesselKind::portal},
    RoleWord{"vessel_artery", SegmentRole::vessel, core::VesselKind::artery},
    RoleWord{"cyst", SegmentRole::cyst},
    RoleWord{"gallbladder", SegmentRole::gallbladder},
    RoleWord{"ignore", SegmentRole::other},
};

std::string name_of(const LabelImage &image, int label) {
    const auto name = image.label_names.find(label);
    return name == image.label_names.end() ? std::string() : name->second;
}

core::SegmentCode code_of(const LabelImage &image, int label) {
    const auto code = image.label_codes.find(label);
    return code == image.label_codes.end() ? core::SegmentCode{} : code->second;
}

/// The part that code and name give a label.
LabelPart part_by_name(const LabelImage &image, int label) {
    const auto name = name_of(image, label);
    const auto code = code_of(image, label);
    LabelPart part{core::role_of_segment(name, code)};
    if (part.role != SegmentRole::vessel)
        return part;
    const auto kind = core::kind_of_vessel(name, code); // those beside the liver have no word, and no region
    const auto word = std::ranges::find_if(
        role_words, [&](const RoleWord &each) { return each.role == SegmentRole::vessel && each.kind == kind; });
    if (word != role_words.end())
        part.region = word->region();
    return part;
}

/// Labels of a segment with this name, in any case of letters, or the label that this is the number of.
std::vector<int> labels_named(const std::string &segment, const LabelImage &image, const std::vector<int> &there) {
    std::vector<int> labels;
    for (const int label : there)
        if (support::lower_case(name_of(image, label)) == support::lower_case(segment) && !segment.empty())
            labels.push_back(label);
    int number = 0;
    const auto *end = segment.data() + segment.size();
    if (labels.empty() && std::from_chars(segment.data(), end, number).ptr == end &&
        std::ranges::find(there, number) != there.end())
        labels.push_back(number);
    if (labels.empty())
        throw support::InputError("{}: --role names '{}', which is no segment and no label of it; it has {}",
                                  image.name, support::shown(segment), shown_labels(image, there));
    return labels;
}

/// A sentence for each label whose code decides against its name.
void tell_of_codes(const LabelImage &image, std::vector<std::string> &remarks) {
    using core::SegmentRole;
    for (const auto &[label, code] : image.label_codes) {
        const auto name = image.label_names.find(label);
        if (name == image.label_names.end())
            continue;
        const auto by_name = core::role_of_name(name->second), by_code = core::role_of_segment(name->second, code);
        if (by_name != by_code && by_name != SegmentRole::unnamed && by_name != SegmentRole::other)
            remarks.push_back(fmt::format("label {} is '{}' by its code, {}, and so it counts; --role "
                                          "chooses otherwise",
                                          shown_label(image, label), support::shown(code.meaning),
                                          support::shown(code.type)));
    }
}

/// Gives labels a part; none may have two.
void give(LabelParts &parts, const std::vector<int> &labels, const LabelPart &part) {
    for (const int label : labels)
        if (const auto [known, is_new] = parts.emplace(label, part); !is_new && known->second.role != part.role)
            throw support::InputError("label {} is given two roles by --liver, --tumours and --role; name it once",
                                      label);
}

/// Takes the lowest label for the liver and others for lesions, where nothing has names.
void guess(LabelParts &parts, const LabelImage &image, const std::vector<int> &free, bool has_tumours,
           std::vector<std::string> &remarks) {
    if (static_cast<int>(free.size()) > max_labels_to_guess)
        throw support::InputError("{}: it has {} labels, more than a liver and its lesions; name them with --liver and "
                                  "--tumours, or with --role",
                                  image.name, free.size());
    if (free.empty())
        throw support::InputError("{}: no label is left for the liver; name it with --liver", image.name);
    give(parts, {free.front()}, {SegmentRole::liver});
    std::vector<int> lesions;
    for (const auto &[label, part] : parts)
        if (part.role == SegmentRole::lesion)
            lesions.push_back(label);
    const std::vector<int> others(free.begin() + 1, free.end());
    give(parts, others, {has_tumours ? SegmentRole::other : SegmentRole::lesion});
    if (!has_tumours)
        std::ranges::copy(others, std::back_inserter(lesions));
    if (parts.size() > 1)
        remarks.push_back(fmt::format(
            "the file does not name its labels, so {}, the lowest, is taken for the liver{}; "
            "--role says which labels are vessels, cysts or other organs",
            free.front(), lesions.empty() ? "" : fmt::format(" and {} for lesions", fmt::join(lesions, ", "))));
}

/// Parts of the labels that nobody has chosen, by codes and names, or by numbers where the file has no names.
void choose_by_file(LabelParts &parts, const LabelImage &image, const std::vector<int> &there, bool has_tumours,
                    std::vector<std::string> &remarks) {
    std::vector<int> free;
    std::ranges::copy_if(there, std::back_inserter(free), [&](int label) { return !parts.contains(label); });
    bool has_names = false, has_liver = !labels_with(parts, SegmentRole::liver).empty();
    const bool is_chosen = has_liver;
    LabelParts named;
    for (const int label : free) {
        auto part = part_by_name(image, label);
        has_names = has_names || part.role != SegmentRole::unnamed;
        has_liver = has_liver || part.role == SegmentRole::liver;
        if (part.role == SegmentRole::unnamed || (has_tumours && part.role == SegmentRole::lesion))
            part.role = SegmentRole::other;
        named.emplace(label, std::move(part));
    }
    if (has_liver) {
        parts.merge(named);
        const auto lesions = labels_with(parts, SegmentRole::lesion), cysts = labels_with(parts, SegmentRole::cyst);
        if (!is_chosen)
            remarks.push_back(fmt::format("by the names of the segments label {} is the liver{}{}{}{}",
                                          fmt::join(labels_with(parts, SegmentRole::liver), ", "),
                                          lesions.empty() ? "" : " and lesions are ", fmt::join(lesions, ", "),
                                          cysts.empty() ? "" : " and cysts are ", fmt::join(cysts, ", ")));
        tell_of_codes(image, remarks);
        return;
    }
    if (has_names)
        throw support::InputError("{}: none of its segments is a liver by its name: {}; if one is, give its label to "
                                  "`livermark mesh --labels` with --liver",
                                  image.name, shown_labels(image, there));
    guess(parts, image, free, has_tumours, remarks);
}

} // namespace

ChosenRole chosen_role(const std::string &words) {
    const auto equals = words.rfind('=');
    const auto word = equals == std::string::npos ? std::string() : words.substr(equals + 1);
    const auto known = std::ranges::find(role_words, word, &RoleWord::word);
    if (known == role_words.end() || equals == 0) {
        std::vector<std::string_view> all;
        std::ranges::transform(role_words, std::back_inserter(all), &RoleWord::word);
        throw support::InputError("--role is '{}'; give the name of a segment or a label, '=' and one of {}",
                                  support::shown(words), fmt::join(all, ", "));
    }
    return {words.substr(0, equals), known->role, known->region()};
}

std::vector<int> labels_with(const LabelParts &parts, core::SegmentRole role) {
    std::vector<int> labels;
    for (const auto &[label, part] : parts)
        if (part.role == role)
            labels.push_back(label);
    return labels;
}

std::map<core::SegmentRole, std::vector<int>> labels_by_role(const LabelImage &image) {
    std::map<core::SegmentRole, std::vector<int>> roles;
    for (const int label : labels_in(image))
        roles[core::role_of_segment(name_of(image, label), code_of(image, label))].push_back(label);
    return roles;
}

LabelParts parts_of_labels(const LabelImage &image, const LabelChoice &choice, std::vector<std::string> &remarks) {
    const auto there = labels_in(image);
    if (there.empty())
        throw support::InputError("{}: every voxel is background, so there is no liver in it", image.name);
    for (const auto *labels : {&choice.liver, &choice.tumours})
        for (const int label : *labels)
            if (std::ranges::find(there, label) == there.end())
                throw support::InputError("{}: no voxel has the label {}; it has {}", image.name, label,
                                          fmt::join(there, ", "));
    for (const int label : choice.tumours)
        if (std::ranges::find(choice.liver, label) != choice.liver.end())
            throw support::InputError("label {} cannot be both liver and tumour; name it once", label);
    LabelParts parts;
    give(parts, choice.liver, {SegmentRole::liver});
    give(parts, choice.tumours, {SegmentRole::lesion});
    for (const auto &chosen : choice.roles)
        give(parts, labels_named(chosen.segment, image, there), {chosen.role, chosen.region});
    if (choice.liver.empty())
        choose_by_file(parts, image, there, !choice.tumours.empty(), remarks);
    for (const int label : there) // with --liver nothing but what is named belongs to the body
        if (!parts.contains(label))
            parts.emplace(label,
                          LabelPart{part_by_name(image, label).role == SegmentRole::vessel ? SegmentRole::vessel
                                                                                           : SegmentRole::other});
    return parts;
}

} // namespace livermark::segmentation
