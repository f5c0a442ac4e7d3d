#include <gtest/gtest.h>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/support/input_error.hpp"
#include "meshes/segmentation/images/segmentation.hpp"
#include "meshes/segmentation/images/voxel_shapes.hpp"
#include "tests/bad_input.hpp"

namespace livermark::segmentation {
namespace {

constexpr int edge = 12;
constexpr double voxel = 1e-9; // [m^3]

std::size_t at(int i, int j, int k) {
    return static_cast<std::size_t>(i + edge * (j + edge * k));
}

/// A block of label 1 from 2 to 8 along each axis, in voxels of a millimetre.
LabelImage block() {
    LabelImage image{.name = "block", .grid = {.size = {edge, edge, edge}, .spacing = {1e-3, 1e-3, 1e-3}}, .label = {}};
    image.label.assign(num_voxels(image.grid), 0);
    for (int k = 2; k < 9; ++k)
        for (int j = 2; j < 9; ++j)
            for (int i = 2; i < 9; ++i)
                image.label[at(i, j, k)] = 1;
    return image;
}

bool is_said(const Segmentation &segmentation, const std::string &what) {
    return std::ranges::any_of(segmentation.remarks,
                               [&](const auto &remark) { return remark.find(what) != std::string::npos; });
}

TEST(ChooseLabels, TakesTheLowestLabelForTheLiverAndTheOthersForTumours) {
    auto image = block();
    image.label[at(4, 4, 4)] = image.label[at(5, 4, 4)] = 7;
    image.label[at(6, 6, 6)] = 3;
    const auto chosen = choose_labels(image, {}, 0.0);
    EXPECT_EQ(chosen.region_names, (std::vector<std::string>{"parenchyma", "tumour_1", "tumour_2"}));
    const auto volumes = region_volumes(chosen);
    EXPECT_NEAR(volumes[0], 340 * voxel, 1e-15);
    EXPECT_NEAR(volumes[1], 2 * voxel, 1e-15) << "the largest lesion first";
    EXPECT_NEAR(volumes[2], 1 * voxel, 1e-15);
}

TEST(ChooseLabels, PiecesOfOneLabelAreLesionsOfTheirOwn) {
    auto image = block();
    image.label[at(3, 3, 3)] = image.label[at(4, 4, 3)] = 2; // they touch in an edge only
    EXPECT_EQ(choose_labels(image, {}, 0.0).region_names.size(), 3u);
}

TEST(ChooseLabels, IslandsAreLeftOutAndSaid) {
    auto image = block();
    image.label[at(11, 11, 11)] = 1;
    image.label[at(9, 9, 9)] = 2; // touches the block in a corner
    const auto chosen = choose_labels(image, {}, 0.0);
    EXPECT_EQ(chosen.region[at(11, 11, 11)], 0);
    EXPECT_EQ(chosen.region[at(9, 9, 9)], 0);
    EXPECT_TRUE(is_said(chosen, "2 pieces of 0.002 mL"));
}

TEST(ChooseLabels, CavitiesAreFilledAndSaid) {
    auto image = block();
    image.label[at(5, 5, 5)] = 0;
    const auto chosen = choose_labels(image, {}, 0.0);
    EXPECT_EQ(chosen.region[at(5, 5, 5)], 1);
    EXPECT_TRUE(is_said(chosen, "cavities of 0.001 mL"));
}

TEST(ChooseLabels, LesionsThatTheMeshCannotHoldBecomeParenchymaAndAreSaid) {
    auto image = block();
    image.label[at(4, 4, 4)] = 2;
    image.label[at(6, 6, 6)] = image.label[at(7, 6, 6)] = 2;
    const auto chosen = choose_labels(image, {}, 1.5 * voxel);
    EXPECT_EQ(chosen.region_names.size(), 2u);
    EXPECT_EQ(chosen.region[at(4, 4, 4)], 1);
    EXPECT_TRUE(is_said(chosen, "1 lesions below"));
}

TEST(ChooseLabels, NamesOfSegmentsSayWhatIsTheLiver) {
    auto image = block();
    for (auto &label : image.label)
        label = label == 1 ? 2 : 0;
    image.label[at(4, 4, 4)] = 1;
    image.label[at(6, 6, 6)] = 3;
    image.label_names = {{1, "Tumor"}, {2, "Liver"}, {3, "Vena cava"}};
    const auto chosen = choose_labels(image, {}, 0.0);
    EXPECT_EQ(chosen.region_names, (std::vector<std::string>{"parenchyma", "tumour_1"}));
    EXPECT_EQ(chosen.region[at(4, 4, 4)], 2);
    EXPECT_TRUE(is_said(chosen, "label 2 is the liver and lesions are 1"));
    EXPECT_TRUE(is_said(chosen, "are left out: 3 'Vena cava'"));
    image.label_names = {{1, "Segment_1"}};
    EXPECT_EQ(choose_labels(image, {}, 0.0).region[at(4, 4, 4)], 1) << "without a name that says it the lowest label";
}

void expect_refused(const LabelImage &image, const std::string &part) {
    tests::expect_input_error([&] { choose_labels(image, {}, 0.0); }, {part});
}

TEST(ChooseLabels, NamesOfWhichNoneIsALiversAreRefusedAndListed) {
    auto image = block();
    image.label[at(4, 4, 4)] = 2;
    for (const auto &[first, second] : {std::pair{"stomach", "gallbladder"},
                                        {"liver_vessels", "liver_tumor"},
                                        {"Liver bed", "Segment_2"},
                                        {"Non-liver", ""}}) {
        image.label_names = {{1, first}, {2, second}};
        expect_refused(image, std::string("none of its segments is a liver by its name: 1 '") + first);
    }
    EXPECT_EQ(choose_labels(image, {.liver = {1}, .tumours = {2}}, 0.0).region_names.size(), 2u) << "numbers decide";
}

TEST(ChooseLabels, CodesSayWhatIsALesion) {
    auto image = block();
    image.label[at(4, 4, 4)] = 2;
    image.label[at(6, 6, 6)] = 3;
    image.label_names = {{1, "Liver"}, {2, "green"}, {3, "Tumour"}};
    image.label_codes = {{2, {.type = "108369006", .meaning = "Neoplasm"}},
                         {3, {.type = "8993003", .meaning = "Hepatic vein"}}};
    const auto chosen = choose_labels(image, {}, 0.0);
    EXPECT_EQ(chosen.region[at(4, 4, 4)], 2);
    EXPECT_EQ(chosen.region_names, (std::vector<std::string>{"parenchyma", "tumour_1", "vessel_hepatic"}));
    EXPECT_EQ(chosen.region[at(6, 6, 6)], 3);
    EXPECT_TRUE(is_said(chosen, "label 3 'Tumour' is 'Hepatic vein' by its code, 8993003"));
}

/// A tube of a name along the first axis, from inside the block of a liver out of it.
LabelImage block_with_tube(const std::string &name) {
    auto image = block();
    image.label_names = {{1, "Liver"}, {2, name}, {3, "spleen"}};
    for (int i = 4; i < 12; ++i)
        for (int j = 4; j < 7; ++j)
            for (int k = 4; k < 7; ++k)
                image.label[at(i, j, k)] = 2;
    image.label[at(3, 3, 3)] = 2; // a thin one
    image.label[at(0, 0, 0)] = 3;
    return image;
}

/// Volume of a tetrahedron [m^3] of whose edges so many millimetres are one and a half.
double tetrahedron_for(double thickness) {
    const double edge = 1e-3 * thickness / edges_across_vessel;
    return edge * edge * edge / (6.0 * std::numbers::sqrt2);
}

TEST(ChooseLabels, ThickPartsOfVesselsAreARegionAndThinOnesAreSaid) {
    const auto image = block_with_tube("Portal vein");
    const auto chosen = choose_labels(image, {}, tetrahedron_for(3.0));
    ASSERT_EQ(chosen.region_names, (std::vector<std::string>{"parenchyma", "vessel_portal"}));
    EXPECT_EQ(chosen.region[at(5, 5, 5)], 2);
    EXPECT_EQ(chosen.region[at(3, 3, 3)], 1);
    EXPECT_EQ(chosen.region[at(11, 5, 5)], 0) << "outside of the liver";
    EXPECT_TRUE(is_said(chosen, "of label 2 'Portal vein' in the liver are thinner than 3 mm, 1.5 edges of a "
                                "tetrahedron, and become parenchyma"));
    EXPECT_TRUE(is_said(chosen, "of label 2 'Portal vein' reach out of the liver and are left out"));
    EXPECT_TRUE(is_said(chosen, "are left out: 3 'spleen'"));

    const auto coarse = choose_labels(image, {}, tetrahedron_for(5.0));
    EXPECT_EQ(coarse.region_names.size(), 1u);
    EXPECT_EQ(coarse.region[at(5, 5, 5)], 1) << "no hole where it was";
    EXPECT_TRUE(is_said(coarse, "are thinner than 5 mm"));
}

TEST(ChooseLabels, VesselsBesideTheLiverHaveNoRegion) {
    const auto chosen = choose_labels(block_with_tube("inferior_vena_cava"), {}, 0.0);
    EXPECT_EQ(chosen.region_names.size(), 1u);
    EXPECT_EQ(chosen.region[at(5, 5, 5)], 0);
    EXPECT_TRUE(is_said(chosen, "vessels and ducts that have no region of their own are left out: 2 "
                                "'inferior_vena_cava'; 0.001 mL of them that the liver encloses become parenchyma"));
}

TEST(ChooseLabels, EveryKindOfVesselIsARegion) {
    auto image = block();
    image.label_names = {{1, "Liver"}, {2, "Hepatic vein"}, {3, "liver_vessels"}, {4, "Hepatic artery"}};
    for (int label = 2; label < 5; ++label)
        image.label[at(2 * label, 5, 5)] = static_cast<std::uint16_t>(label);
    EXPECT_EQ(choose_labels(image, {}, 0.0).region_names,
              (std::vector<std::string>{"parenchyma", "vessel", "vessel_artery", "vessel_hepatic"}));
    EXPECT_EQ(choose_labels(image, {.liver = {1}, .tumours = {}}, 0.0).region_names.size(), 1u)
        << "with --liver nothing but what is named";
}

TEST(ChooseLabels, CystsAreRegionsAndAGallbladderIsWhereItIsEnclosed) {
    auto image = block();
    image.label_names = {{1, "Liver"}, {2, "Cyst"}, {3, "Gallbladder"}, {4, "Tumour"}};
    image.label[at(4, 4, 4)] = image.label[at(5, 4, 4)] = 2;
    image.label[at(7, 7, 7)] = 2;
    image.label[at(6, 6, 9)] = 3;
    image.label[at(3, 6, 6)] = 4;
    const auto chosen = choose_labels(image, {}, 0.0);
    EXPECT_EQ(chosen.region_names, (std::vector<std::string>{"parenchyma", "tumour_1", "cyst_1", "cyst_2"}));
    EXPECT_EQ(chosen.region[at(4, 4, 4)], 3) << "the largest first";
    EXPECT_EQ(chosen.region[at(6, 6, 9)], 0);
    EXPECT_TRUE(is_said(chosen, "0.001 mL beside the liver are left out"));
    EXPECT_TRUE(is_said(choose_labels(image, {}, 1.5 * voxel), "1 cysts below"));

    image.label[at(6, 6, 6)] = 3;
    const auto enclosed = choose_labels(image, {}, 0.0);
    EXPECT_EQ(enclosed.region_names.back(), "gallbladder");
    EXPECT_EQ(enclosed.region[at(6, 6, 6)], 5);
}

TEST(ChooseLabels, RolesDecideBeforeNames) {
    auto image = block();
    image.label_names = {{1, "Liver"}, {2, "green"}, {3, "Tumour"}};
    image.label[at(4, 4, 4)] = 2;
    image.label[at(6, 6, 6)] = 3;
    const auto names = [&](const std::vector<std::string> &roles) {
        LabelChoice choice;
        for (const auto &role : roles)
            choice.roles.push_back(chosen_role(role));
        return choose_labels(image, choice, 0.0).region_names;
    };
    const auto found = [](std::vector<std::string> regions) {
        regions.insert(regions.begin(), "parenchyma");
        return regions;
    };
    EXPECT_EQ(names({}), found({"tumour_1"}));
    EXPECT_EQ(names({"Green=tumour"}), found({"tumour_1", "tumour_2"}));
    EXPECT_EQ(names({"2=cyst", "Tumour=ignore"}), found({"cyst_1"}));
    EXPECT_EQ(names({"2=vessel", "3=vessel_portal"}), found({"vessel", "vessel_portal"}));
    tests::expect_input_error([&] { names({"yellow=cyst"}); },
                              {"--role names 'yellow'", "it has 1 'Liver', 2 'green', 3 'Tumour'"});
    tests::expect_input_error([&] { names({"2=cyst", "green=tumour"}); }, {"label 2 is given two roles"});
    for (const auto *words : {"2", "2=", "=cyst", "2=kidney"})
        tests::expect_input_error([&] { chosen_role(words); }, {"--role is '", "one of liver, tumour, vessel"});

    image.label_names.clear();
    EXPECT_EQ(names({"3=vessel"}), found({"tumour_1", "vessel"})) << "other labels go as without names";
    EXPECT_EQ(names({"1=liver", "3=vessel"}), found({"vessel"})) << "who chooses the liver chooses all";
}

TEST(VoxelShapes, OpeningKeepsWhatABallCoversAndClosingFillsWhatItCannotEnter) {
    const ImageGrid grid{.size = {20, 20, 20}, .spacing = {1e-3, 1e-3, 2e-3}};
    VoxelSet set(num_voxels(grid), 0);
    const auto voxel_at = [](int i, int j, int k) { return static_cast<std::size_t>(i + 20 * (j + 20 * k)); };
    for (int k = 5; k < 10; ++k)
        for (int j = 0; j < 20; ++j)
            for (int i = 0; i < 20; ++i)
                if (j < 9 || j == 15)
                    set[voxel_at(i, j, k)] = 1; // a thick plate and a thin one, 6 mm apart
    const auto opened = opened_by_ball(grid, set, 2.5e-3);
    EXPECT_EQ(opened[voxel_at(10, 4, 7)], 1);
    EXPECT_EQ(opened[voxel_at(10, 15, 7)], 0);
    EXPECT_EQ(opened_by_ball(grid, set, 0.0), set);
    const auto closed = closed_by_ball(grid, set, 4e-3);
    EXPECT_EQ(closed[voxel_at(10, 12, 7)], 1) << "between the plates";
    EXPECT_EQ(closed[voxel_at(10, 18, 7)], 0);
    EXPECT_EQ(closed_by_ball(grid, set, 2e-3)[voxel_at(10, 12, 7)], 0) << "a ball that fits between them";
    for (std::size_t v = 0; v < set.size(); ++v) {
        ASSERT_LE(opened[v], set[v]);
        ASSERT_LE(set[v], closed[v]);
    }
}

TEST(ChooseLabels, WithoutNamesSayHowTheLabelsAreTaken) {
    auto image = block();
    image.label[at(4, 4, 4)] = 2;
    EXPECT_TRUE(is_said(choose_labels(image, {}, 0.0), "so 1, the lowest, is taken for the liver and 2 for lesions"));
    image.label_names = {{1, "kidney"}, {2, "liver"}};
    EXPECT_EQ(choose_labels(image, {.liver = {}, .tumours = {1}}, 0.0).region[at(4, 4, 4)], 1)
        << "the liver's name counts where its number is not given";
}

TEST(ChooseLabels, OtherOrgansDoNotCountForTheVolumeOfTheBody) {
    auto image = block();
    for (int j = 2; j < 9; ++j)
        for (int k = 2; k < 9; ++k)
            image.label[at(8, j, k)] = 9;
    image.label[at(4, 4, 4)] = 2;
    EXPECT_NEAR(labelled_volume(image, {}), 343 * voxel, 1e-15) << "nothing says what they are";
    image.label_names = {{1, "liver"}, {2, "tumour"}, {9, "spleen"}};
    EXPECT_NEAR(labelled_volume(image, {}), 294 * voxel, 1e-15);
    EXPECT_NEAR(labelled_volume(image, {.liver = {1}, .tumours = {}}), 293 * voxel, 1e-15);
}

TEST(ChooseLabels, LabelsThatAreNotMeantAreBackground) {
    auto image = block();
    for (int j = 2; j < 9; ++j)
        for (int k = 2; k < 9; ++k)
            image.label[at(8, j, k)] = 9; // another organ beside it
    const auto chosen = choose_labels(image, {.liver = {1}, .tumours = {}}, 0.0);
    EXPECT_EQ(chosen.region_names.size(), 1u);
    EXPECT_EQ(chosen.region[at(8, 4, 4)], 0);
}

TEST(ChooseLabels, WhatCannotBeMeantIsRefused) {
    auto image = block();
    EXPECT_THROW(choose_labels(image, {.liver = {4}, .tumours = {}}, 0.0), support::InputError);
    EXPECT_THROW(choose_labels(image, {.liver = {1}, .tumours = {2}}, 0.0), support::InputError);
    EXPECT_THROW(choose_labels(image, {.liver = {1}, .tumours = {1}}, 0.0), support::InputError);
    EXPECT_THROW(choose_labels(image, {.liver = {}, .tumours = {1}}, 0.0), support::InputError);
    for (std::uint16_t label = 2; label < 20; ++label)
        image.label[at(2 + label % 7, 2 + label / 7, 4)] = label;
    EXPECT_THROW(choose_labels(image, {}, 0.0), support::InputError) << "a segmentation of the whole body";
    image.label.assign(image.label.size(), 0);
    EXPECT_THROW(choose_labels(image, {}, 0.0), support::InputError) << "empty";
}

TEST(Phantom, HasTheVolumesOfTheLiverAndItsSixLesions) {
    const auto chosen =
        choose_labels(phantom_labels({.spacing = {1e-3, 1e-3, 2e-3}, .turn = {0.1, 0.2, 0.0}}), {}, 0.0);
    const auto volumes = region_volumes(chosen);
    ASSERT_EQ(volumes.size(), 7u);
    EXPECT_NEAR(std::accumulate(volumes.begin(), volumes.end(), 0.0), 1.513e-3, 0.002e-3);
    EXPECT_NEAR(volumes[1], 4.18879 * 24.5e-3 * 21.5e-3 * 18.5e-3, 0.01 * volumes[1]);
}

TEST(Phantom, MayHaveVesselsWithNames) {
    const auto image = phantom_labels({.spacing = {1.5e-3, 1.5e-3, 1.5e-3}, .vessels = true});
    EXPECT_EQ(image.label_names.at(phantom_portal_label), "Portal vein");
    const auto chosen = choose_labels(image, {}, tetrahedron_for(7.0));
    ASSERT_EQ(chosen.region_names.size(), 9u);
    EXPECT_EQ(chosen.region_names[7], "vessel_hepatic");
    const auto volumes = region_volumes(chosen);
    EXPECT_GT(volumes[7], 5e-6);
    EXPECT_GT(volumes[8], 5e-6);
    EXPECT_TRUE(is_said(chosen, "of label 9 'Portal vein' in the liver are thinner than 7 mm"));
    EXPECT_NEAR(std::accumulate(volumes.begin(), volumes.end(), 0.0), 1.513e-3, 0.002e-3) << "without dents";
}

TEST(Phantom, MayHaveLesionsThatTouch) {
    const auto image = phantom_labels({.spacing = {1e-3, 1e-3, 1e-3}, .touching = true});
    const auto &size = image.grid.size;
    bool touches_outside = false, touches_neighbour = false;
    for (std::size_t v = 1; v < image.label.size(); ++v) {
        if (static_cast<int>(v) % size[0] == 0)
            continue;
        const auto a = image.label[v - 1], b = image.label[v];
        touches_outside = touches_outside || (std::min(a, b) == 0 && std::max(a, b) >= phantom_first_tumour_label);
        touches_neighbour = touches_neighbour || (std::min(a, b) >= phantom_first_tumour_label && a != b);
    }
    EXPECT_TRUE(touches_outside);
    EXPECT_TRUE(touches_neighbour);
}

} // namespace
} // namespace livermark::segmentation
