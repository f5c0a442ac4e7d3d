#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

namespace livermark::core {

/// The f of least 1/2 f . A f - b . f with low <= f <= high, by principal pivoting (Judice and Pires 1992, Basic-set
/// algorithm for a generalized linear complementarity problem, J. Optim. Theory Appl. 74), one after the other: which
/// entries are at a limit is tried first as it was before, so that a problem that is like the last one takes one go.
class LeastWithinLimits {
  public:
    /// @param matrix  A, symmetric and positive definite, shape (n, n)
    /// @param b       (n), as are the limits; an entry whose limits are equal is there
    /// @return (n), until the next call
    const Eigen::VectorXd &solve(const Eigen::Ref<const Eigen::MatrixXd> &matrix,
                                 const Eigen::Ref<const Eigen::VectorXd> &b,
                                 const Eigen::Ref<const Eigen::VectorXd> &low,
                                 const Eigen::Ref<const Eigen::VectorXd> &high);

    /// Forgets what was at a limit.
    void forget() { side_.clear(); }

  private:
    enum class Side { low, free, high };
    struct Change {
        Eigen::Index entry;
        Side to;
    };
    void find_free(const Eigen::Ref<const Eigen::MatrixXd> &matrix);

    std::vector<Side> side_;         // (n)
    std::vector<Eigen::Index> free_; // those that are at no limit
    std::vector<Change> changes_;
    Eigen::MatrixXd block_; // A of the free ones
    Eigen::LLT<Eigen::MatrixXd> factor_;
    Eigen::VectorXd x_, right_, free_values_, gradient_;
};

/// The same of one problem.
Eigen::VectorXd least_within_limits(const Eigen::MatrixXd &matrix, const Eigen::VectorXd &b, const Eigen::VectorXd &low,
                                    const Eigen::VectorXd &high);

} // namespace livermark::core
