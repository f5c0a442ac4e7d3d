#include "support/factors/updated_cholesky.hpp"

#include <gtest/gtest.h>
#include <random>

#include "support/factors/sparse_cholesky.hpp"

namespace livermark {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// Springs on a line, from each mass to the next and to the one after, and weak ones to the ground.
struct Chain {
    int size;
    std::vector<Eigen::Triplet<double>> columns; ///< of all springs
    int num_springs = 0;

    explicit Chain(int num) : size(num) {
        std::mt19937 random(5);
        std::uniform_real_distribution<double> stiffness(0.5, 2.0);
        for (int i = 0; i < size; ++i)
            for (const int next : {i + 1, i + 2})
                if (next < size) {
                    const double root = std::sqrt(stiffness(random));
                    columns.emplace_back(i, num_springs, root);
                    columns.emplace_back(next, num_springs++, -root);
                }
    }

    /// The springs that a number of takes.
    template <class Takes> Matrix springs(const Takes &takes) const {
        std::vector<Eigen::Triplet<double>> taken;
        int count = 0, last = -1;
        for (const auto &entry : columns)
            if (takes(entry.col())) {
                count += entry.col() != last ? 1 : 0;
                last = entry.col();
                taken.emplace_back(entry.row(), count - 1, entry.value());
            }
        Matrix matrix(size, count);
        matrix.setFromTriplets(taken.begin(), taken.end());
        return matrix;
    }

    template <class Takes> Matrix stiffness(const Takes &takes) const {
        const Matrix c = springs(takes);
        Matrix ground(size, size);
        ground.setIdentity();
        return Matrix(c * Matrix(c.transpose())) + 0.01 * ground;
    }
};

/// What a factor that is made again says.
Eigen::VectorXd made_again(const Matrix &matrix, const Eigen::VectorXd &load) {
    support::SparseCholesky factor;
    factor.order(matrix);
    EXPECT_TRUE(factor.factorise(matrix));
    return factor.solve(load);
}

TEST(UpdatedCholesky, SolvesAsAFactorThatIsMadeAgainAfterSpringsAreTakenAway) {
    const Chain chain(300);
    const auto is_cut = [](int spring) { return spring % 7 == 3; };
    const auto all = [](int) { return true; };
    support::UpdatedCholesky factor(chain.stiffness(all));
    factor.subtract(chain.springs(is_cut));
    const Eigen::VectorXd load = Eigen::VectorXd::LinSpaced(chain.size, -1.0, 2.0);
    const auto expected = made_again(chain.stiffness([&](int spring) { return !is_cut(spring); }), load);
    EXPECT_LT((factor.solve(load) - expected).norm(), 1e-9 * expected.norm());
    factor.add(chain.springs(is_cut));
    const auto whole = made_again(chain.stiffness(all), load);
    EXPECT_GT((whole - expected).norm(), 1e-3 * whole.norm());
    EXPECT_LT((factor.solve(load) - whole).norm(), 1e-9 * whole.norm());
}

} // namespace
} // namespace livermark
