#include "app/live/parameters.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "app/live/way_out.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "msm/cutting/cut_parts.hpp"

namespace livermark::live {

namespace {

/// Accuracy of squared frequencies.
constexpr double frequency_accuracy = 1e-3;

/// The settings that leave the materials of a part as they are.
Settings settings_of_part(const core::Body &part, Settings settings) {
    settings.young_modulus = part.materials[largest_region(part.mesh)].young_modulus;
    return settings;
}

/// @param num_tetrahedra  of the whole body
msm::MassSprings springs_of_part(const msm::PartOfBody &part, const FoundationTerm &foundation,
                                 std::size_t num_tetrahedra, const Settings &settings) {
    SpringsOfLaws none;
    auto springs = mass_springs(part.body, settings_of_part(part.body, settings), none);
    if (foundation)
        springs.body.add(msm::term_of_part(*foundation, part, num_tetrahedra));
    return springs;
}

} // namespace

namespace {

/// @return without steps
FittedRest springs_of_rest(const core::Body &body, const FoundationTerm &foundation, const std::vector<char> &is_gone,
                           const msm::NodalConditions &conditions, const Settings &settings) {
    std::vector<char> is_there;
    for (const char gone : is_gone)
        is_there.push_back(gone == 0 ? 1 : 0);
    auto part = msm::part_of_body(body, is_there, conditions);
    auto springs = springs_of_part(part, foundation, is_gone.size(), settings);
    return {std::move(part), std::move(springs), {}};
}

} // namespace

FittedRest fit_rest(const core::Body &body, const FoundationTerm &foundation, const std::vector<char> &is_gone,
                    const msm::NodalConditions &conditions, const Settings &settings) {
    auto rest = springs_of_rest(body, foundation, is_gone, conditions, settings);
    rest.stepping = chosen_steps(rest.part.body, rest.springs, rest.part.conditions, settings);
    return rest;
}

FittedRest refit_rest(const FittedRest &before, const core::Body &body, const FoundationTerm &foundation,
                      const std::vector<char> &is_gone, const msm::NodalConditions &conditions,
                      const Settings &settings) {
    auto rest = springs_of_rest(body, foundation, is_gone, conditions, settings);
    rest.stepping = before.stepping; // new nodes are numbered behind the others
    return rest;
}

msm::MassScaling scaling_of_whole(const FittedRest &rest) {
    auto scaling = rest.stepping.scaling;
    for (auto &part : scaling.parts)
        for (int &node : part.nodes)
            node = rest.part.node[node];
    return scaling;
}

std::vector<double> watched_of_whole(const FittedRest &rest, const Stepping &stepping, std::size_t num_tetrahedra) {
    const auto watched = watched_volumes(rest.part.body, rest.springs, rest.part.conditions, stepping);
    if (watched.empty())
        return {};
    std::vector<double> whole(num_tetrahedra, 0.0);
    for (std::size_t t = 0; t < watched.size(); ++t)
        whole[rest.part.tetrahedron[t]] = watched[t];
    return whole;
}

double critical_step_around(const core::Body &body, const FoundationTerm &foundation, const std::vector<char> &is_gone,
                            std::span<const int> gone, msm::NodalConditions conditions, const msm::MassScaling &scaling,
                            const Settings &settings) {
    std::set<int> nodes;
    for (const int t : gone)
        nodes.insert(body.mesh.tetrahedra[t].begin(), body.mesh.tetrahedra[t].end());
    for (const auto &part : scaling.parts)
        for (const int node : part.nodes)
            conditions.displacement[node].setZero();
    const std::vector<int> around(nodes.begin(), nodes.end());
    const double highest = msm::frequency_around(
        body, is_gone, around,
        [&](const msm::PartOfBody &part) { return springs_of_part(part, foundation, is_gone.size(), settings).body; },
        conditions, frequency_accuracy);
    return highest > 0.0 ? critical_step(highest, settings) : std::numeric_limits<double>::infinity();
}

// What a scene does with cuts.

namespace {

/// 0, 1, 2 ...
std::vector<int> counted(std::size_t size) {
    std::vector<int> numbers(size);
    std::iota(numbers.begin(), numbers.end(), 0);
    return numbers;
}

/// Parts all of whose nodes are in no tetrahedron that goes, or gone already.
msm::MassScaling untouched_parts(msm::MassScaling scaling, const core::TetraMesh &mesh, std::span<const int> gone) {
    std::vector<char> is_touched(mesh.points.size(), 0);
    for (const int t : gone)
        for (const int node : mesh.tetrahedra[t])
            is_touched[node] = 1;
    std::erase_if(scaling.parts, [&](const msm::ScaledRegion &part) {
        return std::ranges::any_of(part.nodes, [&](int node) { return is_touched[node] != 0; });
    });
    return scaling;
}

} // namespace

std::vector<char> Scene::is_gone(std::size_t num_cuts) const {
    std::vector<char> gone(body_.mesh.tetrahedra.size(), 0);
    for (std::size_t c = 0; c < num_cuts; ++c)
        for (const int t : cuts_[c].tetrahedra)
            gone[t] = 1;
    return gone;
}

std::vector<int> Scene::gone() const {
    const auto marks = is_gone(cuts_.size());
    std::vector<int> numbers;
    for (std::size_t t = 0; t < marks.size(); ++t)
        if (marks[t] != 0)
            numbers.push_back(static_cast<int>(t));
    return numbers;
}

/// Remains of the body, as a ball may touch them.
TouchableBody Scene::touchable_remains() const {
    return touchable_body({.name = {},
                           .mesh = remains_.mesh,
                           .materials = prepared_->body.materials,
                           .modulus_factor = remaining_factors(remains_, prepared_->body)},
                          constrained_remains(), prepared_->parts.body.softness);
}

/// After cuts, or before the first one: what is left, and what of it can be touched. Nothing is loaded then.
void Scene::show_remains() {
    remains_ = cuts_.empty() ? Remains{body_.mesh, counted(body_.mesh.tetrahedra.size()),
                                       counted(body_.mesh.boundary_triangles.size())}
                             : remains_of(body_.mesh, is_gone(cuts_.size()), is_constrained_facet_.size());
    surface_ = touchable_surface(remains_.mesh, constrained_remains());
    load_ = {};
    disc_ = {};
    balls_.clear();
    jaws_.reset();
    std::vector<char> is_there(body_.mesh.points.size(), 0);
    for (const auto &tetrahedron : remains_.mesh.tetrahedra)
        for (const int node : tetrahedron)
            is_there[node] = 1;
    gone_nodes_.clear();
    for (std::size_t node = 0; node < is_there.size(); ++node)
        if (is_there[node] == 0)
            gone_nodes_.push_back(static_cast<int>(node));
}

/// Takes out of newly prepared steps what all cuts have taken, in their turn: what follows is to the bit what it was
/// when the cuts were made.
void Scene::cut_anew() {
    std::vector<int> before;
    for (std::size_t c = 0; c < prepared_->num_cuts; ++c)
        before.insert(before.end(), cuts_[c].tetrahedra.begin(), cuts_[c].tetrahedra.end());
    if (!before.empty()) {
        take_out(before);
        if (are_scaled_)
            steps_->set_scaling(scaling_of_whole(*prepared_->rest));
        has_ended_scaling_ = false;
    }
    for (std::size_t c = prepared_->num_cuts; c < cuts_.size(); ++c)
        take_out(cuts_[c].tetrahedra);
    divide_steps();
}

/// The steps go on without these.
void Scene::take_out(std::span<const int> tetrahedra) {
    if (!tetrahedra.empty() && !steps_->remove(tetrahedra))
        has_ended_scaling_ = true;
}

/// Divides steps as far as cuts since the last choice ask for.
void Scene::divide_steps() {
    const auto &stepping = prepared_->stepping;
    const bool are_unscaled = !stepping.scaling.parts.empty() && (!are_scaled_ || has_ended_scaling_);
    const auto &lengths = are_unscaled ? stepping.unscaled : stepping.chosen;
    double part = 1.0;
    for (std::size_t c = prepared_->num_cuts; c < cuts_.size(); ++c)
        part = std::min(part, cuts_[c].critical_time_step / lengths.critical_time_step);
    fewest_parts_ = num_parts_of(time_step_, part * lengths.longest_time_step);
    num_parts_ = fewest_parts_ * num_parts_of(time_step_ / fewest_parts_, part * lengths.pressed_time_step);
}

void Scene::undo_cuts(std::size_t num_left) {
    bool has_been_parted = false;
    for (; cuts_.size() > num_left; cuts_.pop_back()) {
        const auto &before = cuts_.back().before;
        if (!before)
            continue;
        has_been_parted = true;
        body_ = before->body;
        original_node_ = before->original_node;
        is_constrained_ = before->is_constrained;
        foundation_ = before->foundation;
        if (prepared_->num_cuts < cuts_.size()) // nothing else has been chosen since
            prepared_ = before->prepared;
    }
    if (has_been_parted) {
        springs_.clear();
        steps_.reset();
    }
    show_remains();
    if (!prepared_)
        return;
    if (num_left >= prepared_->num_cuts)
        return prepare_steps(!needle_);
    // The springs were fitted to less than there is again, and so was the time step.
    auto settings = prepared_->settings;
    const double asked = std::exchange(settings.time_step, 0.0);
    if (asked > 0.0 && asked < choose(settings).longest_time_step)
        settings.time_step = asked;
    if (asked == 0.0 || settings.time_step > 0.0)
        choose(settings);
}

const core::TetraMesh &Scene::original_mesh() const {
    const auto first = std::ranges::find_if(cuts_, [](const MadeCut &made) { return made.before != nullptr; });
    return first == cuts_.end() ? body_.mesh : first->before->body.mesh;
}

/// Springs below the body as it is parted now.
void Scene::stand_on_foundation() {
    if (stands_on_)
        foundation_ = msm::foundation_springs(body_.mesh, *stands_on_);
}

/// Goes on with springs of a parted body, which are set up anew, in steps of the same length.
void Scene::part(PartedBody parted) {
    const auto prepared = prepared_;
    const auto num_before = original_node_.size();
    body_.mesh = std::move(parted.mesh);
    for (std::size_t node = num_before; node < parted.before.size(); ++node) {
        const int parent = parted.parent_node[node];
        original_node_.push_back(int{original_node_[parent]});
        is_constrained_.push_back(bool{is_constrained_[parent]});
    }
    stand_on_foundation();
    springs_.clear();
    const auto &settings = prepared->settings;
    const auto conditions = constrained_conditions(is_constrained_);
    Prepared next{with_material(body_, settings.young_modulus, settings.poisson_ratio),
                  mass_springs(body_, settings, springs_),
                  settings,
                  prepared->stepping,
                  nullptr,
                  prepared->num_cuts};
    if (foundation_)
        next.parts.body.add(foundation_);
    // A stiff part with scaled masses, of which a tetrahedron has changed, ends the scaling of all.
    auto &stepping = next.stepping;
    const auto scaling = prepared->rest ? scaling_of_whole(*prepared->rest) : stepping.scaling;
    if (untouched_parts(scaling, body_.mesh, parted.changed).parts.size() < scaling.parts.size()) {
        stepping.scaling = {};
        stepping.chosen = stepping.unscaled;
        stepping.chosen.time_step = time_step_ / num_parts_of(time_step_, stepping.chosen.longest_time_step);
    }
    if (prepared->rest) {
        auto rest =
            refit_rest(*prepared->rest, next.body, foundation_, is_gone(prepared->num_cuts), conditions, settings);
        rest.stepping = stepping;
        next.rest = std::make_shared<const FittedRest>(std::move(rest));
    }
    prepared_ = std::make_shared<const Prepared>(std::move(next));
}

/// Has the nodes of a parted body where they were in the body before, with its velocity there.
/// @param state  of the body before
void Scene::move_parted(const std::vector<PlaceBefore> &before, const msm::State &state) {
    const auto size = static_cast<Eigen::Index>(3 * before.size());
    msm::State next{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
    for (std::size_t node = 0; node < before.size(); ++node)
        for (std::size_t k = 0; k < 4; ++k) {
            const auto from = 3 * static_cast<Eigen::Index>(before[node].nodes[k]);
            const auto to = 3 * static_cast<Eigen::Index>(node);
            next.displacement.segment<3>(to) += before[node].weight[k] * state.displacement.segment<3>(from);
            next.velocity.segment<3>(to) += before[node].weight[k] * state.velocity.segment<3>(from);
        }
    steps_.reset(); // of another number of nodes
    prepare_steps(!needle_);
    steps_->set_state(next);
    if (!next.displacement.isZero(0.0))
        divided_steps_ = num_divided;
}

CutReading Scene::cut(const CutRequest &request) {
    if (!steps_)
        throw support::InputError("nothing has been chosen yet that could be cut; choose springs first");
    if (std::ranges::find(cuts_, request.tool, &MadeCut::tool) != cuts_.end())
        throw support::InputError("this cut has been made already; choose another one");
    CutReading reading;
    auto start = core::Clock::now();
    const auto lap = [&] {
        const double seconds = core::seconds_since(start);
        start = core::Clock::now();
        return seconds;
    };
    auto found = find_cut(original_mesh(), body_.mesh, remains_, is_constrained_facet_, stands_,
                          msm::to_field(sound_state().displacement), request);
    reading.seconds_to_find = lap();
    keep();
    take_up({});
    auto gone_then = is_gone(cuts_.size());
    for (const int t : found.tetrahedra)
        gone_then[t] = 1;
    const auto scaling = !are_scaled_      ? msm::MassScaling{}
                         : prepared_->rest ? scaling_of_whole(*prepared_->rest)
                                           : prepared_->stepping.scaling;
    auto around = found.tetrahedra; // what has another shape, or is gone
    std::shared_ptr<const Unparted> before;
    std::optional<msm::State> state;
    std::vector<PlaceBefore> places;
    start = core::Clock::now();
    if (found.parted) {
        state = steps_->state();
        before =
            std::make_shared<const Unparted>(Unparted{body_, original_node_, is_constrained_, foundation_, prepared_});
        around.insert(around.end(), found.parted->changed.begin(), found.parted->changed.end());
        places = found.parted->before;
        reading.jagged = found.parted->jagged;
        reading.snapped = found.parted->snapped;
        part(std::move(*found.parted));
    }
    const double set_up = lap();
    const double critical =
        critical_step_around(prepared_->body, foundation_, gone_then, around, constrained_conditions(is_constrained_),
                             untouched_parts(scaling, body_.mesh, around), prepared_->settings);
    reading.seconds_to_check = lap();
    cuts_.push_back({request.tool, found.tetrahedra, critical, before});
    show_remains();
    if (state) {
        move_parted(places, *state);
    } else {
        take_out(found.tetrahedra);
        touchable_ = touchable_remains();
        divide_steps();
    }
    reading.seconds_of_springs = set_up + lap();
    const auto closed = closed_cavities(remains_);
    reading.volume = found.volume;
    reading.way_volume = found.way_volume;
    reading.closed_volume = closed.volume;
    reading.closed_depth = closed.depth;
    reading.wound_area = wound_area(remains_);
    reading.margin = found.margin;
    reading.num_loose = found.num_loose;
    reading.num_pieces = found.num_pieces;
    return reading;
}

} // namespace livermark::live
