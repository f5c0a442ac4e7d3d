#include <gtest/gtest.h>
#include <string>

#include "meshes/segmentation/surfaces/surface_file.hpp"

namespace livermark::segmentation {
namespace {

const std::string mark = "\xef\xbb\xbf";
const std::string facet = "facet normal 0 0 0\nouter loop\nvertex 1.5e0 0 0\n";

TEST(PlainSurfaceText, LeavesAloneWhatCanBeRead) {
    for (const auto &[text, ending] : {std::pair<std::string, std::string>{"solid s\n" + facet, ".stl"},
                                       {std::string("solid FACET\0\0 FACET", 20), ".stl"}, // binary
                                       {"v 0 0 0\nvn 0 0 1\nusemtl l\nf 1 2 3\n", ".obj"},
                                       {"ply\n", ".ply"},
                                       {"", ".off"}}) {
        const auto plain = plain_surface_text(text, ending);
        EXPECT_FALSE(plain.text.has_value()) << text;
        EXPECT_EQ(plain.num_left_out, 0U) << text;
    }
}

TEST(PlainSurfaceText, TakesAByteOrderMarkAway) {
    for (const char *ending : {".stl", ".obj", ".ply", ".off"})
        EXPECT_EQ(plain_surface_text(mark + "OFF\n", ending).text, "OFF\n") << ending;
}

TEST(PlainSurfaceText, WritesKeywordsOfStlSmall) {
    EXPECT_EQ(plain_surface_text("SOLID S\nFACET NORMAL 0 0 0\nOUTER LOOP\nVERTEX 1.5E0 0 0\n", ".stl").text,
              "solid s\n" + facet);
    EXPECT_EQ(plain_surface_text(mark + "  Solid s\nFacet normal 0 0 0\n", ".stl").text,
              "  solid s\nfacet normal 0 0 0\n");
}

TEST(PlainSurfaceText, LeavesLinesAndPointsOfObjOutAndCountsThem) {
    const auto plain = plain_surface_text("v 0 0 0\nl 1 2\n  p 3\nf 1 2 3\nl 4 5", ".obj");
    EXPECT_EQ(plain.text, "v 0 0 0\nf 1 2 3\n");
    EXPECT_EQ(plain.num_left_out, 3U);
}

} // namespace
} // namespace livermark::segmentation
