#include "meshes/segmentation/images/segmentation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <itkBinaryFillholeImageFilter.h>
#include <itkConnectedComponentImageFilter.h>
#include <itkImage.h>
#include <map>
#include <numbers>
#include <random>
#include <span>

#include "core/support/input_error.hpp"
#include "meshes/generators/liver_shape.hpp"

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

using core::Vector3;

constexpr double margin = 0.01; // of air around the liver [m]
constexpr double liver_value = 110.0, lesion_value = 70.0, fat_value = -90.0, noise = 12.0; // [HU]

Eigen::Matrix3d rotation(const Vector3 &turn) {
    const double angle = turn.norm();
    return angle == 0.0 ? Eigen::Matrix3d::Identity().eval()
                        : Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

/// The smallest grid of these axes that holds the liver.
ImageGrid grid_around_liver(const PhantomOptions &options) {
    ImageGrid grid{.spacing = options.spacing, .direction = rotation(options.turn)};
    const auto [low, high] = meshes::liver_bounding_box();
    const Eigen::AlignedBox3d liver(low, high);
    Eigen::AlignedBox3d along; // the axes of the grid
    for (int corner = 0; corner < 8; ++corner) {
        const Vector3 point = liver.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
        along.extend(Vector3(grid.direction.transpose() * point));
    }
    const Vector3 first = along.min().array() - margin;
    const Vector3 last = along.max().array() + margin;
    grid.origin = grid.direction * first;
    for (int d = 0; d < 3; ++d)
        grid.size[static_cast<std::size_t>(d)] =
            1 + static_cast<int>(std::ceil((last[d] - first[d]) / grid.spacing[d]));
    return grid;
}

std::vector<meshes::Lesion> lesions(bool touching) {
    auto all = meshes::liver_lesions();
    if (touching) {
        auto &outer = all[1];
        while (meshes::liver_level(outer.center) < -0.5 * outer.semi_axes.minCoeff())
            outer.center += 1e-3 * meshes::liver_gradient(outer.center).normalized();
        auto &neighbour = all[4];
        const Vector3 apart = neighbour.center - all[0].center;
        neighbour.center =
            all[0].center + (all[0].semi_axes.mean() + 0.8 * neighbour.semi_axes.mean()) * apart.normalized();
    }
    return all;
}

bool holds(const meshes::Lesion &lesion, const Vector3 &point) {
    Vector3 scaled;
    for (int d = 0; d < 3; ++d)
        scaled[d] = lesion.axes[static_cast<std::size_t>(d)].dot(point - lesion.center) / lesion.semi_axes[d];
    return scaled.squaredNorm() < 1.0;
}

/// @return label at a place in the world
int label_at(const Vector3 &point, const std::vector<meshes::Lesion> &all) {
    if (meshes::liver_level(point) >= 0.0)
        return 0;
    for (std::size_t l = 0; l < all.size(); ++l)
        if (holds(all[l], point))
            return phantom_first_tumour_label + static_cast<int>(l);
    return phantom_liver_label;
}

/// Calls visit(voxel, its centre in the world) in the order of the data.
template <class Visit> void for_each_voxel(const ImageGrid &grid, const Visit &visit) {
    std::size_t voxel = 0;
    for (int k = 0; k < grid.size[2]; ++k)
        for (int j = 0; j < grid.size[1]; ++j)
            for (int i = 0; i < grid.size[0]; ++i)
                visit(voxel++, to_world(grid, Vector3(i, j, k).cwiseProduct(grid.spacing)));
}

} // namespace

LabelImage phantom_labels(const PhantomOptions &options) {
    const auto all = lesions(options.touching);
    LabelImage image{.name = "phantom", .grid = grid_around_liver(options), .label = {}};
    image.label.resize(num_voxels(image.grid));
    for_each_voxel(image.grid, [&](std::size_t voxel, const Vector3 &centre) {
        image.label[voxel] = static_cast<std::uint16_t>(label_at(centre, all));
    });
    return image;
}

Scan phantom_scan(const PhantomOptions &options) {
    const auto all = lesions(options.touching);
    Scan scan{.grid = grid_around_liver(options), .grey_value = {}};
    scan.grey_value.resize(num_voxels(scan.grid));
    std::mt19937 random(1);
    for_each_voxel(scan.grid, [&](std::size_t voxel, const Vector3 &centre) {
        double value = 0.0;
        for (int part = 0; part < 8; ++part) { // a voxel shows the mean of what is in it
            const Vector3 place((part & 1) - 0.5, (part >> 1 & 1) - 0.5, (part >> 2) - 0.5);
            const int label =
                label_at(centre + scan.grid.direction * (0.5 * place.cwiseProduct(scan.grid.spacing)), all);
            value += (label == 0 ? fat_value : label == phantom_liver_label ? liver_value : lesion_value) / 8.0;
        }
        // Twelve uniform numbers add up to a normal one of variance 1, the same with every standard library.
        double normal = -6.0;
        for (int part = 0; part < 12; ++part)
            normal += static_cast<double>(random()) / 4294967296.0;
        scan.grey_value[voxel] = static_cast<std::int16_t>(std::lround(value + noise * normal));
    });
    return scan;
}

Scan phantom_stiffness(const PhantomOptions &options) {
    constexpr double young_over_shear = 2.9; // at Poisson's ratio 0.45
    struct Wave {
        Vector3 along;
        double length, phase; ///< [m], [rad]
    };
    const std::array<Wave, 3> waves{
        {{{1.0, 0.3, 0.2}, 0.095, 0.3}, {{-0.2, 1.0, 0.4}, 0.075, 1.9}, {{0.3, -0.4, 1.0}, 0.060, 4.1}}};
    const auto all = lesions(options.touching);
    Scan scan{.grid = grid_around_liver(options), .grey_value = {}};
    scan.grey_value.resize(num_voxels(scan.grid));
    for_each_voxel(scan.grid, [&](std::size_t voxel, const Vector3 &centre) {
        const int label = label_at(centre, all);
        double exponent = 0.0;
        for (const auto &[along, length, phase] : waves)
            exponent += 0.2 * std::cos(2.0 * std::numbers::pi / length * along.normalized().dot(centre) + phase);
        const double young_modulus = label == 0 ? 0.0 : label == phantom_liver_label ? 5e3 * std::exp(exponent) : 50e3;
        scan.grey_value[voxel] = static_cast<std::int16_t>(std::lround(young_modulus / young_over_shear));
    });
    return scan;
}

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

/// Labels that voxels have, but for the background, in ascending order.
std::vector<int> labels_of(const LabelImage &image) {
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

/// A sentence for each label whose code decides against its name.
void tell_of_codes(const LabelImage &image, std::vector<std::string> &remarks) {
    using core::SegmentRole;
    for (const auto &[label, code] : image.label_codes) {
        const auto name = image.label_names.find(label);
        if (name == image.label_names.end())
            continue;
        const auto by_name = core::role_of_name(name->second), by_code = core::role_of_segment(name->second, code);
        if (by_name != by_code && by_name != SegmentRole::unnamed && by_name != SegmentRole::other)
            remarks.push_back(fmt::format("label {} is '{}' by its code, {}, and so it counts; --liver and --tumours "
                                          "choose otherwise",
                                          shown_label(image, label), support::shown(code.meaning),
                                          support::shown(code.type)));
    }
}

/// The lowest label that no tumour has.
int guessed_liver(const LabelImage &image, const std::vector<int> &there, const std::vector<int> &tumours) {
    if (static_cast<int>(there.size()) > max_labels_to_guess)
        throw support::InputError(
            "{}: it has {} labels, more than a liver and its lesions; name them with --liver and --tumours", image.name,
            there.size());
    const auto first =
        std::ranges::find_if(there, [&](int label) { return std::ranges::find(tumours, label) == tumours.end(); });
    if (first == there.end())
        throw support::InputError("{}: every label is a tumour's; name the liver's with --liver", image.name);
    return *first;
}

/// Chooses by codes and names, or by numbers where the file has no names.
LabelChoice chosen_by_file(const LabelImage &image, const std::vector<int> &there, const std::vector<int> &tumours,
                           std::vector<std::string> &remarks) {
    auto roles = labels_by_role(image);
    LabelChoice choice{roles[core::SegmentRole::liver], tumours.empty() ? roles[core::SegmentRole::lesion] : tumours};
    std::erase_if(choice.liver, [&](int label) { return std::ranges::find(tumours, label) != tumours.end(); });
    if (!choice.liver.empty()) {
        remarks.push_back(fmt::format("by the names of the segments label {} is the liver{}{}",
                                      fmt::join(choice.liver, ", "), choice.tumours.empty() ? "" : " and lesions are ",
                                      fmt::join(choice.tumours, ", ")));
        tell_of_codes(image, remarks);
        return choice;
    }
    if (roles[core::SegmentRole::unnamed].size() < there.size())
        throw support::InputError("{}: none of its segments is a liver by its name: {}; if one is, give its label to "
                                  "`livermark mesh --labels` with --liver",
                                  image.name, shown_labels(image, there));
    choice.liver = {guessed_liver(image, there, tumours)};
    if (tumours.empty())
        std::ranges::copy_if(there, std::back_inserter(choice.tumours), [&](int l) { return l != choice.liver[0]; });
    if (there.size() > 1)
        remarks.push_back(
            fmt::format("the file does not name its labels, so {}, the lowest, is taken for the liver and "
                        "{} for lesions; vessels and other organs among them have to be left out with "
                        "--liver and --tumours",
                        choice.liver[0], fmt::join(choice.tumours, ", ")));
    return choice;
}

/// Every label that is meant, from what was said and what is there.
LabelChoice completed(const LabelChoice &choice, const LabelImage &image, std::vector<std::string> &remarks) {
    const auto there = labels_of(image);
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
    return choice.liver.empty() ? chosen_by_file(image, there, choice.tumours, remarks) : choice;
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

/// Adds remarks on the labels that are no part of the body.
void tell_left_out(const LabelImage &image, const LabelChoice &choice, const Mask::Pointer &body,
                   std::vector<std::string> &remarks) {
    const auto roles = labels_by_role(image);
    std::vector<int> vessels, others;
    for (const int label : labels_of(image)) {
        const auto is_in = [&](const std::vector<int> &labels) {
            return std::ranges::find(labels, label) != labels.end();
        };
        const auto vessel = roles.find(core::SegmentRole::vessel);
        if (!is_in(choice.liver) && !is_in(choice.tumours))
            (vessel != roles.end() && is_in(vessel->second) ? vessels : others).push_back(label);
    }
    const auto tell = [&](const std::vector<int> &labels, const std::string &what) {
        std::vector<bool> is_meant(65536, false);
        for (const int label : labels)
            is_meant[static_cast<std::size_t>(label)] = true;
        std::size_t inside = 0, outside = 0;
        for (std::size_t v = 0; v < image.label.size(); ++v)
            if (is_meant[image.label[v]])
                ++(body->GetBufferPointer()[v] == 1 ? inside : outside);
        remarks.push_back(fmt::format("{} are left out: {}; {} of them that the liver encloses become parenchyma, {} "
                                      "are holes in it or lie outside",
                                      what, shown_labels(image, labels), millilitres(inside, image.grid),
                                      millilitres(outside, image.grid)));
    };
    if (!vessels.empty())
        tell(vessels, "vessels and ducts have no region of their own and");
    if (!others.empty())
        tell(others, "labels that are neither the liver's nor a lesion's");
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

std::map<core::SegmentRole, std::vector<int>> labels_by_role(const LabelImage &image) {
    std::map<core::SegmentRole, std::vector<int>> roles;
    for (const int label : labels_of(image)) {
        const auto name = image.label_names.find(label);
        const auto code = image.label_codes.find(label);
        roles[core::role_of_segment(name == image.label_names.end() ? "" : name->second,
                                    code == image.label_codes.end() ? core::SegmentCode{} : code->second)]
            .push_back(label);
    }
    return roles;
}

double labelled_volume(const LabelImage &image, const LabelChoice &choice) {
    std::vector<int> liver = choice.liver, lesions = choice.tumours;
    if (auto roles = labels_by_role(image); liver.empty() && !roles[core::SegmentRole::liver].empty()) {
        liver = roles[core::SegmentRole::liver];
        if (lesions.empty())
            lesions = roles[core::SegmentRole::lesion];
    } else if (liver.empty()) {
        liver = labels_of(image);
    }
    std::vector<bool> counts(65536, false);
    for (const auto *labels : {&liver, &lesions})
        for (const int label : *labels)
            if (label > 0 && label < 65536)
                counts[static_cast<std::size_t>(label)] = true;
    const auto voxels = std::ranges::count_if(image.label, [&](std::uint16_t label) -> bool { return counts[label]; });
    return static_cast<double>(voxels) * voxel_volume(image.grid);
}

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
    tell_left_out(image, labels, body, result.remarks);
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
            throw support::InputError("{}: there are more than {} lesions; name fewer labels with --tumours",
                                      image.name, max_lesions);
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
        throw support::InputError("{}: nothing of the liver is left beside its lesions; check --liver and --tumours",
                                  image.name);
    return result;
}

} // namespace livermark::segmentation
