#include "segmentation/images/segmentation.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <itkBinaryFillholeImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkImage.h>
#include <map>
#include <set>

#include "core/mesh/plausible_liver.hpp"
#include "support/input_error.hpp"

namespace livermark::segmentation {

namespace {

using Mask = itk::Image<std::uint8_t, 3>;
using Pieces = itk::Image<std::uint32_t, 3>;

constexpr int max_labels_to_guess = 10;
constexpr std::size_t max_lesions = 254;

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

std::set<int> labels_of(const LabelImage &image) {
    std::vector<bool> is_there(65536, false);
    for (const auto label : image.label)
        is_there[label] = true;
    std::set<int> labels;
    for (int label = 1; label < 65536; ++label)
        if (is_there[static_cast<std::size_t>(label)])
            labels.insert(label);
    return labels;
}

/// Chooses by the names that the file has, if one of them is that of the liver.
bool choose_by_name(LabelChoice &choice, const LabelImage &image, const std::set<int> &there,
                    std::vector<std::string> &remarks) {
    LabelChoice named;
    std::vector<std::string> others;
    for (const int label : there) {
        const auto name = image.label_names.find(label);
        if (name != image.label_names.end() && core::is_name_of_liver(name->second))
            named.liver.push_back(label);
        else if (name != image.label_names.end() && core::is_name_of_lesion(name->second))
            named.tumours.push_back(label);
        else
            others.push_back(name == image.label_names.end() ? fmt::format("{}", label)
                                                             : fmt::format("{} '{}'", label, name->second));
    }
    if (named.liver.empty())
        return false;
    choice = named;
    remarks.push_back(fmt::format("by the names of the segments label {} is the liver{}{}",
                                  fmt::join(named.liver, ", "), named.tumours.empty() ? "" : " and lesions are ",
                                  fmt::join(named.tumours, ", ")));
    constexpr std::size_t most_named = 10;
    if (const auto num_others = others.size(); num_others > most_named) {
        others.resize(most_named);
        others.push_back(fmt::format("{} more", num_others - most_named));
    }
    if (!others.empty())
        remarks.push_back(fmt::format("labels whose names are neither of a liver nor of a lesion are left out: {}; "
                                      "--liver and --tumours may name them",
                                      fmt::join(others, ", ")));
    return true;
}

/// Every label that is meant, from what was said and what is there.
LabelChoice completed(LabelChoice choice, const LabelImage &image, std::vector<std::string> &remarks) {
    const auto there = labels_of(image);
    if (choice.liver.empty() && choice.tumours.empty() && choose_by_name(choice, image, there, remarks))
        return choice;
    if (there.empty())
        throw support::InputError(fmt::format("{}: every voxel is background, so there is no liver in it", image.name));
    for (const auto *labels : {&choice.liver, &choice.tumours})
        for (const int label : *labels)
            if (!there.contains(label))
                throw support::InputError(
                    fmt::format("{}: no voxel has the label {}; it has {}", image.name, label, fmt::join(there, ", ")));
    for (const int label : choice.tumours)
        if (std::ranges::find(choice.liver, label) != choice.liver.end())
            throw support::InputError(fmt::format("label {} cannot be both liver and tumour; name it once", label));
    if (choice.liver.empty()) {
        if (static_cast<int>(there.size()) > max_labels_to_guess)
            throw support::InputError(fmt::format(
                "{}: it has {} labels, more than a liver and its lesions; name them with --liver and --tumours",
                image.name, there.size()));
        const auto first = std::ranges::find_if(
            there, [&](int label) { return std::ranges::find(choice.tumours, label) == choice.tumours.end(); });
        if (first == there.end())
            throw support::InputError(
                fmt::format("{}: every label is a tumour's; name the liver's with --liver", image.name));
        choice.liver = {*first};
        if (choice.tumours.empty())
            std::ranges::copy_if(there, std::back_inserter(choice.tumours), [&](int l) { return l != *first; });
    }
    return choice;
}

std::string millilitres(std::size_t voxels, const ImageGrid &grid) {
    return fmt::format("{:.3g} mL", 1e6 * voxel_volume(grid) * static_cast<double>(voxels));
}

/// The largest piece of the body without its cavities.
Mask::Pointer solid_body(const LabelImage &image, const std::vector<bool> &is_body, std::vector<std::string> &remarks) {
    const auto &grid = image.grid;
    const auto pieces = connected_pieces(mask_where(grid, [&](auto v) { return is_body[image.label[v]]; }));
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

} // namespace

std::vector<double> region_volumes(const Segmentation &segmentation) {
    std::vector<double> volumes(segmentation.region_names.size(), 0.0);
    for (const auto region : segmentation.region)
        if (region > 0)
            volumes[region - 1] += voxel_volume(segmentation.grid);
    return volumes;
}

Segmentation choose_labels(const LabelImage &image, const LabelChoice &choice, double smallest_lesion) {
    Segmentation result{.grid = image.grid, .region = {}, .region_names = {"parenchyma"}, .remarks = image.remarks};
    const auto labels = completed(choice, image, result.remarks);
    std::vector<bool> is_body(65536, false);
    for (const auto *kind : {&labels.liver, &labels.tumours})
        for (const int label : *kind)
            is_body[static_cast<std::size_t>(label)] = true;
    const auto body = solid_body(image, is_body, result.remarks);
    result.region.assign(body->GetBufferPointer(), body->GetBufferPointer() + num_voxels(image.grid));

    std::size_t num_small = 0, small_voxels = 0;
    for (const auto &lesion : lesions_of(image, labels.tumours, body)) {
        if (static_cast<double>(lesion.voxels.size()) * voxel_volume(image.grid) < smallest_lesion) {
            ++num_small;
            small_voxels += lesion.voxels.size();
            continue;
        }
        const auto number = result.region_names.size();
        if (number > max_lesions)
            throw support::InputError(fmt::format(
                "{}: there are more than {} lesions; name fewer labels with --tumours", image.name, max_lesions));
        result.region_names.push_back(fmt::format("tumour_{}", number));
        result.remarks.push_back(fmt::format("tumour_{}: {} of label {}", number,
                                             millilitres(lesion.voxels.size(), image.grid), lesion.label));
        for (const auto voxel : lesion.voxels)
            result.region[voxel] = static_cast<std::uint8_t>(number + 1);
    }
    if (num_small > 0)
        result.remarks.push_back(fmt::format("{} lesions below {:.2g} mL, {} in all, become parenchyma; more "
                                             "tetrahedra would resolve smaller ones",
                                             num_small, 1e6 * smallest_lesion, millilitres(small_voxels, image.grid)));
    if (std::ranges::find(result.region, 1) == result.region.end())
        throw support::InputError(fmt::format("{}: nothing of the liver is left beside its lesions; check --liver and "
                                              "--tumours",
                                              image.name));
    return result;
}

} // namespace livermark::segmentation
