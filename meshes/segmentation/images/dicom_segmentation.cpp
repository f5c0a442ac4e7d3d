#include "meshes/segmentation/images/image_values.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <gdcmAttribute.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <map>
#include <optional>
#include <string>

#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/segmentation/images/image_headers.hpp"

namespace livermark::segmentation {

namespace {

namespace fs = std::filesystem;
using core::Vector3;

constexpr double metres_per_dicom_unit = 1e-3;
constexpr const char *segmentation_storage = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr const char *label_map_storage = "1.2.840.10008.5.1.4.1.1.66.7";

[[noreturn]] void refuse_dicom(const fs::path &file, const std::string &what) {
    throw support::InputError("{}: {}; export it as NIfTI or NRRD, as with 3D Slicer or dcmqi's segimage2itkimage",
                              file.string(), what);
}

/// The first item of a sequence, if it is there.
const gdcm::DataSet *first_item(const gdcm::DataSet *data, const gdcm::Tag &tag,
                                std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>> &keep, std::size_t number = 1) {
    if (!data || !data->FindDataElement(tag))
        return nullptr;
    auto sequence = data->GetDataElement(tag).GetValueAsSQ();
    if (!sequence || sequence->GetNumberOfItems() < number)
        return nullptr;
    keep.push_back(sequence);
    return &sequence->GetItem(number).GetNestedDataSet();
}

/// Numbers of an attribute; none if it is not there.
template <std::uint16_t group, std::uint16_t element> std::vector<double> numbers_of(const gdcm::DataSet *data) {
    gdcm::Attribute<group, element> attribute;
    if (!data || !data->FindDataElement(attribute.GetTag()) || data->GetDataElement(attribute.GetTag()).IsEmpty())
        return {};
    attribute.SetFromDataSet(*data);
    std::vector<double> numbers;
    if constexpr (requires { attribute.GetValue(0U); })
        for (unsigned i = 0; i < attribute.GetNumberOfValues(); ++i)
            numbers.push_back(static_cast<double>(attribute.GetValue(i)));
    else
        numbers.push_back(static_cast<double>(attribute.GetValue()));
    return numbers;
}

std::string text_of(const gdcm::DataSet &data, const gdcm::Tag &tag) {
    if (!data.FindDataElement(tag) || !data.GetDataElement(tag).GetByteValue())
        return {};
    const auto *bytes = data.GetDataElement(tag).GetByteValue();
    return without_padding({bytes->GetPointer(), bytes->GetLength()});
}

/// A slice of a segment.
struct Frame {
    int segment = 0;
    Vector3 position = Vector3::Zero(); ///< centre of the first pixel [mm]
};

/// Data that all frames have in common, and each of them.
struct Frames {
    int rows = 0, columns = 0;
    double row_spacing = 0.0, column_spacing = 0.0, slice_spacing = 0.0; ///< [mm]; the last 0 if it is not said
    Vector3 along_row = Vector3::Zero(), along_column = Vector3::Zero();
    std::vector<Frame> frame;
    bool are_bits = false;     ///< one bit a pixel
    bool are_labels = false;   ///< pixels are numbers of segments
    double least_value = 1.0;  ///< of a pixel in the segment
    int bytes_per_pixel = 1;   ///< where they are no bits
    std::string_view pixels{}; ///< of all frames; belongs to the file
};

/// Data that stand with each frame or with all of them.
class FrameGroups {
  public:
    FrameGroups(const gdcm::DataSet &data, const fs::path &file) : file_(file) {
        shared_ = first_item(&data, gdcm::Tag(0x5200, 0x9229), keep_);
        const gdcm::Tag per_frame(0x5200, 0x9230);
        if (data.FindDataElement(per_frame))
            per_frame_ = data.GetDataElement(per_frame).GetValueAsSQ();
    }

    std::size_t count() const { return per_frame_ ? per_frame_->GetNumberOfItems() : 0; }

    /// The item of a functional group of a frame.
    const gdcm::DataSet *of(std::size_t frame, const gdcm::Tag &group) {
        if (const auto *found = first_item(&per_frame_->GetItem(frame + 1).GetNestedDataSet(), group, keep_))
            return found;
        return first_item(shared_, group, keep_);
    }

    template <std::uint16_t group, std::uint16_t element>
    std::vector<double> numbers(std::size_t frame, const gdcm::Tag &functional_group, std::size_t count,
                                const char *name) {
        auto found = numbers_of<group, element>(of(frame, functional_group));
        if (found.size() != count || !std::ranges::all_of(found, [](double value) { return std::isfinite(value); }))
            refuse_dicom(file_, fmt::format("frame {} has no {}", frame + 1, name));
        return found;
    }

  private:
    const fs::path &file_;
    const gdcm::DataSet *shared_ = nullptr;
    gdcm::SmartPointer<gdcm::SequenceOfItems> per_frame_;
    std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>> keep_;
};

Frames read_frames(const gdcm::DataSet &data, const fs::path &file) {
    Frames frames;
    const auto one = [&](const std::vector<double> &numbers, const char *name) {
        if (numbers.empty() || !(numbers.front() >= 1.0 && numbers.front() <= 65535.0))
            refuse_dicom(file, fmt::format("it has no {}", name));
        return static_cast<int>(numbers.front());
    };
    frames.rows = one(numbers_of<0x0028, 0x0010>(&data), "number of rows");
    frames.columns = one(numbers_of<0x0028, 0x0011>(&data), "number of columns");
    const int bits = one(numbers_of<0x0028, 0x0100>(&data), "number of bits a pixel");
    if (bits != 1 && bits != 8 && bits != 16)
        refuse_dicom(file, fmt::format("it has {} bits a pixel, where 1, 8 and 16 can be read", bits));
    frames.are_bits = bits == 1;
    frames.bytes_per_pixel = bits == 16 ? 2 : 1;
    const auto kind = text_of(data, gdcm::Tag(0x0062, 0x0001));
    frames.are_labels = kind == "LABELMAP";
    if (const auto largest = numbers_of<0x0062, 0x000e>(&data); kind == "FRACTIONAL" && !largest.empty())
        frames.least_value = 0.5 * largest.front();

    FrameGroups groups(data, file);
    if (groups.count() == 0)
        refuse_dicom(file, "it does not say where its frames are");
    const gdcm::Tag measures(0x0028, 0x9110), orientation(0x0020, 0x9116), position(0x0020, 0x9113);
    const auto said = numbers_of<0x0028, 0x0008>(&data);
    const auto most_frames = static_cast<double>(groups.count());
    const auto num_frames =
        static_cast<std::size_t>(said.empty() ? most_frames : std::clamp(said[0], 1.0, most_frames));
    for (std::size_t f = 0; f < num_frames; ++f) {
        const auto spacing = groups.numbers<0x0028, 0x0030>(f, measures, 2, "pixel spacing");
        const auto axes = groups.numbers<0x0020, 0x0037>(f, orientation, 6, "orientation");
        const auto place = groups.numbers<0x0020, 0x0032>(f, position, 3, "position");
        const Vector3 row(axes[0], axes[1], axes[2]), column(axes[3], axes[4], axes[5]);
        if (f == 0) {
            frames.row_spacing = spacing[0];
            frames.column_spacing = spacing[1];
            frames.along_row = row;
            frames.along_column = column;
            if (const auto slices = numbers_of<0x0018, 0x0088>(groups.of(f, measures)); !slices.empty())
                frames.slice_spacing = slices.front();
            else if (const auto thickness = numbers_of<0x0018, 0x0050>(groups.of(f, measures)); !thickness.empty())
                frames.slice_spacing = thickness.front();
        }
        constexpr double rounding = 1e-4;
        if ((row - frames.along_row).norm() > rounding || (column - frames.along_column).norm() > rounding ||
            std::abs(spacing[0] - frames.row_spacing) > rounding ||
            std::abs(spacing[1] - frames.column_spacing) > rounding)
            refuse_dicom(file, fmt::format("frame {} has other axes than the first", f + 1));
        const auto segment = numbers_of<0x0062, 0x000b>(groups.of(f, gdcm::Tag(0x0062, 0x000a)));
        if (!frames.are_labels && segment.empty())
            refuse_dicom(file, fmt::format("frame {} does not say its segment", f + 1));
        frames.frame.push_back(
            {segment.empty() ? 0 : static_cast<int>(segment.front()), {place[0], place[1], place[2]}});
    }

    const gdcm::Tag pixel_data(0x7fe0, 0x0010);
    const auto *bytes = data.FindDataElement(pixel_data) ? data.GetDataElement(pixel_data).GetByteValue() : nullptr;
    if (!bytes)
        refuse_dicom(file, "its pixels are compressed, or not there");
    check_dicom_pixels(file, bytes->GetLength());
    frames.pixels = {bytes->GetPointer(), bytes->GetLength()};
    const double wanted = static_cast<double>(frames.frame.size()) * frames.rows * frames.columns *
                          (frames.are_bits ? 0.125 : frames.bytes_per_pixel);
    if (static_cast<double>(frames.pixels.size()) < wanted)
        refuse_dicom(file,
                     fmt::format("it holds {} bytes of pixels where {:.0f} are said", frames.pixels.size(), wanted));
    return frames;
}

/// The slice that each frame lies in, and the grid of all.
std::vector<int> slices_of(Frames &frames, ImageGrid &grid, const fs::path &file) {
    const Vector3 normal = frames.along_row.cross(frames.along_column);
    std::vector<double> height;
    for (const auto &frame : frames.frame)
        height.push_back(normal.dot(frame.position));
    const auto lowest = std::ranges::min_element(height) - height.begin();
    auto sorted = height;
    std::ranges::sort(sorted);
    constexpr double same = 1e-2; // [mm]
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t f = 1; f < sorted.size(); ++f)
        if (sorted[f] - sorted[f - 1] > same)
            smallest = std::min(smallest, sorted[f] - sorted[f - 1]);
    const double spacing = std::isfinite(smallest) ? smallest : std::max(frames.slice_spacing, same);
    std::vector<int> slices;
    for (std::size_t f = 0; f < height.size(); ++f) {
        const double slice = (height[f] - height[lowest]) / spacing;
        const Vector3 aside = frames.frame[f].position - frames.frame[lowest].position;
        constexpr double most_uneven = 0.05; // of the spacing
        if (std::abs(slice - std::round(slice)) > most_uneven || (aside - normal.dot(aside) * normal).norm() > same)
            refuse_dicom(file, fmt::format("frame {} is not evenly spaced behind the others", f + 1));
        slices.push_back(static_cast<int>(std::round(slice)));
    }
    constexpr int most_slices = 10000;
    const int num_slices = *std::ranges::max_element(slices) + 1;
    if (num_slices > most_slices)
        refuse_dicom(file, fmt::format("its frames are {} slices apart", num_slices));
    grid.size = {frames.columns, frames.rows, num_slices};
    grid.spacing = metres_per_dicom_unit * Vector3(frames.column_spacing, frames.row_spacing, spacing);
    grid.origin = metres_per_dicom_unit * frames.frame[lowest].position;
    grid.direction.col(0) = frames.along_row;
    grid.direction.col(1) = frames.along_column;
    grid.direction.col(2) = normal;
    return slices;
}

int value_at(const Frames &frames, std::size_t pixel) {
    if (frames.are_bits) // packed over the ends of frames, the least bit first
        return (static_cast<unsigned char>(frames.pixels[pixel / 8]) >> (pixel % 8)) & 1;
    if (frames.bytes_per_pixel == 1)
        return static_cast<unsigned char>(frames.pixels[pixel]);
    return static_cast<unsigned char>(frames.pixels[2 * pixel]) |
           static_cast<unsigned char>(frames.pixels[2 * pixel + 1]) << 8;
}

/// Reads the names and codes of the segments, by their numbers.
void read_segments_of(const gdcm::DataSet &data, LabelImage &image) {
    const gdcm::Tag sequence(0x0062, 0x0002), label(0x0062, 0x0005), type(0x0062, 0x000f), region(0x0008, 0x2218),
        value(0x0008, 0x0100), meaning(0x0008, 0x0104);
    if (!data.FindDataElement(sequence))
        return;
    const auto items = data.GetDataElement(sequence).GetValueAsSQ();
    std::vector<gdcm::SmartPointer<gdcm::SequenceOfItems>> keep;
    const auto text_in = [](const gdcm::DataSet *item, const gdcm::Tag &tag) {
        return item ? text_of(*item, tag) : std::string();
    };
    for (std::size_t i = 1; items && i <= items->GetNumberOfItems(); ++i) {
        const auto &segment = items->GetItem(i).GetNestedDataSet();
        const auto numbers = numbers_of<0x0062, 0x0004>(&segment);
        if (numbers.empty())
            continue;
        const int number = static_cast<int>(numbers.front());
        const auto *code = first_item(&segment, type, keep);
        if (code)
            image.label_codes[number] = {.type = text_in(code, value),
                                         .meaning = text_in(code, meaning),
                                         .region = text_in(first_item(&segment, region, keep), meaning)};
        if (const auto name = text_of(segment, label); !name.empty())
            image.label_names.emplace(number, name);
        else if (code)
            image.label_names.emplace(number, image.label_codes[number].meaning);
    }
}

/// Frames of the largest segment first.
std::vector<std::size_t> painting_order(const Frames &frames, std::size_t pixels_per_frame) {
    std::map<int, std::size_t> size;
    for (std::size_t f = 0; f < frames.frame.size(); ++f)
        for (std::size_t p = 0; p < pixels_per_frame; ++p)
            size[frames.frame[f].segment] += value_at(frames, f * pixels_per_frame + p) >= frames.least_value ? 1 : 0;
    std::vector<std::size_t> order(frames.frame.size());
    for (std::size_t f = 0; f < order.size(); ++f)
        order[f] = f;
    std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t f) { return size[frames.frame[f].segment]; });
    return order;
}

} // namespace

std::string without_padding(std::string text) {
    while (!text.empty() && (text.back() == ' ' || text.back() == '\0'))
        text.pop_back();
    return text;
}

bool is_dicom_file(const fs::path &file) {
    std::ifstream stream(file, std::ios::binary);
    std::array<char, 132> start{};
    return stream.read(start.data(), start.size()) && std::string_view(start.data() + 128, 4) == "DICM";
}

bool is_dicom_segmentation(const fs::path &file) {
    gdcm::Reader reader;
    reader.SetFileName(file.c_str());
    const gdcm::Tag sop_class(0x0008, 0x0016);
    if (!is_dicom_file(file) || !reader.ReadUpToTag(gdcm::Tag(0x0008, 0x0020)))
        return false;
    const auto found = text_of(reader.GetFile().GetDataSet(), sop_class);
    return found == segmentation_storage || found == label_map_storage;
}

LabelImage read_dicom_segmentation(const fs::path &file) {
    gdcm::Reader reader;
    reader.SetFileName(file.c_str());
    if (!is_dicom_segmentation(file))
        refuse_dicom(file, "it is DICOM, but no segmentation object; of a series give the folder");
    if (!reader.Read())
        refuse_dicom(file, "it is damaged or cut off");
    auto frames = read_frames(reader.GetFile().GetDataSet(), file);
    LabelImage image{.name = file.filename().string(), .grid = {}, .label = {}};
    const auto slices = slices_of(frames, image.grid, file);
    read_segments_of(reader.GetFile().GetDataSet(), image);
    image.patient_position = text_of(reader.GetFile().GetDataSet(), gdcm::Tag(0x0018, 0x5100));
    constexpr double most_voxels = 1 << 28;
    const auto pixels_per_frame = static_cast<std::size_t>(frames.rows) * static_cast<std::size_t>(frames.columns);
    if (static_cast<double>(pixels_per_frame) * image.grid.size[2] > most_voxels)
        refuse_dicom(file, fmt::format("it has more than {:.3g} voxels", most_voxels));
    image.label.assign(num_voxels(image.grid), 0);
    for (const auto f : painting_order(frames, pixels_per_frame)) {
        auto *slice = image.label.data() + static_cast<std::size_t>(slices[f]) * pixels_per_frame;
        for (std::size_t p = 0; p < pixels_per_frame; ++p)
            if (const int value = value_at(frames, f * pixels_per_frame + p); value >= frames.least_value)
                slice[p] = static_cast<std::uint16_t>(frames.are_labels ? value : frames.frame[f].segment);
    }
    return image;
}

} // namespace livermark::segmentation
