#include "studies/seed_paper/seed_paper.hpp"

#include <gtest/gtest.h>
#include <set>

#include "studies/seed_paper/table_1.hpp"
#include "studies/seed_paper/table_1_readings.hpp"

namespace livermark::studies {
namespace {

TEST(Table1, IsReadInEveryUnitForBothLivers) {
    const auto readings = readings_of_table_1();
    ASSERT_EQ(readings.size(), 12u);
    std::set<std::string> names;
    for (const auto &reading : readings) {
        names.insert(reading.name);
        const bool is_with_tumour = reading.name.ends_with("_with_tumour");
        EXPECT_NE(is_with_tumour, reading.name.ends_with("_without_tumour"));
        EXPECT_EQ(reading.mass, is_with_tumour ? 5.9256 : 1.9825);
    }
    EXPECT_EQ(names.size(), 12u);
}

TEST(Table1, KeepsTheRatioOfStiffnessesInEveryReading) {
    const auto readings = readings_of_table_1();
    for (std::size_t r = 0; r < readings.size(); r += 2) {
        const auto &without = readings[r], &with = readings[r + 1];
        EXPECT_NEAR(with.stiffness / without.stiffness, 7.0484 / 5.4225, 1e-12) << with.name;
        const bool is_per_mass = with.name.find("per_mass") != std::string::npos;
        const double ratio = 11.9012 / 7.4525 * (is_per_mass ? 5.9256 / 1.9825 : 1.0);
        EXPECT_NEAR(with.damping / without.damping, ratio, 1e-12) << with.name;
    }
}

/// A healthy liver of 1.5 L and 1.59 kg, with springs as Lloyd's.
BodyParameters liver() {
    BodyParameters body;
    body.volume = 1.5e-3;
    body.mean_young_modulus = 5e3;
    body.node_mass = {.number = 1000, .sum = 1.59, .mean = 1.59e-3};
    body.stiffness = {.number = 5000, .sum = 1.2e5, .mean = 24.0};
    body.dashpot = {.number = 5000, .sum = 150.0, .mean = 0.03};
    body.ground_damper = {.number = 1000, .sum = 1.5, .mean = 1.5e-3};
    return body;
}

TEST(SeedPaper, MassOfAHealthyLiverIsPossibleAndThatOfALiverWithTumoursIsNot) {
    auto body = liver();
    const auto healthy = compare_with_paper(body);
    EXPECT_EQ(healthy[0].printed, 1.9825);
    EXPECT_TRUE(healthy[0].objection.empty()) << healthy[0].objection;
    body.tumour_volume = 0.07e-3;
    const auto with_tumours = compare_with_paper(body);
    EXPECT_EQ(with_tumours[0].printed, 5.9256);
    EXPECT_NE(with_tumours[0].objection.find("5.59 L"), std::string::npos) << with_tumours[0].objection;
    EXPECT_NE(with_tumours[0].objection.find("the 3.94 kg"), std::string::npos) << with_tumours[0].objection;
}

TEST(SeedPaper, StiffnessAndDampingHaveAnotherDimensionThanTheirUnits) {
    const auto claims = compare_with_paper(liver());
    EXPECT_NE(claims[1].objection.find("in N/m, which is another dimension than kPa"), std::string::npos);
    EXPECT_NE(claims[2].objection.find("in N s/m, which is another dimension than N/m^2"), std::string::npos);
}

TEST(SeedPaper, NumberThatIsNearTheBodysIsNamed) {
    auto body = liver();
    EXPECT_NE(compare_with_paper(body)[1].objection.find("near the mean Young's modulus"), std::string::npos);
    body.mean_young_modulus *= 10.0;
    EXPECT_NE(compare_with_paper(body)[1].objection.find("none of these readings"), std::string::npos);
}

TEST(SeedPaper, ReadingsOfTheDampingAreOnlyThoseThatABodyHas) {
    auto body = liver();
    EXPECT_EQ(compare_with_paper(body)[2].readings.size(), 4u);
    body.dashpot.mean = body.dashpot.sum = 0.0;
    EXPECT_EQ(compare_with_paper(body)[2].readings.size(), 2u);
}

} // namespace
} // namespace livermark::studies
