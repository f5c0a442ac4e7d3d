#include "tests/app/live/rough_trial.hpp"

#include <algorithm>
#include <cmath>

#include "app/live/parameters.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "tests/app/live/body_message.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::live {

using core::Vector3;

namespace {

TrialBody constrained_at_x_min(core::Body body) {
    TrialBody trial{std::move(body), {}};
    for (const int patch : trial.body.mesh.boundary_patch)
        trial.is_constrained.push_back(trial.body.mesh.patch_names[patch] == "x_min");
    return trial;
}

TrialBody under_palpation(core::Body body) {
    TrialBody trial{std::move(body), {}};
    const auto load_case =
        load_cases::read_load_case(LIVERMARK_SOURCE_DIR "/load_cases/palpation.toml", trial.body.mesh);
    for (int f = 0; f < load_case.num_facets(); ++f)
        trial.is_constrained.push_back(load_case.is_constrained(f) && load_case.value[f].isZero(0.0));
    return trial;
}

/// A finger of 12 mm that pokes 2 mm deep.
Tool finger(const Vector3 &point, const Vector3 &normal) {
    return {.kind = ToolKind::probe, .target = point + 0.010 * normal, .radius = 0.012};
}

core::Body box_with_lump() {
    auto body = *tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {6, 3, 3}), {1060.0, 5e3, 0.45});
    auto &mesh = body.mesh;
    mesh.region_names = {"soft", "hard"};
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        double x = 0.0;
        for (const int i : mesh.tetrahedra[t])
            x += mesh.points[i].x() / 4.0;
        mesh.region[t] = x > 0.02 && x < 0.04 ? 1 : 0;
    }
    body.materials = {{1060.0, 5e3, 0.45}, {1060.0, 1e5, 0.45}};
    return body;
}

/// A box with a capsule, a vessel along it, and tissue that gets stiffer to one side.
core::Body covered_box() {
    auto body = *tests::make_body(tests::box_mesh({0.06, 0.03, 0.03}, {6, 3, 3}), {1060.0, 5e3, 0.45});
    body.capsule = core::Capsule{.thickness = 20e-6, .young_modulus = 8.22e6};
    body.vessels = core::VesselTree{.points = {{0.005, 0.014, 0.012}, {0.055, 0.02, 0.02}},
                                    .radius = {2e-3, 1e-3},
                                    .segments = {{0, 1}},
                                    .wall_ratio = 0.2,
                                    .wall_modulus = 1e6};
    for (const auto &nodes : body.mesh.tetrahedra)
        body.modulus_factor.push_back(0.7 + 0.6 * body.mesh.points[nodes[0]].y() / 0.03);
    return body;
}

} // namespace

TrialBody trial_body(const std::string &name) {
    if (name == "small_beam")
        return constrained_at_x_min(
            *tests::make_body(tests::box_mesh({0.12, 0.04, 0.04}, {6, 2, 2}), {1060.0, 5e3, 0.45}));
    if (name == "lump")
        return constrained_at_x_min(box_with_lump());
    if (name == "covered")
        return constrained_at_x_min(covered_box());
    if (name == "liver_with_capsule")
        return under_palpation(meshes::read_body(LIVERMARK_SOURCE_DIR "/examples/bodies/liver_with_capsule.toml"));
    auto body = meshes::read_body(std::string(LIVERMARK_SOURCE_DIR "/meshes/") + name + ".toml");
    return name == "beam" ? constrained_at_x_min(std::move(body)) : under_palpation(std::move(body));
}

RoughTrial::RoughTrial(const TrialBody &trial, std::uint32_t seed, double lowest_poisson_ratio)
    : random_(seed), lowest_poisson_ratio_(lowest_poisson_ratio) {
    const auto &mesh = trial.body.mesh;
    std::vector<Vector3> normal(mesh.points.size(), Vector3::Zero());
    std::vector<char> can_move(mesh.points.size(), 1);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const auto [a, b, c] = mesh.boundary_triangles[f];
        const auto &x = mesh.points;
        for (const int node : {a, b, c}) {
            normal[node] += (x[b] - x[a]).cross(x[c] - x[a]);
            if (trial.is_constrained[f])
                can_move[node] = 0;
        }
    }
    for (int i = 0; i < mesh.num_nodes(); ++i)
        if (can_move[i] != 0 && !normal[i].isZero(0.0))
            places_.push_back({i, mesh.points[i], normal[i].normalized()});
}

double RoughTrial::number(double least, double most) {
    return least + (most - least) * (random_() / 4294967296.0);
}

double RoughTrial::magnitude(double least, double most) {
    return least * std::pow(most / least, number(0.0, 1.0));
}

Vector3 RoughTrial::within(double largest) {
    const double x = number(-largest, largest), y = number(-largest, largest);
    return {x, y, number(-largest, largest)};
}

Tool RoughTrial::poke(double deepest) {
    const auto &at = place();
    Tool tool{.kind = ToolKind::probe, .radius = is_one_in(3) ? 0.012 : magnitude(0.002, 0.05)};
    tool.target = at.point + (tool.radius - number(0.0, deepest)) * at.normal + within(0.015);
    return tool;
}

Tool RoughTrial::pull(double furthest) {
    const auto &at = place();
    Tool tool{.kind = ToolKind::pull, .radius = magnitude(0.002, 0.05), .node = at.node};
    tool.target = at.point + within(furthest);
    return tool;
}

Settings RoughTrial::other_settings() {
    const auto &names = spring_names();
    Settings settings{.springs = names[random_() % names.size()], .keeps_volume = !is_one_in(4)};
    settings.young_modulus = magnitude(1e3, 2e4);
    settings.poisson_ratio = is_one_in(3) ? 0.49 : number(lowest_poisson_ratio_, 0.49);
    settings.damping = {magnitude(2.0, 40.0), is_one_in(4) ? magnitude(1e-5, 1e-3) : 0.0};
    return settings;
}

void RoughTrial::lead_about(std::vector<Act> &acts) {
    auto tool = is_one_in(2) ? poke(0.02) : pull(0.03);
    const Vector3 start = tool.target;
    for (int i = 0; i < 6; ++i) {
        acts.emplace_back(Handle{tool, number(0.01, 0.04)});
        tool.target = start + within(0.04);
    }
}

void RoughTrial::tear(std::vector<Act> &acts) {
    const double distance = magnitude(1.0, 300.0);
    for (int i = 0; i < 3; ++i) {
        auto tool = pull(0.0);
        const Vector3 point = tool.target, way = within(1.0).normalized();
        tool.target = point + distance * way;
        acts.emplace_back(Handle{tool, number(0.1, 0.5)});
        tool.target = point + 0.004 * way;
        acts.emplace_back(Handle{tool, number(0.02, 0.1)});
    }
}

void RoughTrial::do_something(std::vector<Act> &acts) {
    const auto kind = random_() % 20;
    if (kind < 7) {
        acts.emplace_back(Handle{poke(0.04), number(0.02, 0.15)});
    } else if (kind < 11) {
        acts.emplace_back(Handle{pull(0.06), number(0.02, 0.15)});
    } else if (kind < 14) {
        lead_about(acts);
    } else if (kind < 16) {
        tear(acts);
    } else if (kind < 18) {
        const auto tool = is_one_in(2) ? poke(0.03) : pull(0.05);
        acts.emplace_back(Handle{tool, number(0.05, 0.2)});
        acts.emplace_back(other_settings());
        acts.emplace_back(Handle{tool, number(0.05, 0.2)});
    } else if (kind < 19) {
        acts.emplace_back(Handle{pull(0.06), number(0.02, 0.1)});
        acts.emplace_back(BackToRest());
    } else {
        acts.emplace_back(Keep());
        acts.emplace_back(Handle{poke(0.03), number(0.02, 0.1)});
        acts.emplace_back(Undo());
    }
}

std::vector<Act> RoughTrial::next() {
    std::vector<Act> acts;
    do_something(acts);
    acts.emplace_back(Handle{{}, number(0.01, 0.06)});
    acts.emplace_back(Handle{finger(place().point, place().normal), 0.06});
    return acts;
}

namespace {

/// A scene under a trial, and what has been seen of it.
class Trial {
  public:
    explicit Trial(const TrialBody &body) : body_(body), scene_(body.body, body.is_constrained) {
        outcome.messages.push_back(body_message(body.body, body.is_constrained));
    }

    void operator()(const Settings &settings) {
        settings_ = settings;
        chosen_ = scene_.choose(settings);
        ++outcome.num_choices;
        const auto &names = spring_names();
        const auto which = std::ranges::find(names, settings.springs) - names.begin();
        outcome.messages.push_back({1.0, static_cast<double>(which), settings.keeps_volume ? 1.0 : 0.0,
                                    settings.young_modulus, settings.poisson_ratio, settings.damping.alpha,
                                    settings.damping.beta, settings.time_step});
    }
    void operator()(const Handle &act) {
        outcome.num_tools += act.tool.kind != ToolKind::none;
        const int picture = std::max(1, static_cast<int>(1.0 / 60.0 / chosen_.time_step));
        for (int left = std::max(1, static_cast<int>(act.seconds / chosen_.time_step)); left > 0; left -= picture) {
            const int num_steps = std::min(left, picture);
            const auto &tool = act.tool;
            outcome.messages.push_back({2.0, static_cast<double>(tool.kind), tool.target.x(), tool.target.y(),
                                        tool.target.z(), tool.radius, static_cast<double>(tool.node),
                                        static_cast<double>(num_steps)});
            see(scene_.move(act.tool, num_steps));
        }
    }
    void operator()(BackToRest /*act*/) {
        scene_.reset();
        outcome.messages.push_back({3.0});
    }
    void operator()(Keep /*act*/) {
        scene_.keep();
        outcome.messages.push_back({4.0});
    }
    void operator()(Undo /*act*/) {
        scene_.restore();
        outcome.messages.push_back({5.0});
    }

    /// Whether back to rest gives a fresh scene.
    bool is_fresh() {
        (*this)(BackToRest());
        Scene fresh(body_.body, body_.is_constrained);
        fresh.choose(settings_);
        bool is_same = true;
        const auto &mesh = body_.body.mesh;
        const auto facet = std::ranges::find(body_.is_constrained, false) - body_.is_constrained.begin();
        const Vector3 point = mesh.points[mesh.boundary_triangles[facet][0]];
        const auto tool = finger(point, core::area_vector(mesh, static_cast<int>(facet)).normalized());
        for (int i = 0; i < 10; ++i) {
            const auto expected = fresh.move(tool, 5), found = scene_.move(tool, 5);
            is_same = is_same && found.displacement == expected.displacement && found.force == expected.force;
        }
        return is_same;
    }

    TrialOutcome outcome;

  private:
    void see(const Frame &frame) {
        outcome.num_restarts = frame.restarts;
        bool is_finite = frame.force.allFinite() && std::isfinite(frame.indentation);
        for (const auto &u : frame.displacement) {
            is_finite = is_finite && u.allFinite();
            outcome.furthest = std::max(outcome.furthest, u.norm());
        }
        outcome.num_not_finite += !is_finite;
        outcome.strongest = std::max(outcome.strongest, frame.force.norm());
        outcome.smallest_volume = std::min(outcome.smallest_volume, frame.smallest_volume);
    }

    const TrialBody &body_;
    Scene scene_;
    Settings settings_;
    Chosen chosen_;
};

} // namespace

TrialOutcome take_trial(const std::string &name, int num_steps, std::uint32_t seed, double lowest_poisson_ratio) {
    const auto body = trial_body(name);
    RoughTrial steps(body, seed, lowest_poisson_ratio);
    Trial trial(body);
    auto &outcome = trial.outcome;
    trial(Settings{.young_modulus = 5e3});
    for (; outcome.num_steps < num_steps; ++outcome.num_steps) {
        const auto acts = steps.next();
        for (const auto &act : acts) {
            const int before = outcome.num_restarts;
            std::visit(trial, act);
            if (&act == &acts.back())
                outcome.num_small_lost += outcome.num_restarts - before;
        }
    }
    outcome.is_fresh = trial.is_fresh();
    return std::move(outcome);
}

} // namespace livermark::live
