#include "msm/statics/pushed_springs.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "msm/nodal_conditions.hpp"
#include "msm/statics/compliance.hpp"
#include "msm/statics/equilibrium.hpp"

namespace livermark::msm {

namespace {

using Field = std::vector<core::Vector3>;
using Weights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Of forces out of balance: places move by less than a micrometre for them.
constexpr double push_tolerance = 1e-8;

NodalConditions conditions_at_rest(const core::Problem &problem, const std::vector<double> &node_mass) {
    auto conditions = nodal_conditions(problem, node_mass);
    for (auto &of_node : conditions.displacement)
        for (double &value : of_node)
            value = std::isnan(value) ? value : 0.0;
    conditions.press_depth = 0.0;
    return conditions;
}

class PushedSprings : public core::PushedBody {
  public:
    PushedSprings(ElasticBody body, const core::Problem &problem, std::span<const core::InteriorPlace> places)
        : body_(std::move(body)), points_(problem.body->mesh.points),
          compliance_(msm::compliance(body_, problem, places).matrix),
          weights_(core::nodal_weights(places, problem.body->mesh)),
          conditions_(conditions_at_rest(problem, body_.node_mass)), rest_(body_, points_, conditions_.displacement),
          displacement_(points_.size(), core::Vector3::Zero()), force_(Eigen::VectorXd::Zero(3 * weights_.rows())) {}

    const Eigen::MatrixXd &compliance() const override { return compliance_; }

    std::optional<core::PushedPlaces> push(const Eigen::VectorXd &force) override {
        Field there;
        const auto go_to = [&](const Eigen::VectorXd &part) {
            load(part);
            auto found = find_equilibrium(body_, points_, conditions_, rest_,
                                          {.tolerance = push_tolerance, .memory = &memory_, .bears_rounding = true},
                                          std::move(there));
            there = std::move(found.displacement);
            return found.status == core::SolutionStatus::ok;
        };
        if (!core::push_in_parts(
                force_, force, [&] { there = displacement_; }, go_to))
            return std::nullopt;
        displacement_ = std::move(there);
        force_ = force;
        return found();
    }

  private:
    void load(const Eigen::VectorXd &force) {
        std::ranges::fill(conditions_.force, core::Vector3::Zero());
        for (Eigen::Index place = 0; place < weights_.rows(); ++place)
            for (Weights::InnerIterator entry(weights_, place); entry; ++entry)
                conditions_.force[entry.col()] += entry.value() * force.segment<3>(3 * place);
    }

    core::PushedPlaces found() const {
        Field positions(points_.size());
        std::ranges::transform(points_, displacement_, positions.begin(),
                               [](const auto &x, const auto &u) -> core::Vector3 { return x + u; });
        core::PushedPlaces places{Eigen::VectorXd(3 * weights_.rows()), elastic_energy(body_, positions)};
        for (Eigen::Index place = 0; place < weights_.rows(); ++place) {
            core::Vector3 mean = core::Vector3::Zero();
            for (Weights::InnerIterator entry(weights_, place); entry; ++entry)
                mean += entry.value() * displacement_[entry.col()];
            places.displacement.segment<3>(3 * place) = mean;
        }
        return places;
    }

    ElasticBody body_;
    Field points_;
    Eigen::MatrixXd compliance_;
    Weights weights_; ///< (K, N)
    NodalConditions conditions_;
    RestStiffness rest_;
    LimitedMemory memory_{most_remembered};
    Field displacement_;    ///< (N) [m]
    Eigen::VectorXd force_; ///< (3 K) that it is in equilibrium under [N]
};

} // namespace

std::unique_ptr<core::PushedBody> pushed_springs(ElasticBody body, const core::Problem &problem,
                                                 std::span<const core::InteriorPlace> places) {
    return std::make_unique<PushedSprings>(std::move(body), problem, places);
}

} // namespace livermark::msm
