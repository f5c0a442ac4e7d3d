#include "fem_reference/hyperelastic/pushed_elements.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "fem_reference/dof_conditions.hpp"
#include "fem_reference/facet_conditions.hpp"
#include "fem_reference/hyperelastic/one_process_system.hpp"
#include "fem_reference/hyperelastic/paths/equilibrium_search.hpp"
#include "fem_reference/linear/place_weights.hpp"
#include "support/input_error.hpp"

namespace livermark::hyperelastic {

namespace {

using Eigen::VectorXd;

LoadPath path_of_pushes() {
    LoadPath path;
    path.tolerance = 1e-5; // of forces out of balance: places move by less than a micrometre for them
    return path;
}

fem_reference::DofConditions held_at_rest(const core::Problem &problem, const fem_reference::ElasticSystem &system) {
    fem_reference::check_facets(problem.load_case, problem.body->mesh);
    auto conditions = fem_reference::dof_conditions(problem.load_case, system);
    for (double &value : conditions.prescribed)
        value = std::isnan(value) ? value : 0.0;
    std::ranges::fill(conditions.load, 0.0);
    conditions.press_depth = 0.0;
    return conditions;
}

class PushedElements : public core::PushedBody {
  public:
    PushedElements(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                   std::span<const core::InteriorPlace> places, Eigen::MatrixXd compliance)
        : elements_(problem.body, discretisation.degree, discretisation.formulation, law,
                    discretisation.degree == 1 ? TetrahedronRule::one_point : discretisation.rule),
          conditions_(held_at_rest(problem, elements_.system())),
          weights_(fem_reference::place_weights(places, elements_.system(), problem.body->mesh)),
          compliance_(std::move(compliance)), system_(elements_, conditions_, {}),
          search_(system_, problem.load_case.num_constraints(), path_, steps_), at_{system_.rest(), 1.0},
          force_(VectorXd::Zero(3 * weights_.rows())) {
        if (!search_.begin())
            throw support::InputError(fmt::format("{}: load case '{}' leaves the body free to move; constrain it, or "
                                                  "leave this model out",
                                                  problem.body->name, problem.load_case.name));
    }

    const Eigen::MatrixXd &compliance() const override { return compliance_; }

    std::optional<core::PushedPlaces> push(const VectorXd &force) override {
        auto there = at_;
        const auto begin = [&] {
            there = at_;
            steps_ = {};
        };
        const auto go_to = [&](const VectorXd &part) {
            load(part);
            LoadStep step;
            const bool is_there = search_.settle(there, step);
            if (!is_there)
                search_.distrust_factor();
            return is_there;
        };
        if (!core::push_in_parts(force_, force, begin, go_to))
            return std::nullopt;
        at_ = std::move(there);
        force_ = force;
        return found();
    }

  private:
    void load(const VectorXd &force) {
        using RowsOfComponents = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
        const Eigen::Map<const RowsOfComponents> of_places(force.data(), weights_.rows(), 3);
        Eigen::Map<RowsOfComponents>(conditions_.load.data(), weights_.cols(), 3) = weights_.transpose() * of_places;
    }

    core::PushedPlaces found() const {
        core::PushedPlaces places{VectorXd(3 * weights_.rows()), elements_.internal_forces(at_.state).energy};
        for (Eigen::Index place = 0; place < weights_.rows(); ++place) {
            core::Vector3 mean = core::Vector3::Zero();
            for (decltype(weights_)::InnerIterator entry(weights_, place); entry; ++entry)
                mean += entry.value() * core::Vector3::Map(&at_.state.displacement[3 * entry.col()]);
            places.displacement.segment<3>(3 * place) = mean;
        }
        return places;
    }

    Elements elements_;
    fem_reference::DofConditions conditions_;
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights_; ///< (K, n)
    Eigen::MatrixXd compliance_;
    LoadPath path_ = path_of_pushes();
    FollowedPath steps_;
    OneProcessSystem system_;
    EquilibriumSearch search_;
    LoadedState at_;
    VectorXd force_; ///< (3 K) that it is in equilibrium under [N]
};

} // namespace

std::unique_ptr<core::PushedBody> pushed_elements(const core::Problem &problem, const MaterialLaw &law,
                                                  const Discretisation &discretisation,
                                                  std::span<const core::InteriorPlace> places,
                                                  Eigen::MatrixXd compliance) {
    return std::make_unique<PushedElements>(problem, law, discretisation, places, std::move(compliance));
}

} // namespace livermark::hyperelastic
