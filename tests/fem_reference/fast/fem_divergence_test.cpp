#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <vector>

#include "fem_reference/linear/pressure_system.hpp"
#include "tests/fem_reference/dense_divergence.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {
namespace {

template <class T> void expect_products_of(const fem_reference::DivergenceRows<T> &rows, const Eigen::MatrixXd &full) {
    for (const int lanes : {1, 4, 8}) {
        SCOPED_TRACE(lanes);
        const auto some = [lanes](Eigen::Index size, int seed) {
            std::vector<T> values(lanes * size);
            for (std::size_t i = 0; i < values.size(); ++i)
                values[i] = static_cast<T>((7 * static_cast<int>(i) + seed) % 23 - 11);
            return values;
        };
        const auto of_columns = [lanes](const std::vector<T> &values) -> Eigen::MatrixXd {
            using Together = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
            return Together::Map(values.data(), static_cast<Eigen::Index>(values.size()) / lanes, lanes)
                .template cast<double>();
        };
        const auto near = [&](const std::vector<T> &found, const Eigen::MatrixXd &expected) {
            EXPECT_LT((of_columns(found) - expected).norm(),
                      30.0 * static_cast<double>(std::numeric_limits<T>::epsilon()) * expected.norm());
        };
        const auto u = some(full.cols(), 3), g = some(full.rows(), 5), force = some(full.cols(), 8);
        std::vector<T> less(g.size()), summed = force, imbalance = g;
        rows.subtract_product(u, g, less, lanes);
        near(less, full * of_columns(u) - of_columns(g));
        rows.add_products(u, g, summed, imbalance, lanes);
        near(summed, of_columns(force) + full.transpose() * of_columns(g));
        near(imbalance, full * of_columns(u) - of_columns(g));
    }
}

TEST(FemDivergence, ProductsAreThoseOfTheMatrix) {
    core::Body body;
    body.mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    body.mesh.region_names = {"left", "right"};
    for (std::size_t t = 0; t < body.mesh.region.size() / 2; ++t)
        body.mesh.region[t] = 1;
    body.materials = {{1060.0, 5000.0, 0.45}, {1060.0, 50000.0, 0.499}};
    const auto system = fem_reference::assemble(fem_reference::without_pressure(body), 2);
    auto rows = fem_reference::assemble_pressure(body, system).divergence;
    for (auto &of_node : rows.value) // of the size of what they are multiplied with
        for (double &value : of_node)
            value *= 1e4;
    const auto full = tests::dense(rows, 3 * system.num_nodes());
    ASSERT_GT(full.norm(), 0.0);
    expect_products_of(rows, full);
    expect_products_of(rounded(rows), full);
}

} // namespace
} // namespace livermark
