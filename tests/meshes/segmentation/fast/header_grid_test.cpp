#include "meshes/segmentation/images/image_headers.hpp"

#include <Eigen/Geometry>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>

#include "core/support/input_error.hpp"
#include "meshes/segmentation/images/segmentation.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

/// Places of voxels that ITK gets wrong, or cannot know.
namespace livermark::segmentation {
namespace {

using core::Vector3;

class HeaderOfAnImage : public tests::ResultFolder {
  protected:
    void expect_refused(const std::string &name, const std::string &bytes, const std::string &part) const {
        tests::expect_input_error([&] { read_label_image(written(name, bytes)); }, {part});
    }
    bool is_said(const LabelImage &image, const std::string &what) const {
        return std::ranges::any_of(image.remarks, [&](const auto &r) { return r.find(what) != std::string::npos; });
    }
};

/// 2 x 3 x 4 voxels of 2 x 3 x 4 mm that are turned, far from the scanner's centre.
ImageGrid turned_grid() {
    ImageGrid grid{.size = {2, 3, 4}, .spacing = {2e-3, 3e-3, 4e-3}, .origin = {-0.1, 0.05, 0.025}};
    grid.direction = Eigen::AngleAxisd(0.4, Vector3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    return grid;
}

void expect_grid(const ImageGrid &grid, const ImageGrid &expected) {
    EXPECT_EQ(grid.size, expected.size);
    EXPECT_LT((grid.spacing - expected.spacing).norm(), 1e-8) << grid.spacing.transpose();
    EXPECT_LT((grid.origin - expected.origin).norm(), 1e-7) << grid.origin.transpose();
    EXPECT_LT((grid.direction - expected.direction).norm(), 1e-5) << grid.direction;
}

template <class Number> void put(std::string &bytes, std::size_t at, Number number) {
    std::memcpy(bytes.data() + at, &number, sizeof number);
}

/// Labels of 24 voxels in bytes.
std::string labels() {
    std::string bytes(24, '\0');
    for (std::size_t v = 0; v < bytes.size(); ++v)
        bytes[v] = static_cast<char>(v % 3);
    return bytes;
}

/// Axes of a grid in NIfTI: RAS, and lengths in a unit.
struct Forms {
    Eigen::Matrix3d axes;
    Vector3 origin;
    Eigen::Quaterniond quaternion;
};
Forms forms_of(const ImageGrid &grid, double units_per_metre) {
    const Eigen::DiagonalMatrix<double, 3> to_ras(-1.0, -1.0, 1.0);
    const Eigen::Matrix3d axes = to_ras * grid.direction;
    return {units_per_metre * axes * grid.spacing.asDiagonal(), units_per_metre * (to_ras * grid.origin),
            Eigen::Quaterniond(axes)};
}

/// @param unit  code of the unit in the header
std::string nifti_1(const ImageGrid &grid, int unit, double units_per_metre) {
    std::string header(352, '\0');
    const auto forms = forms_of(grid, units_per_metre);
    const auto put_float = [&](std::size_t at, double number) { put(header, at, static_cast<float>(number)); };
    put<std::int32_t>(header, 0, 348);
    put<std::int16_t>(header, 40, 3);
    put_float(76, 1.0);
    put<std::int16_t>(header, 70, 2);
    put<std::int16_t>(header, 72, 8);
    put_float(108, 352.0);
    header[123] = static_cast<char>(unit | 8); // seconds
    put<std::int16_t>(header, 252, 1);
    put<std::int16_t>(header, 254, 1);
    const auto quaternion = forms.quaternion.w() < 0.0 ? -forms.quaternion.coeffs() : forms.quaternion.coeffs();
    for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<Eigen::Index>(a);
        put<std::int16_t>(header, 42 + 2 * a, static_cast<std::int16_t>(grid.size.at(a)));
        put_float(80 + 4 * a, units_per_metre * grid.spacing[axis]);
        put_float(256 + 4 * a, quaternion[axis]);
        put_float(268 + 4 * a, forms.origin[axis]);
        put_float(280 + 16 * a + 12, forms.origin[axis]);
        for (std::size_t c = 0; c < 3; ++c)
            put_float(280 + 16 * a + 4 * c, forms.axes(axis, static_cast<Eigen::Index>(c)));
    }
    std::memcpy(header.data() + 344, "n+1", 4);
    return header + labels();
}

TEST_F(HeaderOfAnImage, OfNiftiMayBeInAnyUnit) {
    for (const auto &[unit, units_per_metre] : {std::pair{0, 1e3}, {2, 1e3}, {1, 1.0}, {3, 1e6}}) {
        SCOPED_TRACE(unit);
        auto bytes = nifti_1(turned_grid(), unit, units_per_metre);
        auto image = read_label_image(written("a.nii", bytes));
        expect_grid(image.grid, turned_grid());
        EXPECT_EQ(image.label[4], 1);
        if (units_per_metre == 1e3)
            EXPECT_TRUE(image.remarks.empty()) << image.remarks[0];
        else
            EXPECT_TRUE(is_said(image, "origin of the image is what its header says"));
        put<std::int16_t>(bytes, 254, 0); // the qform alone
        expect_grid(read_label_image(written("b.nii", bytes)).grid, turned_grid());
    }
}

TEST_F(HeaderOfAnImage, WhoseFormsMirrorEachOtherIsRefused) {
    auto bytes = nifti_1(turned_grid(), 2, 1e3);
    for (std::size_t c = 0; c < 3; ++c) { // of the sform, left and right
        float number = 0.0F;
        std::memcpy(&number, bytes.data() + 280 + 4 * c, sizeof number);
        put(bytes, 280 + 4 * c, -number);
    }
    expect_refused("a.nii", bytes, "left and right may be exchanged");
    put<std::int16_t>(bytes, 252, 0);
    EXPECT_NO_THROW(read_label_image(written("a.nii", bytes))) << "one form cannot contradict itself";
}

TEST_F(HeaderOfAnImage, WithoutAxesIsReadAndSaysSo) {
    auto bytes = nifti_1({.size = {2, 3, 4}, .spacing = {2e-3, 3e-3, 4e-3}}, 2, 1e3);
    put<std::int32_t>(bytes, 252, 0); // both codes
    EXPECT_TRUE(is_said(read_label_image(written("a.nii", bytes)), "does not say how the image lies in the patient"));
}

/// The same header with the wider fields of the second version.
std::string nifti_2(const ImageGrid &grid, const char *magic) {
    std::string header(544, '\0');
    const auto forms = forms_of(grid, 1e3);
    put<std::int32_t>(header, 0, 540);
    std::memcpy(header.data() + 4, magic, 3);
    put<std::int16_t>(header, 12, 2);
    put<std::int16_t>(header, 14, 8);
    put<std::int64_t>(header, 16, 3);
    put(header, 104, 1.0);
    put<std::int64_t>(header, 168, magic[1] == '+' ? 544 : 0);
    put<std::int32_t>(header, 348, 1);
    put<std::int32_t>(header, 500, 2);
    for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<Eigen::Index>(a);
        put<std::int64_t>(header, 24 + 8 * a, grid.size.at(a));
        put(header, 112 + 8 * a, 1e3 * grid.spacing[axis]);
        put(header, 400 + 32 * a + 24, forms.origin[axis]);
        for (std::size_t c = 0; c < 3; ++c)
            put(header, 400 + 32 * a + 8 * c, forms.axes(axis, static_cast<Eigen::Index>(c)));
    }
    return header;
}

TEST_F(HeaderOfAnImage, MayBeOfTheSecondVersionOfNifti) {
    written("b.img", labels());
    for (const auto &[name, bytes] :
         {std::pair{"a.nii", nifti_2(turned_grid(), "n+2") + labels()}, {"b.hdr", nifti_2(turned_grid(), "ni2")}}) {
        SCOPED_TRACE(name);
        const auto image = read_label_image(written(name, bytes));
        expect_grid(image.grid, turned_grid());
        EXPECT_EQ(image.label[4], 1);
    }
    auto wide = nifti_2(turned_grid(), "n+2") + labels();
    put<std::int64_t>(wide, 24, 1 << 20);
    expect_refused("c.nii", wide, "c.nii: its header speaks of 1048576 voxels along an axis");
}

std::string nrrd(const std::string &space, const std::string &more = "", double units = 1.0) {
    return fmt::format("NRRD0004\ntype: uint8\ndimension: 3\n{}\nsizes: 2 2 2\n"
                       "space directions: ({},0,0) (0,{},0) (0,0,{})\nspace origin: ({},{},{})\nencoding: ascii\n{}\n"
                       "1 0 0 0 0 0 0 0\n",
                       space, 2 * units, 3 * units, 4 * units, 10 * units, 20 * units, 30 * units, more);
}

TEST_F(HeaderOfAnImage, OfNrrdSaysItsSpaceInManyWords) {
    for (const auto &[space, signs] : {std::pair{"left-posterior-superior", Vector3(1, 1, 1)},
                                       {"LPS", Vector3(1, 1, 1)},
                                       {"right-anterior-superior", Vector3(-1, -1, 1)},
                                       {"RAS", Vector3(-1, -1, 1)},
                                       {"left-anterior-superior", Vector3(1, -1, 1)},
                                       {"LAS", Vector3(1, -1, 1)},
                                       {"Left anterior superior", Vector3(1, -1, 1)}}) {
        SCOPED_TRACE(space);
        const auto image = read_label_image(written("a.nrrd", nrrd(std::string("space: ") + space)));
        EXPECT_LT((to_world(image.grid, {0, 0, 0}) - signs.cwiseProduct(Vector3(0.010, 0.020, 0.030))).norm(), 1e-9);
        EXPECT_LT(
            (to_world(image.grid, {0.002, 0.003, 0.004}) - signs.cwiseProduct(Vector3(0.012, 0.023, 0.034))).norm(),
            1e-9);
    }
}

TEST_F(HeaderOfAnImage, OfNrrdMayHaveATime) {
    const auto image = read_label_image(
        written("a.nrrd", "NRRD0004\ntype: uint8\ndimension: 4\nspace: right-anterior-superior-time\nsizes: 2 2 2 1\n"
                          "space directions: (2,0,0,0) (0,3,0,0) (0,0,4,0) (0,0,0,1)\n"
                          "kinds: domain domain domain time\nspace origin: (10,20,30,0)\nencoding: ascii\n\n"
                          "1 0 0 0 0 0 0 0\n"));
    EXPECT_LT((to_world(image.grid, {0.002, 0.003, 0.004}) - Vector3(-0.012, -0.023, 0.034)).norm(), 1e-9);
}

TEST_F(HeaderOfAnImage, OfNrrdWithoutAnatomyIsTakenForLpsAndSaysSo) {
    for (const char *space : {"space: scanner-xyz", "space: 3D-right-handed", "space dimension: 3"}) {
        SCOPED_TRACE(space);
        const auto image = read_label_image(written("a.nrrd", nrrd(space)));
        EXPECT_TRUE(image.grid.direction.isIdentity(1e-9));
        EXPECT_TRUE(is_said(image, "look at the patches"));
    }
    expect_refused("a.nrrd", nrrd("space: 3D-left-handed"), "would mirror the body");
}

TEST_F(HeaderOfAnImage, OfNrrdMayHaveUnits) {
    for (const auto &[unit, per_millimetre] : {std::pair{"\"um\" \"um\" \"um\"", 1e3},
                                               {"\"microns\" \"microns\" \"microns\"", 1e3},
                                               {"\"m\" \"m\" \"m\"", 1e-3},
                                               {"\"cm\" \"cm\" \"cm\"", 0.1},
                                               {"\"mm\" \"mm\" \"mm\"", 1.0}}) {
        SCOPED_TRACE(unit);
        const auto image = read_label_image(written(
            "a.nrrd", nrrd("space: left-posterior-superior", fmt::format("space units: {}\n", unit), per_millimetre)));
        EXPECT_LT((image.grid.spacing - Vector3(0.002, 0.003, 0.004)).norm(), 1e-9);
        EXPECT_LT((image.grid.origin - Vector3(0.010, 0.020, 0.030)).norm(), 1e-9);
    }
    expect_refused("a.nrrd", nrrd("space: LPS", "space units: \"mm\" \"furlong\" \"mm\"\n"), "'furlong'");
}

TEST_F(HeaderOfAnImage, OfMetaImageMayHaveUnits) {
    for (const auto &[unit, per_millimetre] : {std::pair{"mm", 1.0}, {"um", 1e3}, {"cm", 0.1}, {"?", 1.0}, {"", 1.0}}) {
        SCOPED_TRACE(unit);
        const auto units = *unit == '\0' ? std::string() : fmt::format("DistanceUnits = {}\n", unit);
        const auto image = read_label_image(written(
            "a.mha", fmt::format("ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 0 1 0 -1 0 0 0 0 "
                                 "1\nOffset = {} {} {}\n{}DimSize = 2 2 2\nElementSpacing = {} {} {}\n"
                                 "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
                                 10 * per_millimetre, 20 * per_millimetre, 30 * per_millimetre, units,
                                 2 * per_millimetre, 3 * per_millimetre, 4 * per_millimetre) +
                         std::string(8, '\1')));
        EXPECT_LT((to_world(image.grid, {0, 0, 0}) - Vector3(0.010, 0.020, 0.030)).norm(), 1e-9);
        EXPECT_LT((to_world(image.grid, {0.002, 0.003, 0.004}) - Vector3(0.007, 0.022, 0.034)).norm(), 1e-9);
    }
}

} // namespace
} // namespace livermark::segmentation
