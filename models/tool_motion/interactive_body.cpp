#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/tool/ball_contact.hpp"
#include "interactive/method.hpp"
#include "models/tool_motion/frame_steps.hpp"
#include "models/tool_motion/moving_methods.hpp"
#include "models/tool_motion/scaled_masses.hpp"
#include "models/tool_motion/tool_place.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/mass_lumping.hpp"

namespace livermark::models {

namespace {

using livermark::interactive::Field;
using livermark::interactive::Method;
using livermark::interactive::Scene;

class InteractiveBody : public MovingBody {
  public:
    /// @param is_scaled  by selective mass scaling of stiff parts, of an explicit method
    InteractiveBody(Method method, const core::Problem &problem, bool is_scaled)
        : method_(std::move(method)), scene_{.body = problem.body,
                                             .node_mass = livermark::msm::lumped_masses(*problem.body),
                                             .constrained_nodes = {},
                                             .mass_damping = problem.load_case.tool.value().mass_damping},
          place_(tool_place(problem, scene_.node_mass)) {
        scene_.constrained_nodes = place_.nodes; // first, so that their targets are
        scene_.constrained_nodes.insert(scene_.constrained_nodes.end(), place_.held.begin(), place_.held.end());
        simulation_ = method_.prepare(scene_);
        if (method_.is_explicit) {
            // What is constrained less has the higher frequencies, but where constrained nodes leave a scaled part: one
            // step for the whole motion, as springs have it.
            const auto released_body = method_.prepare(released());
            if (is_scaled)
                scaling_ = scale_masses(*released_body);
            double longest = longest_step(*released_body);
            if (!scaling_.parts.empty())
                longest = std::min(longest, longest_step(*simulation_));
            least_steps_ = static_cast<int>(std::ceil(place_.motion.frame_interval / longest));
        }
        correct_steps();
        if (const auto &touching = problem.load_case.touching) {
            touching_ = *touching;
            ball_ = std::make_shared<core::BallContact>(touched_facets(problem),
                                                        core::contact_divisions(*problem.body, problem.load_case),
                                                        touching_.radius, touching_.friction);
            if (!simulation_->touch(ball_))
                throw std::logic_error("the method knows no contact");
        }
    }

    void prepare_for(const Effort &effort) override {
        step_ = place_.motion.frame_interval / effort.steps;
        simulation_->prepare(step_);
    }

    void advance(double start, const Effort &effort) override {
        const double step = place_.motion.frame_interval / effort.steps;
        const bool touches = ball_ && !has_let_go_;
        if (touches) {
            ball_->set_way(centre(start), centre(start + place_.motion.frame_interval));
            ball_->look_around([this](int node) -> core::Vector3 { return simulation_->positions().col(node); });
        }
        for (int s = 1; s <= effort.steps; ++s) {
            if (touches)
                ball_->set_way(centre(start + (s - 1) * step), centre(start + s * step));
            else if (!has_let_go_)
                move_tool(start + s * step);
            simulation_->step(step, effort.iterations);
        }
        if (touches)
            force_ = -ball_->take_impulse() / place_.motion.frame_interval;
    }

    void let_go() override {
        has_let_go_ = true;
        if (ball_) { // it had hold of nothing
            simulation_->touch(nullptr);
            return;
        }
        const Field positions = simulation_->positions(), velocities = simulation_->velocities();
        scene_ = released();
        simulation_ = method_.prepare(scene_);
        simulation_->set_state(positions, velocities);
        correct_steps();
        if (step_ > 0.0)
            simulation_->prepare(step_);
    }

    std::vector<core::Vector3> displacement() const override { return displacement_of(*simulation_); }

    core::Vector3 tool_force() const override {
        if (has_let_go_)
            return core::Vector3::Zero();
        if (ball_)
            return force_;
        return -simulation_->reactions().leftCols(static_cast<Eigen::Index>(place_.nodes.size())).rowwise().sum();
    }

    FrameCost cost(const Effort &effort) const override { return frame_cost(*simulation_, effort); }

    std::optional<Effort> least_effort() const override {
        if (least_steps_ == 0)
            return std::nullopt;
        return Effort{.iterations = least_steps_};
    }

  private:
    Scene released() const {
        auto scene = scene_;
        scene.constrained_nodes = place_.held;
        return scene;
    }

    double longest_step(const livermark::interactive::Simulation &at_rest) const {
        return livermark::msm::default_safety_factor *
               (scaling_.parts.empty() ? at_rest.critical_time_step()
                                       : critical_time_step(at_rest, constrained(scaling_, at_rest.scene())));
    }

    core::Vector3 centre(double time) const { return core::ball_centre(touching_, place_.motion, time); }

    /// Those of the mesh; in four parts each where the method has nodes of its own in the middle of edges. Sides are
    /// half as long then, so penalties are twice as large.
    std::vector<core::TouchedFacet> touched_facets(const core::Problem &problem) const {
        auto facets = core::touched_facets(*problem.body, problem.load_case);
        const auto &mesh = problem.body->mesh;
        const auto &scene = simulation_->scene();
        if (scene.own_nodes.empty())
            return facets;
        const auto table = core::edge_table(mesh.tetrahedra);
        if (table.edges.size() != scene.own_nodes.size())
            throw std::logic_error("nodes of a method that are in the middle of no edge");
        const auto middle = [&](int a, int b) {
            const auto edge = std::ranges::lower_bound(table.edges, std::array{std::min(a, b), std::max(a, b)});
            return mesh.num_nodes() + static_cast<int>(edge - table.edges.begin());
        };
        std::vector<core::TouchedFacet> parts;
        for (const auto &facet : facets) {
            const auto [a, b, c] = facet.nodes;
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            for (const auto &nodes : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}})
                parts.push_back({nodes, 0.25 * facet.area, 2.0 * facet.penalty});
        }
        return parts;
    }

    void correct_steps() {
        if (const auto correction = correction_of(constrained(scaling_, scene_)))
            simulation_->correct_steps(correction);
    }

    void move_tool(double time) {
        const auto position = core::tool_position(place_.motion, time);
        Field targets = simulation_->targets();
        for (std::size_t i = 0; i < place_.nodes.size(); ++i)
            targets.col(static_cast<Eigen::Index>(i)) =
                scene_.body->mesh.points[place_.nodes[i]] + place_.displacement(i, position);
        simulation_->set_targets(targets);
    }

    Method method_;
    Scene scene_;
    ToolPlace place_;
    std::unique_ptr<livermark::interactive::Simulation> simulation_;
    livermark::msm::MassScaling scaling_;
    int least_steps_ = 0; ///< in a frame; zero where every step is stable
    double step_ = 0.0;   ///< that is prepared [s]
    core::TouchingTool touching_;
    std::shared_ptr<core::BallContact> ball_; ///< null where the tool has hold of its place
    core::Vector3 force_ = core::Vector3::Zero();
    bool has_let_go_ = false;
};

} // namespace

std::vector<MovingMethod> interactive_moving_methods() {
    std::vector<MovingMethod> moving_methods;
    const auto add = [&](const Method &method, bool is_scaled) {
        moving_methods.push_back(
            {.name = method.name + (is_scaled ? scaled_name : ""),
             .source = method.source + (is_scaled ? scaled_source : ""),
             .implementation = method.implementation + (is_scaled ? scaled_implementation : ""),
             .converges_to = method.converges_to + (is_scaled ? scaled_limit : ""),
             .objection = method.objection,
             .prepare = [method, is_scaled](const core::Problem &problem) -> std::unique_ptr<MovingBody> {
                 return std::make_unique<InteractiveBody>(method, problem, is_scaled);
             },
             .knows_contact = method.knows_contact});
    };
    for (const auto &method : livermark::interactive::all_methods()) {
        add(method, false);
        // On the liver with tumours quadratic elements with scaled masses diverge, and it is not known why.
        if (method.is_explicit && method.name != "tled_quadratic")
            add(method, true);
    }
    return moving_methods;
}

} // namespace livermark::models
