#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "report/colour_map.hpp"
#include "report/html.hpp"
#include "report/plot.hpp"
#include "report/plot_labels.hpp"
#include "report/surface_picture.hpp"
#include "report/ticks.hpp"

namespace livermark::report {
namespace {

using core::Vector3;

/// Looks down along z at a square of so many pixels of 1 m, its corner at the origin.
View from_above(int size) {
    return {.right = Vector3::UnitX(),
            .up = Vector3::UnitY(),
            .toward = Vector3::UnitZ(),
            .low_x = 0.0,
            .low_y = 0.0,
            .pixel = 1.0,
            .width = size,
            .height = size};
}

Colour pixel(const Picture &picture, int x, int y) {
    const auto at = 3 * (static_cast<std::size_t>(y) * picture.width + x);
    return {picture.rgb[at], picture.rgb[at + 1], picture.rgb[at + 2]};
}

constexpr Colour white{255, 255, 255};

void expect_near(const Colour &found, const Colour &expected) {
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], expected[c], 3) << hex(found) << " " << hex(expected); // in steps of 4
}

Colour displacement_colour(double at) {
    return colour_at(Quantity::displacement, at);
}

const std::vector<std::array<int, 3>> one_triangle{{0, 1, 2}};
const std::vector<Vector3> corners{{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};

TEST(ColourMap, EndsInTheColoursOfViridis) {
    EXPECT_EQ(hex(displacement_colour(0.0)), "#440154");
    EXPECT_EQ(hex(displacement_colour(0.5)), "#21918c");
    EXPECT_EQ(hex(displacement_colour(1.0)), "#fde725");
    EXPECT_EQ(displacement_colour(-3.0), displacement_colour(0.0));
    EXPECT_EQ(displacement_colour(7.0), displacement_colour(1.0));
}

TEST(ColourMap, IsThatOfThePage) {
    std::ifstream file(LIVERMARK_SOURCE_DIR "/viewer/src/picture/colour_maps.ts");
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    for (const auto &[name, quantity] :
         {std::pair{"const displacement = `", Quantity::displacement}, {"const error = `", Quantity::error}}) {
        const auto start = text.find(name);
        ASSERT_NE(start, std::string::npos) << name;
        const auto list = start + std::string(name).size();
        std::istringstream words(text.substr(list, text.find('`', list) - list));
        const std::vector<std::string> colours(std::istream_iterator<std::string>(words), {});
        ASSERT_GT(colours.size(), 8U);
        for (std::size_t c = 0; c < colours.size(); ++c)
            EXPECT_EQ(hex(colour_at(quantity, static_cast<double>(c) / static_cast<double>(colours.size() - 1))),
                      '#' + colours[c]);
    }
}

TEST(ColourMap, OfErrorsGetsDarkerAllTheWay) {
    double last = 256.0;
    for (int i = 0; i <= 100; ++i) {
        const auto [red, green, blue] = colour_at(Quantity::error, i / 100.0);
        const double luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        EXPECT_LT(luma, last) << i;
        last = luma;
    }
}

TEST(ColourMap, GetsBrighterAllTheWay) {
    double last = 0.0;
    for (int i = 0; i <= 100; ++i) {
        const auto [red, green, blue] = displacement_colour(i / 100.0);
        const double luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        EXPECT_GT(luma, last) << i;
        last = luma;
    }
}

TEST(SurfacePicture, CoversThePixelsOfATriangle) {
    const std::vector<double> values(3, 1.0);
    const auto picture = draw_surface({one_triangle, corners, values, 1.0}, from_above(8));
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
            // Its long side runs from the top left to the bottom right, y down.
            const int across = x - y;
            if (across < 0)
                expect_near(pixel(picture, x, y), displacement_colour(1.0));
            else if (across > 0)
                EXPECT_EQ(pixel(picture, x, y), white) << x << " " << y;
            else // half of it
                EXPECT_GT(pixel(picture, x, y)[2], displacement_colour(1.0)[2] + 40);
        }
}

TEST(SurfacePicture, HasTheColourOfTheLegendAtACorner) {
    const std::vector<double> values{0.0, 0.5e-3, 1.0e-3};
    const std::vector<Vector3> large{{-5, -5, 0}, {95, -5, 0}, {-5, 95, 0}};
    const auto picture = draw_surface({one_triangle, large, values, 1e-3}, from_above(100));
    // Weights of 0.055 for corners that are 94.5 m away.
    expect_near(pixel(picture, 0, 99), displacement_colour(0.055 * 0.5 + 0.055 * 1.0));
    expect_near(pixel(picture, 80, 99), displacement_colour(0.855 * 0.5 + 0.055 * 1.0));
    expect_near(pixel(picture, 0, 19), displacement_colour(0.855 * 1.0 + 0.055 * 0.5));
}

TEST(SurfacePicture, ShowsWhatIsInFront) {
    std::vector<Vector3> points = corners;
    for (const auto &corner : corners)
        points.emplace_back(corner + Vector3(0, 0, 1));
    const std::vector<double> values{1, 1, 1, 0, 0, 0};
    const std::vector<std::array<int, 3>> near_first{{3, 4, 5}, {0, 1, 2}}, near_last{{0, 1, 2}, {3, 4, 5}};
    for (const auto &triangles : {near_first, near_last})
        expect_near(pixel(draw_surface({triangles, points, values, 1.0}, from_above(8)), 1, 6),
                    displacement_colour(0.0));
}

TEST(SurfacePicture, IsDarkerWhereItTurnsAway) {
    const std::vector<double> values(3, 1.0);
    std::vector<Vector3> tilted = corners;
    tilted[2].z() = -8.0; // by 45 degrees
    const auto picture = draw_surface({one_triangle, tilted, values, 1.0}, from_above(8));
    EXPECT_NEAR(pixel(picture, 1, 6)[0], 0xfd * (0.5 + 0.5 * std::sqrt(0.5)), 3.0);
}

TEST(SurfacePicture, DrawsTheOutlineAtRest) {
    const std::vector<double> values(3, 1.0);
    std::vector<Vector3> away = corners;
    for (auto &point : away)
        point.x() += 100.0;
    const auto picture = draw_surface({one_triangle, away, values, 1.0}, from_above(10),
                                      outline_of(one_triangle, corners, from_above(10)));
    EXPECT_LT(pixel(picture, 0, 5)[0], 200);
    EXPECT_EQ(pixel(picture, 1, 7), white);
    EXPECT_EQ(pixel(picture, 9, 0), white);
}

TEST(SurfacePicture, IsSeenFromWhereItMoves) {
    const std::vector<Vector3> moves(3, Vector3(0, 0, 1e-3));
    const std::vector<Vector3> wall{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}; // faces along x
    const std::vector<std::vector<Vector3>> shapes{wall};
    const auto view = find_view(one_triangle, wall, moves, shapes, 100);
    EXPECT_GT(view.toward.x(), 0.8);
    EXPECT_NEAR(view.right.cross(view.up).dot(view.toward), 1.0, 1e-12);
    EXPECT_EQ(view.width, 100);
    EXPECT_GT(view.height, 90);
}

TEST(SurfacePicture, IsNotMuchTallerThanWide) {
    const std::vector<Vector3> moves(3, Vector3(1e-3, 0, 0));
    const std::vector<Vector3> needle{{0, 0, 0}, {0, 1, 0}, {0, 0, 1000}};
    const std::vector<std::vector<Vector3>> shapes{needle};
    const auto view = find_view(one_triangle, needle, moves, shapes, 100);
    EXPECT_EQ(view.width, 100);
    EXPECT_LE(view.height, 150);
}

TEST(Png, IsTheSameForTheSamePicture) {
    const Picture picture{2, 1, {255, 0, 0, 0, 0, 255}};
    const auto bytes = png_bytes(picture);
    EXPECT_EQ(bytes, png_bytes(picture));
    EXPECT_EQ((std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + 4)),
              (std::vector<std::uint8_t>{0x89, 'P', 'N', 'G'}));
}

TEST(Ticks, AreRoundNumbersInTheRange) {
    EXPECT_EQ(linear_ticks(0.0, 1.0, 5), (std::vector<double>{0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0}));
    EXPECT_EQ(logarithmic_ticks(0.9, 30.0), (std::vector<double>{1.0, 2.0, 5.0, 10.0, 20.0}));
    EXPECT_EQ(logarithmic_ticks(1e-5, 1e3).size(), 9u);
    EXPECT_EQ(rounded_up(0.03), 0.05);
    EXPECT_EQ(rounded_up(2.0), 2.0);
    EXPECT_EQ(tick_label(0.6000000000000001), "0.6");
    EXPECT_EQ(tick_label(1e-6), "1e-06");
}

TEST(Plot, LeavesOutWhatCannotBeShown) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Plot plot{.title = "a < b",
              .x = {.label = "x", .scale = Scale::logarithmic},
              .y = {.label = "y"},
              .series = {{.name = "s", .points = {{1, 2}, {-1, 2}, {10, nan}, {100, 5}}, .style = {}}}};
    EXPECT_TRUE(has_points(plot));
    const auto svg = plot_svg(plot);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
    std::size_t circles = 0;
    for (auto at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1))
        ++circles;
    EXPECT_EQ(circles, 2u);
    plot.series[0].points = {{-1, 2}, {10, nan}};
    EXPECT_FALSE(has_points(plot));
    EXPECT_EQ(plot_svg(plot).find("nan"), std::string::npos);
}

TEST(PlotLabels, DoNotOverlapInAColumn) {
    std::vector<Label> labels;
    for (const double y : {100.0, 101.0, 102.0, 10.0, 299.0, 300.0})
        labels.push_back({"model", 0.0, y, 0.0, 0.0});
    spread_in_column(labels, 50.0, 0.0, 300.0);
    for (std::size_t l = 1; l < labels.size(); ++l)
        EXPECT_GE(labels[l].at_y - labels[l - 1].at_y, label_size);
    EXPECT_LE(labels.back().at_y, 300.0 + label_size);
}

TEST(PlotLabels, DoNotCoverEachOtherBesidePoints) {
    std::vector<Label> labels{{"first", 100, 100, 0, 0}, {"second", 103, 101, 0, 0}, {"third", 101, 99, 0, 0}};
    place_beside_points(labels, 0, 300, 0, 200);
    for (std::size_t a = 0; a < labels.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) {
            const bool beside = labels[a].at_x + text_width(labels[a].text) <= labels[b].at_x ||
                                labels[b].at_x + text_width(labels[b].text) <= labels[a].at_x;
            EXPECT_TRUE(beside || std::abs(labels[a].at_y - labels[b].at_y) >= label_size) << a << " " << b;
        }
}

TEST(Html, EscapesAndKeepsUtf8) {
    EXPECT_EQ(escaped("<a href=\"x\">&'µ"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;µ");
    EXPECT_EQ(escaped("\xc3"), "\xef\xbf\xbd");                                 // cut off
    EXPECT_EQ(escaped("\xed\xa0\x80"), "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd"); // a surrogate
    EXPECT_EQ(escaped(std::string("a\0b", 3)), "a\xef\xbf\xbd"
                                               "b");
}

} // namespace
} // namespace livermark::report
