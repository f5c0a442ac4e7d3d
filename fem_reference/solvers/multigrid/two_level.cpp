#include "fem_reference/solvers/multigrid/two_level.hpp"

#include <algorithm>
#include <utility>

#include "fem_reference/solvers/multigrid/block_gauss_seidel.hpp"

namespace livermark::fem_reference {

namespace {

class TwoLevel : public Preconditioner {
  public:
    TwoLevel(Prolongation prolongation, const SymmetricBlocks<float> &rounded_fine, Preconditioner &coarse_solver)
        : coarse_solver_(coarse_solver), prolongation_(std::move(prolongation)), smoother_(rounded_fine),
          num_fine_(3 * rounded_fine.diagonal.size()), num_coarse_(3 * prolongation_.fine_node.size()) {}

    bool set_up(const FreeUnknowns &free) override {
        // A facet that is constrained is constrained at its coarse nodes too, and a coarse function that is zero there
        // is zero on the whole facet: the free coarse functions are free fine ones. The coarse solver may have been set
        // up for others in between, so it is asked every time.
        FreeUnknowns coarse_free{{}, free.set};
        for (const auto &set : free.sets) {
            auto &is_free = coarse_free.sets.emplace_back(num_coarse_);
            for (std::size_t dof = 0; dof < num_coarse_; ++dof)
                is_free[dof] = set[3 * prolongation_.fine_node[dof / 3] + dof % 3];
        }
        if (!coarse_solver_.set_up(coarse_free))
            return false;
        if (free == free_)
            return true;
        smoother_.set_up(free);
        coarse_constrained_ = constrained_entries(coarse_free);
        const auto lanes = static_cast<std::size_t>(free.lanes());
        fine_residual_.resize(num_fine_ * lanes);
        coarse_residual_.resize(num_coarse_ * lanes);
        coarse_correction_.resize(num_coarse_ * lanes);
        free_ = free;
        return true;
    }

    void apply(std::span<const float> residual, std::span<float> correction) override {
        smoother_.sweep_forward_from_zero(residual, correction, fine_residual_);
        prolongation_.restrict_to(fine_residual_, coarse_residual_);
        zero(coarse_constrained_, coarse_residual_);
        coarse_solver_.apply(coarse_residual_, coarse_correction_);
        prolongation_.add_prolonged(coarse_correction_, correction);
        smoother_.sweep_backward(residual, correction);
    }

    std::size_t max_columns() const override { return coarse_solver_.max_columns(); }
    std::string name() const override { return "two levels over " + coarse_solver_.name(); }

  private:
    Preconditioner &coarse_solver_;
    Prolongation prolongation_;
    BlockGaussSeidel smoother_;
    std::size_t num_fine_;
    std::size_t num_coarse_;
    FreeUnknowns free_;
    std::vector<std::size_t> coarse_constrained_;
    std::vector<float> fine_residual_;
    std::vector<float> coarse_residual_;
    std::vector<float> coarse_correction_;
};

} // namespace

std::unique_ptr<Preconditioner> two_level(Prolongation prolongation, const SymmetricBlocks<float> &rounded_fine,
                                          Preconditioner &coarse_solver) {
    return std::make_unique<TwoLevel>(std::move(prolongation), rounded_fine, coarse_solver);
}

SymmetricBlocks<double> galerkin(const Prolongation &prolongation, const SymmetricBlocks<double> &stiffness,
                                 const LowerRows &coarse_rows) {
    SymmetricBlocks<double> coarse{coarse_rows, {}, {}};
    coarse.below.assign(coarse_rows.column.size(), {});
    coarse.diagonal.assign(coarse_rows.num_nodes(), {});
    // Adds to the block of two coarse nodes, of which the first is not before the second.
    const auto add = [&](int row, int column, double weight, const Block<double> &block, bool is_transposed) {
        const auto first = coarse_rows.column.begin() + coarse_rows.row_start[row],
                   last = coarse_rows.column.begin() + coarse_rows.row_start[row + 1];
        auto &to = row == column ? coarse.diagonal[row]
                                 : coarse.below[std::lower_bound(first, last, column) - coarse_rows.column.begin()];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                to[3 * i + j] += weight * block[is_transposed ? 3 * j + i : 3 * i + j];
    };
    const auto for_each_pair = [&](std::size_t a, std::size_t b, const auto &action) {
        for (int k = prolongation.row_start[a]; k < prolongation.row_start[a + 1]; ++k)
            for (int l = prolongation.row_start[b]; l < prolongation.row_start[b + 1]; ++l)
                action(prolongation.coarse_node[k], prolongation.coarse_node[l],
                       prolongation.weight[k] * prolongation.weight[l]);
    };
    const auto &rows = stiffness.rows;
    for (std::size_t a = 0; a < rows.num_nodes(); ++a) {
        for_each_pair(a, a, [&](int i, int j, double weight) {
            if (i >= j)
                add(i, j, weight, stiffness.diagonal[a], false);
        });
        for (int k = rows.row_start[a]; k < rows.row_start[a + 1]; ++k)
            for_each_pair(a, rows.column[k], [&](int i, int j, double weight) {
                if (i >= j)
                    add(i, j, weight, stiffness.below[k], false);
                if (j >= i)
                    add(j, i, weight, stiffness.below[k], true);
            });
    }
    return coarse;
}

} // namespace livermark::fem_reference
