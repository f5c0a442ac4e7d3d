#include "fem_reference/two_level.hpp"

#include <optional>

#include "fem_reference/block_gauss_seidel.hpp"
#include "fem_reference/prolongation.hpp"

namespace livermark::fem_reference {

namespace {

class TwoLevel : public Preconditioner {
  public:
    TwoLevel(const ElasticSystem &fine, const ElasticSystem &coarse, Preconditioner &coarse_solver)
        : fine_(fine), coarse_solver_(coarse_solver), prolongation_(prolongation(coarse, fine)),
          fine_residual_(3 * fine.points.size()), coarse_residual_(3 * coarse.points.size()),
          coarse_correction_(coarse_residual_.size()) {}

    bool set_up(const std::vector<bool> &is_free) override {
        // A facet that is held is held at its coarse nodes too, and a coarse function that is zero there is zero on the
        // whole facet: the free coarse functions are free fine ones. The coarse solver may have been set up for others
        // in between, so it is asked every time.
        coarse_is_free_.resize(coarse_residual_.size());
        for (std::size_t dof = 0; dof < coarse_is_free_.size(); ++dof)
            coarse_is_free_[dof] = is_free[3 * prolongation_.fine_node[dof / 3] + dof % 3];
        if (!coarse_solver_.set_up(coarse_is_free_))
            return false;
        if (!smoother_ || is_free != is_free_) {
            smoother_.reset(); // the old one goes before the new one needs the memory
            smoother_.emplace(fine_.stiffness, is_free);
            is_free_ = is_free;
        }
        return true;
    }

    void apply(std::span<const double> residual, std::span<double> correction) override {
        smoother_->sweep_forward_from_zero(residual, correction, fine_residual_);
        prolongation_.restrict_to(fine_residual_, coarse_residual_);
        for (std::size_t dof = 0; dof < coarse_residual_.size(); ++dof)
            if (!coarse_is_free_[dof])
                coarse_residual_[dof] = 0.0;
        coarse_solver_.apply(coarse_residual_, coarse_correction_);
        prolongation_.add_prolonged(coarse_correction_, correction);
        smoother_->sweep_backward(residual, correction);
    }

    std::string name() const override { return "two levels over " + coarse_solver_.name(); }

  private:
    const ElasticSystem &fine_;
    Preconditioner &coarse_solver_;
    Prolongation prolongation_;
    std::vector<bool> is_free_;
    std::vector<bool> coarse_is_free_;
    std::optional<BlockGaussSeidel> smoother_;
    std::vector<double> fine_residual_;
    std::vector<double> coarse_residual_;
    std::vector<double> coarse_correction_;
};

} // namespace

std::unique_ptr<Preconditioner> two_level(const ElasticSystem &fine, const ElasticSystem &coarse,
                                          Preconditioner &coarse_solver) {
    return std::make_unique<TwoLevel>(fine, coarse, coarse_solver);
}

} // namespace livermark::fem_reference
