#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <utility>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "fem_reference/cell_rows.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"

namespace livermark {
namespace {

using fem_reference::CellEntries;

/// Corners of tetrahedra, one behind the other.
std::vector<int> corners_of(const core::TetraMesh &mesh) {
    std::vector<int> corners;
    for (const auto &nodes : mesh.tetrahedra)
        corners.insert(corners.end(), nodes.begin(), nodes.end());
    return corners;
}

/// The pairs of a row and a column that have an entry.
std::set<std::pair<int, int>> entries(const fem_reference::CellRows &rows) {
    std::set<std::pair<int, int>> all;
    for (std::size_t row = 0; row + 1 < rows.row_start.size(); ++row)
        for (int k = rows.row_start[row]; k < rows.row_start[row + 1]; ++k)
            all.emplace(static_cast<int>(row), rows.column[k]);
    return all;
}

class CellRowsOfABox : public testing::Test {
  protected:
    core::TetraMesh mesh = tests::shaken_box_mesh({0.1, 0.08, 0.06}, {3, 2, 2});
    std::vector<int> nodes = corners_of(mesh);

    fem_reference::CellRows rows(CellEntries wanted) const {
        return fem_reference::cell_rows(nodes, 4, mesh.num_nodes(), nodes, 4, mesh.num_nodes(), wanted);
    }
};

TEST_F(CellRowsOfABox, HaveThePairsOfAllCellsOnceInOrder) {
    std::set<std::pair<int, int>> all, below;
    for (std::size_t k = 0; k < nodes.size(); ++k)
        for (std::size_t other = k - k % 4; other < k - k % 4 + 4; ++other) {
            all.emplace(nodes[k], nodes[other]);
            if (nodes[other] < nodes[k])
                below.emplace(nodes[k], nodes[other]);
        }
    for (const auto &[wanted, expected] : {std::pair(CellEntries::all, all), {CellEntries::below_diagonal, below}}) {
        const auto found = rows(wanted);
        EXPECT_EQ(found.column.size(), expected.size());
        EXPECT_EQ(entries(found), expected);
        for (int row = 0; row < mesh.num_nodes(); ++row)
            EXPECT_TRUE(std::is_sorted(found.column.begin() + found.row_start[row],
                                       found.column.begin() + found.row_start[row + 1]));
    }
}

TEST_F(CellRowsOfABox, KnowWhereEachPairOfACellStands) {
    for (const auto wanted : {CellEntries::all, CellEntries::below_diagonal}) {
        const auto found = rows(wanted);
        ASSERT_EQ(found.place.size(), 4 * nodes.size());
        for (std::size_t pair = 0; pair < found.place.size(); ++pair) {
            const int row = nodes[pair / 4], column = nodes[4 * (pair / 16) + pair % 4], at = found.place[pair];
            if (wanted == CellEntries::below_diagonal && column >= row) {
                EXPECT_EQ(at, -1);
                continue;
            }
            ASSERT_GE(at, found.row_start[row]);
            ASSERT_LT(at, found.row_start[row + 1]);
            EXPECT_EQ(found.column[at], column);
        }
    }
}

TEST(CellRows, LeaveOutCellsThatHaveNoRow) {
    const std::vector rows{-1, -1, 1, 0}, columns{7, 8, 9, 4, 5, 2};
    const auto found = fem_reference::cell_rows(rows, 2, 2, columns, 3, 10);
    EXPECT_EQ(found.row_start, (std::vector{0, 3, 6}));
    EXPECT_EQ(found.column, (std::vector{2, 4, 5, 2, 4, 5}));
    EXPECT_EQ(found.place, (std::vector{-1, -1, -1, -1, -1, -1, 4, 5, 3, 1, 2, 0}));
}

} // namespace
} // namespace livermark
