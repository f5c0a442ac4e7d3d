#include "core/mesh/plausible_liver.hpp"

#include <gtest/gtest.h>

namespace livermark::core {
namespace {

using enum SegmentRole;

void expect_role(SegmentRole role, std::initializer_list<const char *> names) {
    for (const char *name : names)
        EXPECT_EQ(role_of_name(name), role) << name;
}

/// Spellings of 3D Slicer, TotalSegmentator, LiTS, MSD, CHAOS, AbdomenAtlas, 3D-IRCADb and collections of TCIA.
TEST(SegmentNames, OfALiverAreWholePhrases) {
    expect_role(liver, {"liver",
                        "Liver",
                        "LIVER",
                        "Liver parenchyma",
                        "liver_right_lobe",
                        "whole liver",
                        "Liver mask",
                        "liver_segment_1",
                        "liver_segment_4a",
                        "Couinaud segment IV",
                        "LiverSegmentation",
                        "Hepatic",
                        "Liver_Remnant",
                        "Right lobe of the liver",
                        "Leber",
                        "foie",
                        "Liver without tumours",
                        "liver with lesions",
                        "liver1",
                        "parenchyma",
                        "Liver (CT, manual)"});
    expect_role(other, {"Liver bed", "Non-liver", "nonliver", "Liver capsule", "outside of liver", "stomach",
                        "gallbladder", "lung", "lung_upper_lobe_left", "lung parenchyma", "spleen",
                        "Tissue around liver", "hepatic flexure", "leftkidney", "portion"});
}

TEST(SegmentNames, OfLesionsAreThoseOfTheLiver) {
    expect_role(lesion, {"Neoplasm",
                         "Neoplasm, Primary",
                         "Malignant neoplasm",
                         "Hemangioma",
                         "haemangioma",
                         "tumor",
                         "Tumour",
                         "tumour_1",
                         "cancer",
                         "liver_tumor",
                         "livertumor01",
                         "liverkyst",
                         "Liver cyst",
                         "liver_lesion",
                         "Mass",
                         "HCC 2",
                         "Metastasis",
                         "colorectal metastasis",
                         "metastasis from colon",
                         "Lesion in liver",
                         "FNH",
                         "Nodule",
                         "necrosis",
                         "vascular lesion",
                         "Tumor of the bile duct",
                         "LiverTumor",
                         "kidney metastasis of the liver"});
    expect_role(other, {"kidney_cyst_left", "lung_tumor", "pancreas_tumor", "colon_cancer_primaries", "lung nodules",
                        "Lymph node metastasis", "Non-tumour", "peritumoral", "tumor bed", "healthy tissue of tumor",
                        "metastasectomie", "massive"});
}

TEST(SegmentNames, OfVesselsAndDuctsAreTheirOwn) {
    expect_role(
        vessel,
        {"liver_vessels",      "Vessel",      "Hepatic vein",  "portal vein",      "portal_vein_and_splenic_vein",
         "inferior_vena_cava", "postcava",    "portalvein",    "venacava",         "artery",
         "Hepatic artery",     "aorta",       "Bile duct",     "common bile duct", "biliarysystem",
         "tumour vessels",     "cystic duct", "Liver vessels", "venoussystem",     "IVC"});
}

TEST(SegmentNames, ThatProgramsGiveSayNothing) {
    expect_role(unnamed, {"", "1", "Segment_1", "label 2", "Label_Value_3", "Class 1", "ROI 4", "Segmentation",
                          "unknown", "x", "Tissue"});
}

TEST(SegmentNames, CodesDecideBeforeWords) {
    EXPECT_EQ(role_of_segment("Segment_1", {.type = "108369006", .meaning = "Neoplasm"}), lesion);
    EXPECT_EQ(role_of_segment("green", {.type = "M-8FFFF", .meaning = ""}), lesion);
    EXPECT_EQ(role_of_segment("green", {.type = "M-81703", .meaning = ""}), lesion) << "hepatocellular carcinoma";
    EXPECT_EQ(role_of_segment("Foie 2", {.type = "T-62000", .meaning = "Liver"}), liver);
    EXPECT_EQ(role_of_segment("Liver", {.type = "8993003", .meaning = "Hepatic vein"}), vessel);
    EXPECT_EQ(role_of_segment("Segment_2", {.type = "999", .meaning = "Hemangioma"}), lesion) << "by the words";
    EXPECT_EQ(role_of_segment("Liver", {.type = "85756007", .meaning = "Tissue"}), liver) << "the code says nothing";
    EXPECT_EQ(role_of_segment("Segment_1", {.type = "85756007", .meaning = "Tissue"}), unnamed);
    EXPECT_EQ(role_of_segment("Segment_1", {.type = "69695003", .meaning = "Stomach"}), other);
    EXPECT_EQ(role_of_segment("tumour", {.type = "108369006", .meaning = "Neoplasm", .region = "Kidney"}), other);
    EXPECT_EQ(role_of_segment("tumour", {.type = "108369006", .meaning = "Neoplasm", .region = "Liver"}), lesion);
}

} // namespace
} // namespace livermark::core
