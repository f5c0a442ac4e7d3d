#include "meshes/generators/liver/liver_variation.hpp"

#include <gtest/gtest.h>
#include <set>

#include "meshes/generators/liver/liver_generator.hpp"
#include "meshes/io/mesh_figures.hpp"
#include "support/input_error.hpp"

namespace livermark::meshes {
namespace {

constexpr int num_variants = 24;

TEST(LiverVariation, IsTheSameForTheSameNumberOnly) {
    const auto variant = draw_liver(7);
    EXPECT_EQ(to_text(variant), to_text(draw_liver(7)));
    EXPECT_EQ(variant.volume, draw_liver(7).volume);
    EXPECT_NE(variant.volume, draw_liver(8).volume);
}

TEST(LiverVariation, StaysWithinPublishedAnatomy) {
    std::set<std::size_t> numbers_of_lesions;
    int num_riedel_lobes = 0;
    for (int number = 1; number <= num_variants; ++number) {
        const auto variant = draw_liver(number);
        EXPECT_GE(variant.volume, 0.9e-3) << number;
        EXPECT_LE(variant.volume, 2.2e-3) << number;
        EXPECT_GT(variant.left_part, 0.05) << number;
        EXPECT_LT(variant.left_part, 0.27) << number;
        EXPECT_LE(variant.lesions.size(), 8U) << number;
        numbers_of_lesions.insert(variant.lesions.size());
        num_riedel_lobes += variant.has_riedel_lobe ? 1 : 0;
    }
    EXPECT_GT(numbers_of_lesions.size(), 4U);
    EXPECT_GT(num_riedel_lobes, 0);
}

TEST(LiverVariation, KeepsLesionsApartAndBelowTheCapsule) {
    std::size_t num_lesions = 0;
    for (int number = 1; number <= num_variants; ++number) {
        const auto variant = draw_liver(number);
        num_lesions += variant.lesions.size();
        for (std::size_t i = 0; i < variant.lesions.size(); ++i) {
            const auto &lesion = variant.lesions[i];
            for (int d = 0; d < 3; ++d)
                for (const double side : {-1.0, 1.0})
                    EXPECT_LT(liver_level(lesion.center + side * lesion.semi_axes[d] * lesion.axes[d], variant.shape),
                              -0.008)
                        << number;
            for (std::size_t j = 0; j < i; ++j) {
                const auto &larger = variant.lesions[j];
                EXPECT_GE(larger.semi_axes.prod(), lesion.semi_axes.prod()) << number;
                EXPECT_GT((lesion.center - larger.center).norm(),
                          lesion.semi_axes.maxCoeff() + larger.semi_axes.maxCoeff() + 0.010)
                    << number;
            }
        }
    }
    EXPECT_GT(num_lesions, static_cast<std::size_t>(num_variants));
}

TEST(LiverVariation, MeshesWithItsVolumeLesionsAndAllSevenPatches) {
    for (const int number : {1, 4, 7}) {
        const auto variant = draw_liver(number);
        const auto mesh = generate_liver(variant, 4000);
        const auto figures = mesh_figures(mesh);
        EXPECT_NEAR(figures.volume, variant.volume, 1e-5 * variant.volume) << number;
        EXPECT_GT(figures.smallest_quality, 0.0) << number;
        EXPECT_EQ(mesh.region_names.size(), variant.lesions.size() + 1) << number;
        EXPECT_EQ(std::set<int>(mesh.boundary_patch.begin(), mesh.boundary_patch.end()).size(), 7U) << number;
        const auto again = generate_liver(variant, 4000);
        EXPECT_EQ(again.points, mesh.points) << number;
        EXPECT_EQ(again.tetrahedra, mesh.tetrahedra) << number;
    }
}

TEST(LiverVariation, RefusesANumberThatIsNone) {
    EXPECT_THROW(draw_liver(0), support::InputError);
    EXPECT_THROW(draw_liver(-3), support::InputError);
}

} // namespace
} // namespace livermark::meshes
