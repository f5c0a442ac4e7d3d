#include "fem_reference/relaxation/reduced_relaxation.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace livermark::fem_reference {

namespace {

/// A step length, and what is factored for it.
class ReducedStep {
  public:
    ReducedStep(const ReducedBody &body, const core::PronySeries &relaxation, double length)
        : body_(body), relaxation_(relaxation), branches_(core::branch_steps(relaxation, length)),
          first_(body.is_moved ? 1 : 0), num_free_(body.load.size() - first_),
          matrix_(body.volumetric + core::instant_part(relaxation, branches_) * body.deviatoric),
          factor_(matrix_.bottomRightCorner(num_free_, num_free_)) {}

    void advance(ReducedRecord &record, double factor) const;

  private:
    const ReducedBody &body_;
    const core::PronySeries &relaxation_;
    std::vector<core::BranchStep> branches_;
    Eigen::Index first_, num_free_;
    Eigen::MatrixXd matrix_; ///< with the stiffness of the step
    Eigen::LDLT<Eigen::MatrixXd> factor_;
};

void ReducedStep::advance(ReducedRecord &record, double factor) const {
    auto &memories = record.branches;
    const Eigen::VectorXd before = record.coordinates;
    const Eigen::VectorXd force_before = body_.volumetric * before + body_.deviatoric * record.relaxed;
    Eigen::VectorXd remembered = Eigen::VectorXd::Zero(before.size());
    for (std::size_t k = 0; k < branches_.size(); ++k)
        remembered += branches_[k].fade * memories[k] - branches_[k].gain * before;
    Eigen::VectorXd now = Eigen::VectorXd::Zero(before.size());
    if (body_.is_moved)
        now[0] = factor;
    const Eigen::VectorXd left = factor * body_.load - body_.deviatoric * remembered - matrix_ * now;
    if (num_free_ > 0)
        now.tail(num_free_) = factor_.solve(left.tail(num_free_));

    const Eigen::VectorXd change = now - before;
    record.coordinates = now;
    record.relaxed = relaxation_.remaining() * now;
    record.stored_energy =
        0.5 * now.dot(body_.volumetric * now) + 0.5 * relaxation_.remaining() * now.dot(body_.deviatoric * now);
    for (std::size_t k = 0; k < branches_.size(); ++k) {
        auto &memory = memories[k];
        record.dissipated_energy +=
            branches_[k].dissipated(memory.dot(body_.deviatoric * memory), memory.dot(body_.deviatoric * change),
                                    change.dot(body_.deviatoric * change));
        memory = branches_[k].fade * memory + branches_[k].gain * change;
        record.stored_energy += branches_[k].stored(memory.dot(body_.deviatoric * memory));
        record.relaxed += memory;
    }
    const Eigen::VectorXd force = body_.volumetric * now + body_.deviatoric * record.relaxed;
    record.work += 0.5 * (force_before + force).dot(change);
}

} // namespace

std::vector<ReducedRecord> follow(const ReducedBody &body, const core::SlowHistory &history, int steps_per_record) {
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(body.load.size());
    ReducedRecord now{.coordinates = zero,
                      .relaxed = zero,
                      .branches = std::vector<Eigen::VectorXd>(history.relaxation.moduli.size(), zero)};
    std::vector<ReducedRecord> records{now};
    for (int n = 1; n < history.num_records(); ++n) {
        const ReducedStep step(body, history.relaxation, (history.times[n] - history.times[n - 1]) / steps_per_record);
        for (int part = 1; part <= steps_per_record; ++part)
            step.advance(now, std::lerp(history.factors[n - 1], history.factors[n],
                                        static_cast<double>(part) / steps_per_record));
        records.push_back(now);
    }
    return records;
}

} // namespace livermark::fem_reference
