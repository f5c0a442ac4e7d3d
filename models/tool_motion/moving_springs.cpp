#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/tool/ball_contact.hpp"
#include "models/tool_motion/frame_steps.hpp"
#include "models/tool_motion/moving_methods.hpp"
#include "models/tool_motion/tool_place.hpp"
#include "msm/dynamics/mass_scaling.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/spring_energy.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "support/known_names.hpp"

namespace livermark::models {

namespace {

using livermark::msm::ElasticBody;
using livermark::msm::FastSteps;

/// Steps of symplectic Euler on vector units, forces in single precision.
class MovingSprings : public MovingBody {
  public:
    /// @param is_scaled  by selective mass scaling of stiff parts
    MovingSprings(ElasticBody springs, const core::Problem &problem, bool is_scaled)
        : body_(problem.body), springs_(std::move(springs)), place_(tool_place(problem, springs_.node_mass)) {
        if (is_scaled)
            scaling_ = livermark::msm::scale_masses(*body_, springs_, place_.let_go);
        // What is constrained less has the higher frequencies, but where constrained nodes leave a scaled part: one
        // step for the whole motion.
        double highest = highest_with(place_.let_go);
        if (!scaling_.parts.empty())
            highest = std::max(highest, highest_with(place_.while_held));
        const double longest = livermark::msm::default_safety_factor * 2.0 / highest;
        least_steps_ = static_cast<int>(std::ceil(place_.motion.frame_interval / longest));
        take_steps_of(least_steps_, place_.while_held);
        if (problem.load_case.touching) {
            ball_ = *problem.load_case.touching;
            contact_.emplace(core::touched_facets(*body_, problem.load_case),
                             core::contact_divisions(*body_, problem.load_case), ball_.radius, ball_.friction);
            is_held_.assign(body_->mesh.points.size(), false);
            for (const int node : place_.held)
                is_held_[node] = true;
        }
    }

    void prepare_for(const Effort &effort) override {
        if (effort.steps != num_steps_)
            take_steps_of(effort.steps, has_let_go_ ? place_.let_go : place_.while_held);
    }

    void advance(double start, const Effort &effort) override {
        prepare_for(effort);
        if (has_let_go_) {
            steps_->take(num_steps_);
            return;
        }
        const double step = place_.motion.frame_interval / num_steps_;
        if (contact_) {
            advance_in_contact(start, step);
            return;
        }
        for (int s = 1; s <= num_steps_; ++s) {
            steps_->take(1);
            const auto position = core::tool_position(place_.motion, start + s * step);
            for (std::size_t i = 0; i < place_.nodes.size(); ++i)
                steps_->set_displacement(place_.nodes[i], place_.displacement(i, position));
        }
    }

    void let_go() override {
        take_steps_of(num_steps_, place_.let_go);
        has_let_go_ = true;
    }

    std::vector<core::Vector3> displacement() const override {
        return livermark::msm::to_field(steps_->state().displacement);
    }

    core::Vector3 tool_force() const override {
        core::Vector3 force = core::Vector3::Zero();
        if (has_let_go_)
            return force;
        if (contact_)
            return force_;
        auto positions = displacement();
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i] += body_->mesh.points[i];
        const auto gradient = livermark::msm::elastic_gradient(springs_, positions);
        for (const int node : place_.nodes)
            force -= gradient[node];
        return force;
    }

    FrameCost cost(const Effort &effort) const override { return frame_cost(*steps_, *body_, effort); }

    std::optional<Effort> least_effort() const override { return Effort{.steps = least_steps_}; }

  private:
    double highest_with(const livermark::msm::NodalConditions &conditions) const {
        return livermark::msm::largest_angular_frequency(springs_, body_->mesh.points, conditions,
                                                         livermark::msm::constrained(scaling_, conditions));
    }

    /// From where the body is.
    void take_steps_of(int num_steps, const livermark::msm::NodalConditions &conditions) {
        auto at_rest = conditions; // the tool starts there
        for (auto &displacement : at_rest.displacement)
            displacement *= 0.0; // NaN, a free component, stays NaN
        auto steps =
            frame_steps(springs_, *body_, at_rest, place_.motion.mass_damping, place_.motion.frame_interval / num_steps,
                        {.scaling = livermark::msm::constrained(scaling_, conditions)});
        if (steps_)
            steps.set_state(steps_->state());
        steps_ = std::move(steps);
        num_steps_ = num_steps;
    }

    core::Vector3 position(int node) const { return body_->mesh.points[node] + steps_->displacement(node); }

    /// What the ball exerts takes part in each step.
    void advance_in_contact(double start, double step) {
        contact_->set_way(core::ball_centre(ball_, place_.motion, start),
                          core::ball_centre(ball_, place_.motion, start + num_steps_ * step));
        const auto now = [this](int node) { return position(node); };
        const auto yields = [&](int node) { return is_held_[node] ? 0.0 : step * step / springs_.node_mass[node]; };
        const auto give = [&](int node, const core::Vector3 &force) {
            const core::Vector3 way = yields(node) * force;
            steps_->push(node, way, way / step);
        };
        contact_->look_around(now);
        for (int s = 0; s < num_steps_; ++s) {
            steps_->take(1);
            contact_->begin_step(give);
            contact_->sweep(
                contact_->part(s, num_steps_),
                [&](int node) { return core::Vector3(position(node) - step * steps_->velocity(node)); }, now,
                [&](int node) { return Eigen::Matrix3d(yields(node) * Eigen::Matrix3d::Identity()); }, give);
            contact_->end_step(step);
        }
        force_ = -contact_->take_impulse() / place_.motion.frame_interval;
    }

    std::shared_ptr<const core::Body> body_;
    ElasticBody springs_;
    ToolPlace place_;
    core::TouchingTool ball_;                  ///< where it touches
    std::optional<core::BallContact> contact_; ///< none where the tool has hold of its place
    std::vector<bool> is_held_;                ///< (N) where it touches: whether a node cannot move
    core::Vector3 force_ = core::Vector3::Zero();
    livermark::msm::MassScaling scaling_;
    int least_steps_ = 1, num_steps_ = 0; ///< in a frame: at least, and those that are taken
    std::optional<FastSteps> steps_;
    bool has_let_go_ = false;
};

MovingMethod method(const MovingSpringModel &model, bool is_scaled) {
    const std::string on_vector_units = "vector units, single precision with a state of twice the digits";
    return {.name = model.name + (is_scaled ? scaled_name : ""),
            .source = model.source + (is_scaled ? scaled_source : ""),
            .implementation = on_vector_units + (is_scaled ? scaled_implementation : ""),
            .converges_to =
                std::string("the motion of its springs as h goes to 0; at rest the equilibrium of their energy") +
                (is_scaled ? scaled_limit : ""),
            .objection = model.objection,
            .prepare = [make = model.make, is_scaled](const core::Problem &problem) -> std::unique_ptr<MovingBody> {
                return std::make_unique<MovingSprings>(make(*problem.body), problem, is_scaled);
            },
            .only_when_named = model.only_when_named,
            .knows_contact = true};
}

const livermark::msm::SpringLaw &spring_law(const char *name) {
    return support::find_named(livermark::msm::all_spring_laws(), name, "spring law");
}

ElasticBody lloyd(const core::Body &body) {
    return livermark::msm::spring_network(body, spring_law("lloyd"));
}

ElasticBody patch_with_volume(const core::Body &body) {
    const auto &law = spring_law("patch");
    return livermark::msm::springs_with_volume(body, livermark::msm::springs_beside_volume(body, law),
                                               livermark::msm::find_volume_term("nodal_volume"))
        .body;
}

std::optional<livermark::msm::SpringSource> source_of_lloyd(const core::Body &body) {
    return livermark::msm::SpringSource{spring_law("lloyd"), body};
}

std::optional<livermark::msm::SpringSource> source_of_patch(const core::Body &body) {
    return livermark::msm::SpringSource{spring_law("patch"), livermark::msm::for_springs_beside_volume(body)};
}

std::optional<livermark::msm::SpringSource> no_source(const core::Body & /*body*/) {
    return std::nullopt;
}

ElasticBody coupled_springs(const core::Body &body, const char *name) {
    return livermark::msm::coupled_springs_with_volume(body, livermark::msm::find_coupled_springs(name));
}

ElasticBody nodal_springs(const core::Body &body) {
    return coupled_springs(body, "nodal_springs");
}

ElasticBody nodal_neo_hookean(const core::Body &body) {
    return coupled_springs(body, "nodal_neo_hookean");
}

ElasticBody nodal_neo_hookean_f(const core::Body &body) {
    return coupled_springs(body, "nodal_neo_hookean_f");
}

ElasticBody edge_neo_hookean(const core::Body &body) {
    return coupled_springs(body, "edge_neo_hookean");
}

ElasticBody edge_neo_hookean_f(const core::Body &body) {
    return coupled_springs(body, "edge_neo_hookean_f");
}

} // namespace

std::span<const MovingSpringModel> moving_spring_models() {
    static const std::vector<MovingSpringModel> models{
        {"lloyd", "Lloyd, Szekely, Harders 2007, IEEE TVCG 13(5)",
         "Springs alone have Poisson's ratio 1/4, so they cannot be nearly incompressible tissue (Golec et al. 2020, "
         "Hybrid 3D mass-spring system, The Visual Computer 36): 'livermark run --load-case pneumoperitoneum --model "
         "lloyd fem_p2 --poisson 0.25 0.45' shows it.",
         lloyd, source_of_lloyd},
        {"patch_nodal_volume", "Livermark",
         "Those who calibrate springs fit each body and load anew; here one fit to affine strains serves all loads, "
         "and hard parts need short steps.",
         patch_with_volume, source_of_patch, true},
        {"nodal_springs", "Livermark",
         "Forces act between springs around a node, so it is no network of two-node springs; nothing keeps tetrahedra "
         "from turning inside out.",
         nodal_springs, no_source, true},
        {"nodal_neo_hookean", "Livermark",
         "It is a nodally averaged finite element (Puso, Solberg 2006, IJNME 67) with another name, and its constant a "
         "was chosen on the livers that ship.",
         nodal_neo_hookean, no_source, true},
        {"nodal_neo_hookean_f", "Livermark",
         "It is a nodally averaged finite element (Puso, Solberg 2006, IJNME 67) with another name, and its constant a "
         "was chosen on the livers that ship.",
         nodal_neo_hookean_f, no_source, true},
        {"edge_neo_hookean", "Livermark",
         "It is an edge-based smoothed finite element with another name, and was not tuned for speed as those around "
         "nodes were.",
         edge_neo_hookean, no_source, false, true},
        {"edge_neo_hookean_f", "Livermark",
         "It is an edge-based smoothed finite element with another name, and was not tuned for speed as those around "
         "nodes were.",
         edge_neo_hookean_f, no_source, false, true}};
    return models;
}

std::vector<MovingMethod> moving_springs() {
    std::vector<MovingMethod> methods;
    for (const auto &model : moving_spring_models()) {
        methods.push_back(method(model, false));
        if (model.is_scaled)
            methods.push_back(method(model, true));
    }
    return methods;
}

} // namespace livermark::models
