#include "fem_reference/solvers/multigrid/block_gauss_seidel.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace livermark::fem_reference {

namespace {

using FloatBlock = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

Block<float> rounded(const Eigen::Matrix3d &block) {
    Block<float> result;
    FloatBlock::Map(result.data()) = block.cast<float>();
    return result;
}

/// Of the free rows and columns, otherwise zero.
Eigen::Matrix3d inverse_of_free(const Block<float> &block, const Eigen::Array3d &is_free) {
    const Eigen::Matrix3d chosen = is_free.matrix() * is_free.matrix().transpose();
    const Eigen::Matrix3d of_free = FloatBlock::Map(block.data()).cast<double>().cwiseProduct(chosen);
    return (of_free + (1.0 - is_free).matrix().asDiagonal().toDenseMatrix()).inverse().cwiseProduct(chosen);
}

} // namespace

BlockGaussSeidel::BlockGaussSeidel(const SymmetricBlocks<float> &matrix) : matrix_(matrix) {
    const Eigen::Array3d all_free = Eigen::Array3d::Ones();
    for (const auto &block : matrix_.diagonal)
        inverse_diagonal_.push_back(rounded(inverse_of_free(block, all_free)));
}

void BlockGaussSeidel::set_up(const FreeUnknowns &free) {
    lanes_ = free.lanes();
    taken_.assign(3 * lanes_ * matrix_.rows.num_nodes(), 0.0F);
    constrained_.assign(matrix_.rows.num_nodes(), -1);
    constrained_inverse_.clear();
    is_free_.clear();
    for (std::size_t at = 0; at < matrix_.rows.num_nodes(); ++at) {
        std::vector<Eigen::Array3d> of_set;
        for (const auto &set : free.sets) {
            auto &is_free = of_set.emplace_back();
            for (int i = 0; i < 3; ++i)
                is_free[i] = set[3 * at + i] ? 1.0 : 0.0;
        }
        if (std::ranges::all_of(of_set, [](const auto &is_free) { return is_free.minCoeff() > 0.0; }))
            continue;
        constrained_[at] = static_cast<int>(is_free_.size()) / (3 * lanes_);
        std::vector<Eigen::Matrix3d> inverse;
        for (const auto &is_free : of_set)
            inverse.push_back(inverse_of_free(matrix_.diagonal[at], is_free));
        for (int entry = 0; entry < 9; ++entry)
            for (const int set : free.set)
                constrained_inverse_.push_back(static_cast<float>(inverse[set](entry / 3, entry % 3)));
        for (int i = 0; i < 3; ++i)
            for (const int set : free.set)
                is_free_.push_back(static_cast<float>(of_set[set][i]));
    }
}

/// The rows of one sweep.
template <int lanes> class BlockGaussSeidel::Sweep {
  public:
    static constexpr std::size_t width = 3 * lanes;
    using Vector = Triple<float, lanes>;

    Sweep(BlockGaussSeidel &smoother, std::span<float> u) : of(smoother), now(u) { std::ranges::fill(of.taken_, 0.0F); }

    /// Solves the row of a node for it.
    /// @param others  what the other nodes take
    [[gnu::always_inline]] void solve(std::size_t at, const float *right_hand_side, const Vector &others) {
        Vector left(right_hand_side), solved;
        left.x -= others.x;
        left.y -= others.y;
        left.z -= others.z;
        if (of.constrained_[at] < 0) {
            add_product(of.inverse_diagonal_[at], left, solved);
        } else {
            const float *const inverse = &of.constrained_inverse_[3 * width * of.constrained_[at]];
            const Vector first(inverse), second(inverse + width), third(inverse + 2 * width);
            solved.x = first.x * left.x + first.y * left.y + first.z * left.z;
            solved.y = second.x * left.x + second.y * left.y + second.z * left.z;
            solved.z = third.x * left.x + third.y * left.y + third.z * left.z;
        }
        solved.put(&now[width * at]);
    }

    /// What the nodes before one take from its row, and the other way round.
    [[gnu::always_inline]] void take(int k, Vector &sum) {
        add_product(of.matrix_.below[k], Vector(&now[width * of.matrix_.rows.column[k]]), sum);
    }
    [[gnu::always_inline]] void give(int k, const Vector &here) {
        float *const place = &of.taken_[width * of.matrix_.rows.column[k]];
        Vector there(place);
        add_transposed(of.matrix_.below[k], here, there);
        there.put(place);
    }

    BlockGaussSeidel &of;
    std::span<float> now; ///< (n, 3, lanes)
};

template <int lanes>
[[gnu::always_inline]] inline void BlockGaussSeidel::forward(std::span<const float> right_hand_side, std::span<float> u,
                                                             std::span<float> residual) {
    constexpr auto width = Sweep<lanes>::width;
    Sweep<lanes> sweep(*this, u);
    for (std::size_t at = 0; at < matrix_.rows.num_nodes(); ++at) {
        const auto place = width * at;
        Triple<float, lanes> before;
        for (int k = matrix_.rows.row_start[at]; k < matrix_.rows.row_start[at + 1]; ++k) {
            ask_ahead(&matrix_.below[k], 1);
            sweep.take(k, before);
        }
        sweep.solve(at, &right_hand_side[place], before);
        const Triple<float, lanes> here(&u[place]);
        for (int k = matrix_.rows.row_start[at]; k < matrix_.rows.row_start[at + 1]; ++k)
            sweep.give(k, here);
    }
    // A sweep leaves of each row only what lies behind the diagonal.
    for (std::size_t at = 0; at < matrix_.rows.num_nodes(); ++at) {
        const auto place = width * at;
        const float *const is_free = constrained_[at] < 0 ? nullptr : &is_free_[width * constrained_[at]];
        for (std::size_t i = 0; i < width; ++i)
            residual[place + i] = is_free ? -taken_[place + i] * is_free[i] : -taken_[place + i];
    }
}

template <int lanes>
[[gnu::always_inline]] inline void BlockGaussSeidel::backward(std::span<const float> right_hand_side,
                                                              std::span<float> u) {
    constexpr auto width = Sweep<lanes>::width;
    Sweep<lanes> sweep(*this, u);
    for (std::size_t at = matrix_.rows.num_nodes(); at-- > 0;) {
        const auto place = width * at;
        Triple<float, lanes> others(&taken_[place]);
        for (int k = matrix_.rows.row_start[at + 1] - 1; k >= matrix_.rows.row_start[at]; --k) {
            ask_ahead(&matrix_.below[k], -1);
            sweep.take(k, others);
        }
        sweep.solve(at, &right_hand_side[place], others);
        const Triple<float, lanes> here(&u[place]);
        for (int k = matrix_.rows.row_start[at + 1] - 1; k >= matrix_.rows.row_start[at]; --k)
            sweep.give(k, here);
    }
}

LIVERMARK_WIDE_CLONES
void BlockGaussSeidel::sweep_forward_from_zero(std::span<const float> right_hand_side, std::span<float> u,
                                               std::span<float> residual) {
    switch (lanes_) { // a lambda would be compiled for one processor
    case 1:
        return forward<1>(right_hand_side, u, residual);
    case 4:
        return forward<4>(right_hand_side, u, residual);
    default:
        return forward<most_lanes>(right_hand_side, u, residual);
    }
}

LIVERMARK_WIDE_CLONES
void BlockGaussSeidel::sweep_backward(std::span<const float> right_hand_side, std::span<float> u) {
    switch (lanes_) {
    case 1:
        return backward<1>(right_hand_side, u);
    case 4:
        return backward<4>(right_hand_side, u);
    default:
        return backward<most_lanes>(right_hand_side, u);
    }
}

} // namespace livermark::fem_reference
