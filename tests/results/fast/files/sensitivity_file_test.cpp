#include "results/hdf5/files/sensitivity_file.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/result_files.hpp"
#include "results/tables/studies/sensitivity_table.hpp"
#include "support/whole_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"
#include "tests/samples/records/sample_sensitivity.hpp"

namespace livermark::results {
namespace {

using SensitivityFile = tests::ResultFolder;

void expect_same(const std::vector<double> &a, const std::vector<double> &b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        EXPECT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i]))) << a[i] << " " << b[i];
}

TEST_F(SensitivityFile, KeepsAllThatWasWritten) {
    const auto written = tests::sample_sensitivity();
    write_sensitivity(path_, written);
    EXPECT_EQ(kind_of_file(path_), FileKind::sensitivity);
    const auto read = read_sensitivity(path_);
    EXPECT_EQ(read.body, written.body);
    EXPECT_EQ(read.load_case, written.load_case);
    EXPECT_EQ(read.title, written.title);
    EXPECT_EQ(read.model, written.model);
    EXPECT_EQ(read.fingerprint, written.fingerprint);
    EXPECT_EQ(read.parameters, written.parameters);
    EXPECT_EQ(read.groups, written.groups);
    EXPECT_EQ(read.points, written.points);
    EXPECT_EQ(read.values, written.values);
    EXPECT_EQ(read.outputs, written.outputs);
    EXPECT_EQ(read.budget.reference, written.budget.reference);
    expect_same(read.budget.mesh, written.budget.mesh);
    expect_same(read.budget.law, written.budget.law);
    expect_same(read.budget.measurement, written.budget.measurement);
    ASSERT_EQ(read.budget.models.size(), 1u);
    EXPECT_EQ(read.budget.models[0].name, "springs");
    expect_same(read.budget.models[0].error, written.budget.models[0].error);
}

TEST_F(SensitivityFile, KeepsSamplesBeforeThereAreIndices) {
    auto written = tests::sample_sensitivity();
    written.outputs.clear();
    written.values.resize(3);
    write_sensitivity(path_, written);
    const auto read = read_sensitivity(path_);
    EXPECT_EQ(read.values, written.values);
    ASSERT_EQ(read.points.size(), 3u);
    EXPECT_EQ(read.points[2], written.points[2]);
    EXPECT_TRUE(read.outputs.empty());
}

TEST_F(SensitivityFile, OfAnotherKindIsRefused) {
    hdf5::OutputFile file;
    file.group("/sensitivity");
    support::write_whole(path_, file.image());
    tests::expect_input_error([&] { read_sensitivity(path_); }, {path_.string(), "schema_version"});
}

TEST_F(SensitivityFile, WithMoreOutputsThanValuesIsRefused) {
    auto written = tests::sample_sensitivity();
    for (auto &values : written.values)
        values.pop_back();
    write_sensitivity(path_, written);
    tests::expect_input_error([&] { read_sensitivity(path_); }, {path_.string(), "/sensitivity/outputs"});
}

TEST(UncertainParameter, IsBetweenItsEndsOnItsScale) {
    const auto parameters = tests::sample_sensitivity().parameters;
    EXPECT_DOUBLE_EQ(parameters[0].at(0.0), 4000.0);
    EXPECT_DOUBLE_EQ(parameters[0].at(0.25), 4500.0);
    EXPECT_NEAR(parameters[2].at(0.5), 1e6, 1e-6);
    EXPECT_NEAR(parameters[2].at(1.0), 1e7, 1e-5);
}

/// A variance is a sum of parts: without a parameter of which the first index is 3/4, half the deviation is left.
TEST(OutputSensitivity, LeavesTheRestOfTheVarianceWhereAParameterIsKnown) {
    const auto output = tests::sample_sensitivity().outputs[0];
    EXPECT_DOUBLE_EQ(output.relative_deviation(), 0.2);
    EXPECT_DOUBLE_EQ(output.relative_deviation(0), 0.1);
    EXPECT_DOUBLE_EQ(output.relative_deviation_of_group(0), 0.2 * std::sqrt(0.9));
}

TEST(SensitivityTables, HaveACellForEachColumn) {
    const auto sensitivity = tests::sample_sensitivity();
    for (const auto &layout : {output_table(sensitivity), index_table(sensitivity), budget_table(sensitivity)})
        for (const auto &row : layout.rows)
            EXPECT_EQ(row.size(), layout.columns.size());
    const auto budget = budget_table(sensitivity);
    EXPECT_EQ(budget.rows[0], (std::vector<std::string>{"spoon", "stiffness_at_tool", "0.2", "+4.0", "-3.5", "-",
                                                        "19.0", "7.7", "20.0", "10.0 (young_modulus)"}));
    EXPECT_EQ(index_table(sensitivity).rows[2][1], "100000 to 1e+07 Pa/m, logarithmic");
}

} // namespace
} // namespace livermark::results
