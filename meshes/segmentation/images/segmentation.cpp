#include "meshes/segmentation/images/segmentation.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <iterator>
#include <itkBinaryFillholeImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkImage.h>
#include <map>
#include <numbers>

#include "core/support/input_error.hpp"
#include "meshes/segmentation/images/label_roles.hpp"
#include "meshes/segmentation/images/voxel_shapes.hpp"

namespace livermark::segmentation {

std::size_t num_voxels(const ImageGrid &grid) {
    return static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1]) *
           static_cast<std::size_t>(grid.size[2]);
}

double voxel_volume(const ImageGrid &grid) {
    return grid.spacing.prod();
}

core::Vector3 to_world(const ImageGrid &grid, const core::Vector3 &place) {
    return grid.origin + grid.direction * place;
}

namespace {

using core::SegmentRole;
using Mask = itk::Image<std::uint8_t, 3>;
using Pieces = itk::Image<std::uint32_t, 3>;

constexpr std::size_t max_regions = 255;
/// Clefts and tunnels of the liver that a ball of this radius cannot enter are filled where they are vessel [m]: the
/// trunks are up to 20 mm across.
constexpr double vessel_reach = 0.012;

Mask::Pointer mask_where(const ImageGrid &grid, const std::function<bool(std::size_t)> &is_inside) {
    auto mask = Mask::New();
    Mask::SizeType size;
    for (unsigned d = 0; d < 3; ++d)
        size[d] = static_cast<itk::SizeValueType>(grid.size.at(d));
    mask->SetRegions(size);
    mask->Allocate();
    for (std::size_t v = 0; v < num_voxels(grid); ++v)
        mask->GetBufferPointer()[v] = is_inside(v) ? 1 : 0;
    return mask;
}

/// Pieces that hang together by faces of voxels.
struct ConnectedPieces {
    Pieces::Pointer image;         ///< 0 outside, else 1 + index of the piece
    std::vector<std::size_t> size; ///< voxels of each
};

ConnectedPieces connected_pieces(const Mask::Pointer &mask) {
    auto filter = itk::ConnectedComponentImageFilter<Mask, Pieces>::New();
    filter->SetInput(mask);
    filter->FullyConnectedOff();
    filter->Update();
    ConnectedPieces pieces{filter->GetOutput(), std::vector<std::size_t>(filter->GetObjectCount(), 0)};
    const auto num_voxels = pieces.image->GetPixelContainer()->Size();
    for (std::size_t v = 0; v < num_voxels; ++v)
        if (const auto piece = pieces.image->GetBufferPointer()[v])
            ++pieces.size[piece - 1];
    return pieces;
}

std::string millilitres(std::size_t voxels, const ImageGrid &grid) {
    return fmt::format("{:.3g} mL", 1e6 * voxel_volume(grid) * static_cast<double>(voxels));
}

/// Whether each label is one of these.
std::vector<bool> label_table(const std::vector<int> &labels) {
    std::vector<bool> is_one(65536, false);
    for (const int label : labels)
        is_one[static_cast<std::size_t>(label)] = true;
    return is_one;
}

VoxelSet voxels_with(const LabelImage &image, const std::vector<int> &labels) {
    const auto is_one = label_table(labels);
    VoxelSet set(image.label.size());
    for (std::size_t v = 0; v < set.size(); ++v)
        set[v] = is_one[image.label[v]] ? 1 : 0;
    return set;
}

/// Labels of vessels that may be regions.
std::vector<int> labels_of_vessels(const LabelParts &parts) {
    std::vector<int> labels;
    for (const auto &[label, part] : parts)
        if (part.role == SegmentRole::vessel && !part.region.empty())
            labels.push_back(label);
    return labels;
}

/// Liver and lesions, and the vessels between them.
VoxelSet body_voxels(const LabelImage &image, const LabelParts &parts) {
    auto labels = labels_with(parts, SegmentRole::liver);
    for (const auto role : {SegmentRole::lesion, SegmentRole::cyst})
        std::ranges::copy(labels_with(parts, role), std::back_inserter(labels));
    auto body = voxels_with(image, labels);
    if (const auto vessels = labels_of_vessels(parts); !vessels.empty()) {
        const auto is_vessel = label_table(vessels);
        const auto closed = closed_by_ball(image.grid, body, vessel_reach);
        for (std::size_t v = 0; v < body.size(); ++v)
            if (closed[v] != 0 && is_vessel[image.label[v]])
                body[v] = 1;
    }
    return body;
}

/// The largest piece of the body without its cavities.
Mask::Pointer solid_body(const LabelImage &image, const VoxelSet &voxels, std::vector<std::string> &remarks) {
    const auto &grid = image.grid;
    const auto pieces = connected_pieces(mask_where(grid, [&](auto v) { return voxels[v] != 0; }));
    const auto largest = std::ranges::max_element(pieces.size) - pieces.size.begin();
    std::size_t voxels_apart = 0;
    for (const auto size : pieces.size)
        voxels_apart += size;
    voxels_apart -= pieces.size[static_cast<std::size_t>(largest)];
    if (voxels_apart > 0)
        remarks.push_back(fmt::format("{} pieces of {} in all that do not touch the largest one are left out",
                                      pieces.size.size() - 1, millilitres(voxels_apart, grid)));

    auto fill = itk::BinaryFillholeImageFilter<Mask>::New();
    fill->SetInput(mask_where(grid, [&](auto v) { return pieces.image->GetBufferPointer()[v] == largest + 1; }));
    fill->SetForegroundValue(1);
    fill->FullyConnectedOff();
    fill->Update();
    Mask::Pointer body = fill->GetOutput();
    const auto filled = std::count(body->GetBufferPointer(), body->GetBufferPointer() + num_voxels(grid), 1);
    const auto holes = static_cast<std::size_t>(filled) - pieces.size[static_cast<std::size_t>(largest)];
    if (holes > 0)
        remarks.push_back(fmt::format("cavities of {} in all become parenchyma", millilitres(holes, grid)));
    return body;
}

/// Voxels of some labels in the body and outside of it.
struct VoxelCounts {
    std::size_t inside = 0, outside = 0;
};

VoxelCounts counts_of(const LabelImage &image, const std::vector<int> &labels, const Mask::Pointer &body) {
    const auto is_meant = label_table(labels);
    VoxelCounts counts;
    for (std::size_t v = 0; v < image.label.size(); ++v)
        if (is_meant[image.label[v]])
            ++(body->GetBufferPointer()[v] == 1 ? counts.inside : counts.outside);
    return counts;
}

/// Adds remarks on the labels that are no part of the body.
void tell_left_out(const LabelImage &image, const LabelParts &parts, const Mask::Pointer &body,
                   std::vector<std::string> &remarks) {
    std::vector<int> vessels;
    for (const auto &[label, part] : parts)
        if (part.role == SegmentRole::vessel && part.region.empty())
            vessels.push_back(label);
    const auto tell = [&](const std::vector<int> &labels, const std::string &what) {
        if (labels.empty())
            return;
        const auto counts = counts_of(image, labels, body);
        remarks.push_back(fmt::format("{} are left out: {}; {} of them that the liver encloses become parenchyma, {} "
                                      "are holes in it or lie outside",
                                      what, shown_labels(image, labels), millilitres(counts.inside, image.grid),
                                      millilitres(counts.outside, image.grid)));
    };
    tell(vessels, "vessels and ducts that have no region of their own");
    tell(labels_with(parts, SegmentRole::other), "labels that are neither the liver's nor a lesion's");
}

struct Lesion {
    int label;
    std::vector<std::size_t> voxels;
};

/// The connected pieces of every tumour label inside the body, largest first.
std::vector<Lesion> lesions_of(const LabelImage &image, const std::vector<int> &labels, const Mask::Pointer &body) {
    std::vector<Lesion> lesions;
    for (const int label : labels) {
        const auto pieces = connected_pieces(mask_where(
            image.grid, [&](auto v) { return image.label[v] == label && body->GetBufferPointer()[v] == 1; }));
        const auto first = lesions.size();
        lesions.resize(first + pieces.size.size(), {label, {}});
        for (std::size_t v = 0; v < image.label.size(); ++v)
            if (const auto piece = pieces.image->GetBufferPointer()[v])
                lesions[first + piece - 1].voxels.push_back(v);
    }
    std::ranges::stable_sort(lesions, std::greater(), [](const Lesion &lesion) { return lesion.voxels.size(); });
    return lesions;
}

/// The body as it grows, region by region.
struct GrowingBody {
    const LabelImage &image;
    const LabelParts &parts;
    Mask::Pointer body;
    double tetrahedron; ///< [m^3]
    Segmentation &result;

    bool is_inside(std::size_t voxel) const { return body->GetBufferPointer()[voxel] == 1; }
    bool is_too_small(std::size_t voxels) const {
        return static_cast<double>(voxels) * voxel_volume(image.grid) < tetrahedron;
    }
    void say(std::string remark) const { result.remarks.push_back(std::move(remark)); }

    std::uint8_t add_region(std::string name) const {
        result.region_names.push_back(std::move(name));
        if (result.region_names.size() > max_regions)
            throw support::InputError("{}: there are more than {} lesions and vessels; name fewer labels with "
                                      "--tumours, or leave some out with --role",
                                      image.name, max_regions - 1);
        return static_cast<std::uint8_t>(result.region_names.size());
    }
};

/// @param kind  of the lesions, as their regions are called
void add_lesions(const GrowingBody &growing, SegmentRole role, const std::string &kind, const std::string &kinds) {
    const auto &grid = growing.image.grid;
    std::size_t num_small = 0, small_voxels = 0, number = 0;
    for (const auto &lesion : lesions_of(growing.image, labels_with(growing.parts, role), growing.body)) {
        if (growing.is_too_small(lesion.voxels.size())) {
            ++num_small;
            small_voxels += lesion.voxels.size();
            continue;
        }
        const auto name = fmt::format("{}_{}", kind, ++number);
        const auto region = growing.add_region(name);
        growing.say(fmt::format("{}: {} of label {}", name, millilitres(lesion.voxels.size(), grid), lesion.label));
        for (const auto voxel : lesion.voxels)
            growing.result.region[voxel] = region;
    }
    if (num_small > 0)
        growing.say(fmt::format("{} {} below {:.2g} mL, {} in all, become parenchyma; more tetrahedra would resolve "
                                "smaller ones",
                                num_small, kinds, 1e6 * growing.tetrahedron, millilitres(small_voxels, grid)));
}

/// Adds the parts of vessels that tetrahedra resolve; a sentence for each label says what became of it.
void add_vessels(const GrowingBody &growing) {
    const auto &image = growing.image;
    std::map<std::string, std::vector<int>> labels_of_region;
    for (const auto &[label, part] : growing.parts)
        if (part.role == SegmentRole::vessel && !part.region.empty())
            labels_of_region[part.region].push_back(label);
    const double thinnest = edges_across_vessel * std::cbrt(6.0 * std::numbers::sqrt2 * growing.tetrahedron);
    for (const auto &[name, labels] : labels_of_region) {
        auto set = voxels_with(image, labels);
        for (std::size_t v = 0; v < set.size(); ++v)
            if (!growing.is_inside(v))
                set[v] = 0;
        const auto thick = opened_by_ball(image.grid, set, 0.5 * thinnest);
        if (std::ranges::find(thick, 1) != thick.end()) {
            const auto region = growing.add_region(name);
            for (std::size_t v = 0; v < thick.size(); ++v)
                if (thick[v] != 0)
                    growing.result.region[v] = region;
        }
        for (const int label : labels) {
            const auto counts = counts_of(image, {label}, growing.body);
            std::size_t num_thick = 0;
            for (std::size_t v = 0; v < thick.size(); ++v)
                num_thick += thick[v] != 0 && image.label[v] == label ? 1 : 0;
            const auto shown = shown_label(image, label);
            if (num_thick > 0)
                growing.say(fmt::format("{}: {} of label {}", name, millilitres(num_thick, image.grid), shown));
            if (counts.inside > num_thick)
                growing.say(fmt::format("{} of {} of label {} in the liver are thinner than {:.3g} mm, {} edges of a "
                                        "tetrahedron, and become parenchyma; more tetrahedra keep more",
                                        millilitres(counts.inside - num_thick, image.grid),
                                        millilitres(counts.inside, image.grid), shown, 1e3 * thinnest,
                                        edges_across_vessel));
            if (counts.outside > 0)
                growing.say(fmt::format("{} of label {} reach out of the liver and are left out",
                                        millilitres(counts.outside, image.grid), shown));
        }
    }
}

/// Adds what the liver encloses of a gallbladder; one beside it is no part of the body.
void add_gallbladder(const GrowingBody &growing) {
    const auto &image = growing.image;
    const auto labels = labels_with(growing.parts, SegmentRole::gallbladder);
    if (labels.empty())
        return;
    const auto counts = counts_of(image, labels, growing.body);
    const bool is_region = counts.inside > 0 && !growing.is_too_small(counts.inside);
    growing.say(
        fmt::format("the gallbladder, label {}: {} that the liver encloses {}, {} beside the liver are left out",
                    shown_labels(image, labels), millilitres(counts.inside, image.grid),
                    is_region ? "are a region" : "become parenchyma", millilitres(counts.outside, image.grid)));
    if (!is_region)
        return;
    const auto region = growing.add_region("gallbladder");
    const auto is_one = label_table(labels);
    for (std::size_t v = 0; v < image.label.size(); ++v)
        if (is_one[image.label[v]] && growing.is_inside(v))
            growing.result.region[v] = region;
}

} // namespace

double labelled_volume(const LabelImage &image, const LabelChoice &choice) {
    std::vector<std::string> remarks; // choose_labels() says them
    const auto parts = parts_of_labels(image, choice, remarks);
    const auto voxels = std::ranges::count_if(image.label, [&](std::uint16_t label) {
        const auto part = parts.find(label);
        return part != parts.end() &&
               (part->second.role == SegmentRole::liver || part->second.role == SegmentRole::lesion ||
                part->second.role == SegmentRole::cyst);
    });
    return static_cast<double>(voxels) * voxel_volume(image.grid);
}

std::vector<double> region_volumes(const Segmentation &segmentation) {
    std::vector<double> volumes(segmentation.region_names.size(), 0.0);
    for (const auto region : segmentation.region)
        if (region > 0)
            volumes[region - 1] += voxel_volume(segmentation.grid);
    return volumes;
}

Segmentation choose_labels(const LabelImage &image, const LabelChoice &choice, double tetrahedron) {
    Segmentation result{.grid = image.grid, .region = {}, .region_names = {"parenchyma"}, .remarks = image.remarks};
    const auto parts = parts_of_labels(image, choice, result.remarks);
    const auto body = solid_body(image, body_voxels(image, parts), result.remarks);
    tell_left_out(image, parts, body, result.remarks);
    result.region.assign(body->GetBufferPointer(), body->GetBufferPointer() + num_voxels(image.grid));
    const GrowingBody growing{image, parts, body, tetrahedron, result};
    add_lesions(growing, SegmentRole::lesion, "tumour", "lesions");
    add_lesions(growing, SegmentRole::cyst, "cyst", "cysts");
    add_vessels(growing);
    add_gallbladder(growing);
    if (std::ranges::find(result.region, 1) == result.region.end())
        throw support::InputError("{}: nothing of the liver is left beside its lesions; check --liver and --tumours",
                                  image.name);
    return result;
}

} // namespace livermark::segmentation
