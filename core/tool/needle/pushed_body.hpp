#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>

namespace livermark::core {

/// Places of a needle at rest under forces on them, and the energy that the body stores then.
struct PushedPlaces {
    Eigen::VectorXd displacement; ///< (3 K) means over the places [m]
    double stored = 0.0;          ///< strain energy [J]
};

/// A body as a needle sees it: places inside it that move under dead forces on them, slowly. Component i of place k has
/// number 3 k + i. A place is made of the same material points at every force, those of its ball at rest (see
/// InteriorPlace).
class PushedBody {
  public:
    PushedBody() = default;
    virtual ~PushedBody() = default;
    PushedBody(const PushedBody &) = delete;
    PushedBody &operator=(const PushedBody &) = delete;

    /// C, shape (3 K, 3 K) [m/N]: du / df of the body at rest, or near it. A linear body has it at every force; of
    /// another it is what a search for forces begins with, and no result depends on it.
    virtual const Eigen::MatrixXd &compliance() const = 0;

    /// Equilibrium under forces. A search for it begins at the last one that was found.
    /// @param force  shape (3 K) [N], in directions that stay in space
    /// @return nothing if no equilibrium is found
    virtual std::optional<PushedPlaces> push(const Eigen::VectorXd &force) = 0;
};

/// A linear body: u = C f.
class LinearPushedBody : public PushedBody {
  public:
    /// @param compliance  symmetric but for what solvers leave
    explicit LinearPushedBody(const Eigen::MatrixXd &compliance)
        : compliance_(0.5 * (compliance + compliance.transpose())) {}

    const Eigen::MatrixXd &compliance() const override { return compliance_; }
    std::optional<PushedPlaces> push(const Eigen::VectorXd &force) override {
        Eigen::VectorXd displacement = compliance_ * force;
        const double stored = 0.5 * force.dot(displacement);
        return PushedPlaces{std::move(displacement), stored};
    }

  private:
    Eigen::MatrixXd compliance_;
};

/// Goes from one force to another at once, or else in 2, 4, ... 32 equal parts, until an equilibrium is found.
/// @param begin  called before each attempt: goes back to where the body was under the first force
/// @param go_to  finds the equilibrium under a force (3 K) [N], from the last one; whether it did
/// @return whether it arrived
template <class Begin, class GoTo>
bool push_in_parts(const Eigen::VectorXd &from, const Eigen::VectorXd &to, const Begin &begin, const GoTo &go_to) {
    constexpr int most_parts = 32;
    for (int parts = 1; parts <= most_parts; parts *= 2) {
        begin();
        bool is_there = true;
        for (int part = 1; is_there && part <= parts; ++part)
            is_there = go_to(from + (to - from) * part / parts);
        if (is_there)
            return true;
    }
    return false;
}

} // namespace livermark::core
