#include "fem_reference/solvers/two_level.hpp"

#include "fem_reference/solvers/block_gauss_seidel.hpp"
#include "fem_reference/solvers/prolongation.hpp"

namespace livermark::fem_reference {

namespace {

class TwoLevel : public Preconditioner {
  public:
    TwoLevel(const ElasticSystem &fine, const SymmetricBlocks<float> &rounded_fine, const ElasticSystem &coarse,
             Preconditioner &coarse_solver, std::span<const int> parent)
        : coarse_solver_(coarse_solver), prolongation_(prolongation(coarse, fine, parent)), smoother_(rounded_fine),
          num_fine_(3 * fine.points.size()), num_coarse_(3 * coarse.points.size()) {}

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

std::unique_ptr<Preconditioner> two_level(const ElasticSystem &fine, const SymmetricBlocks<float> &rounded_fine,
                                          const ElasticSystem &coarse, Preconditioner &coarse_solver,
                                          std::span<const int> parent) {
    return std::make_unique<TwoLevel>(fine, rounded_fine, coarse, coarse_solver, parent);
}

} // namespace livermark::fem_reference
