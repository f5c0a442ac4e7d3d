#include "fem_reference/hyperelastic/slow_path.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>
#include <vector>

#include "core/stopwatch.hpp"
#include "fem_reference/hyperelastic/equilibrium_search.hpp"
#include "fem_reference/hyperelastic/hyperelasticity.hpp"
#include "fem_reference/linear/conditions.hpp"

namespace livermark::hyperelastic {

namespace {

/// Before it gives up, in parts of the time between two records.
constexpr double smallest_part_of_record = 1.0 / 64.0;

/// A body on its way through a history.
class SlowBody {
  public:
    SlowBody(Elements &elements, const fem_reference::DofConditions &conditions, int num_constraints,
             std::span<const double> follower_pressure, const LoadPath &path, const core::PronySeries &relaxation)
        : elements_(elements), relaxation_(relaxation), system_(elements, conditions, follower_pressure),
          search_(system_, num_constraints, path, followed_), at_{system_.rest()} {
        const auto num_points = elements.point_volumes().size();
        memory_.remembered.assign(num_points, Matrix3::Zero());
        stress_ = memory_.remembered;
        branches_.assign(relaxation.moduli.size(), memory_.remembered);
        force_.assign(at_.state.displacement.size(), 0.0);
        elements_.set_memory(&memory_);
    }
    ~SlowBody() { elements_.set_memory(nullptr); }
    SlowBody(const SlowBody &) = delete;
    SlowBody &operator=(const SlowBody &) = delete;

    bool begin() { return search_.begin(); }

    /// @param from, to  factors of the loads
    /// @return whether there is equilibrium after it
    bool advance(double duration, double from, double to) {
        const auto steps = core::branch_steps(relaxation_, duration);
        const auto before = memory_;
        memory_.faded = 1.0 - core::instant_part(relaxation_, steps);
        for (std::size_t p = 0; p < stress_.size(); ++p) {
            memory_.remembered[p].setZero();
            for (std::size_t k = 0; k < steps.size(); ++k)
                memory_.remembered[p] += steps[k].fade * branches_[k][p] - steps[k].gain * stress_[p];
        }
        const auto displacement = at_.state.displacement;
        LoadStep step{.fraction = to, .converged = false, .residuals = {}, .linear_iterations = {}};
        const bool done = search_.advance(at_, from, to, step);
        followed_.steps.push_back(std::move(step));
        if (!done) {
            memory_ = before;
            search_.distrust_factor();
            return false;
        }
        const auto now = elements_.isochoric_stresses(at_.state);
        const auto volumes = elements_.point_volumes();
        for (std::size_t p = 0; p < now.size(); ++p) {
            const Matrix3 change = now[p] - stress_[p];
            for (std::size_t k = 0; k < steps.size(); ++k) {
                auto &branch = branches_[k][p];
                dissipated_ +=
                    volumes[p] / (2.0 * shear_modulus_at(p)) *
                    steps[k].dissipated(branch.squaredNorm(), branch.cwiseProduct(change).sum(), change.squaredNorm());
                branch = steps[k].fade * branch + steps[k].gain * change;
            }
        }
        stress_ = now;
        const auto force = elements_.internal_forces(at_.state).force;
        for (std::size_t dof = 0; dof < force.size(); ++dof)
            work_ += 0.5 * (force[dof] + force_[dof]) * (at_.state.displacement[dof] - displacement[dof]);
        force_ = force;
        return true;
    }

    PathPoint point(double factor) const { return search_.point(at_, factor); }
    double work() const { return work_; }
    /// Heat of the dashpots of branches so far, with the moduli of stored_energy() [J].
    double dissipated_energy() const { return dissipated_; }
    const FollowedPath &followed() const { return followed_; }

    /// See solve_history().
    double stored_energy() {
        const DeviatoricMemory after_all{.faded = 1.0 - relaxation_.remaining(),
                                         .remembered = std::vector(stress_.size(), Matrix3(Matrix3::Zero()))};
        elements_.set_memory(&after_all);
        double energy = elements_.internal_forces(at_.state).energy;
        elements_.set_memory(&memory_);
        const auto volumes = elements_.point_volumes();
        for (std::size_t p = 0; p < volumes.size(); ++p)
            for (std::size_t k = 0; k < branches_.size(); ++k)
                if (const double modulus = relaxation_.moduli[k]; modulus > 0.0)
                    energy += volumes[p] * branches_[k][p].squaredNorm() / (4.0 * shear_modulus_at(p) * modulus);
        return energy;
    }

  private:
    double shear_modulus_at(std::size_t point) const {
        const auto &body = elements_.body();
        const auto points_per_cell = stress_.size() / body.mesh.tetrahedra.size();
        return body.materials[body.mesh.region[point / points_per_cell]].shear_modulus();
    }

    Elements &elements_;
    const core::PronySeries &relaxation_;
    FollowedPath followed_{};
    OneProcessSystem system_;
    EquilibriumSearch search_;
    LoadedState at_;
    DeviatoricMemory memory_{};
    std::vector<Matrix3> stress_;                ///< at each point, after the last step
    std::vector<std::vector<Matrix3>> branches_; ///< (B) the same of what each remembers
    std::vector<double> force_;                  ///< (3 n) internal, after the last step [N]
    double work_ = 0.0, dissipated_ = 0.0;
};

/// @return whether the body came to the next record
bool go_on(SlowBody &body, const core::SlowHistory &history, int record) {
    const double duration = history.times[record] - history.times[record - 1];
    const double first = history.factors[record - 1], last = history.factors[record];
    double reached = 0.0, length = 1.0;
    while (reached < 1.0) {
        const double to = reached + 1.001 * length >= 1.0 ? 1.0 : reached + length;
        if (body.advance((to - reached) * duration, std::lerp(first, last, reached), std::lerp(first, last, to))) {
            reached = to;
        } else {
            length = 0.5 * (to - reached);
            if (length < smallest_part_of_record)
                return false;
        }
    }
    return true;
}

} // namespace

core::Solution solve_history(const core::Problem &problem, const MaterialLaw &law, const Discretisation &discretisation,
                             double tolerance, std::span<const double> follower_pressure) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    const auto &history = *load_case.slow_history;
    fem_reference::check_facets(load_case, mesh);
    const auto start = core::Clock::now();
    const auto rule = discretisation.degree == 1 ? TetrahedronRule::one_point : discretisation.rule;
    Elements elements(problem.body, discretisation.degree, discretisation.formulation, law, rule);
    const auto conditions = fem_reference::dof_conditions(load_case, elements.system());
    const auto resultants = core::press_resultants(load_case, mesh);
    core::Solution solution;
    solution.degrees_of_freedom = elements.num_displacements() + elements.num_pressures();
    solution.setup_seconds = core::seconds_since(start);
    solution.displacement.assign(mesh.points.size(), core::Vector3::Constant(nan));
    solution.reaction.assign(resultants.size(), core::Vector3::Constant(nan));
    solution.strain_energy = nan;

    const auto solve_start = core::Clock::now();
    const LoadPath path{.fractions = {1.0}, .tolerance = tolerance};
    SlowBody body(elements, conditions, static_cast<int>(resultants.size()), follower_pressure, path,
                  history.relaxation);
    if (!fem_reference::holds_every_part(load_case, mesh) || !body.begin()) {
        const auto free = free_to_move();
        solution.status = free.status;
        solution.message = free.message;
        return solution;
    }
    for (int record = 0; record < history.num_records(); ++record) {
        if (record > 0 && !go_on(body, history, record)) {
            solution.status = core::SolutionStatus::not_converged;
            solution.message =
                fmt::format("Newton's method finds no equilibrium beyond {:.3g} s; take a smaller load, a finer mesh "
                            "or constrain more of the body",
                            history.times[record - 1]);
            break;
        }
        const auto point = body.point(history.factors[record]);
        auto &kept = solution.path.emplace_back();
        std::vector<core::Vector3> displacement;
        for (const int node : elements.system().mesh_node) {
            displacement.emplace_back(core::Vector3::Map(&point.state.displacement[3 * node]));
            kept.displacement.push_back(displacement.back().cast<float>());
        }
        kept.reaction = point.reaction;
        for (std::size_t place = 0; place < resultants.size(); ++place)
            kept.reaction[place] += point.press * resultants[place];
        kept.strain_energy = body.stored_energy();
        kept.work = body.work();
        kept.dissipated_energy = body.dissipated_energy();
        if (record == history.whole_load_record()) {
            solution.displacement = std::move(displacement);
            solution.reaction = kept.reaction;
            solution.strain_energy = kept.strain_energy;
        }
    }
    solution.solve_seconds = core::seconds_since(solve_start);
    solution.solver = description(body.followed(), elements.num_pressures() > 0 ? "times two levels over CHOLMOD"
                                                                                : "factors by CHOLMOD");
    return solution;
}

} // namespace livermark::hyperelastic
