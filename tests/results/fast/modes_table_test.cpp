#include <gtest/gtest.h>
#include <memory>
#include <numbers>

#include "results/tables/table.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using Field = std::vector<core::Vector3>;

const auto modes_mesh = tests::box_mesh({0.1, 0.2, 0.1}, {2, 3, 2});

/// Every node moves by the same.
Field constant(const core::Vector3 &value) {
    return Field(modes_mesh.points.size(), value);
}

TEST(ModalAssurance, IsOneForOneShapeAndZeroForOthersThatShareNothing) {
    const auto along = constant({0.0, 1.0, 0.0});
    EXPECT_NEAR(core::modal_assurance(modes_mesh, along, constant({0.0, -3.0, 0.0})), 1.0, 1e-14);
    EXPECT_EQ(core::modal_assurance(modes_mesh, along, constant({1.0, 0.0, 2.0})), 0.0);
    EXPECT_NEAR(core::modal_assurance(modes_mesh, along, constant({1.0, 1.0, 0.0})), 0.5, 1e-14);
}

Field both(Field first, const Field &second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

TEST(ModesTable, SetsModelsBesideTheReference) {
    const auto hertz = [](double frequency) { return 2.0 * std::numbers::pi * frequency; };
    results::Result result{.provenance = {}, .problem = {}, .models = {}};
    result.problem.body = tests::make_body(modes_mesh, {1060.0, 5e3, 0.25});
    result.modes = {
        {"springs", {{hertz(1.1), hertz(3.0)}, both(constant({1.0, 0.0, 0.0}), constant({0.0, 1.0, 0.0})), 0, 0.25}},
        {"measure", {{hertz(1.0), hertz(4.0)}, both(constant({2.0, 0.0, 0.0}), constant({0.0, 0.0, 1.0})), 0, 1.5}}};
    const auto layout = results::modes_table(result, "measure");
    using Row = std::vector<std::string>;
    ASSERT_EQ(layout.columns.size(), 5U);
    EXPECT_EQ(layout.rows, (std::vector<Row>{{"1", "1.1000", "10.00", "1.000", "1.0000"},
                                             {"2", "3.0000", "-25.00", "0.000", "4.0000"},
                                             {"seconds", "0.25", "-", "-", "1.50"}}));
    EXPECT_EQ(results::modes_table(result, "nobody").columns.size(), 3U);
}

} // namespace
} // namespace livermark
