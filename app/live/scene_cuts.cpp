#include "app/live/parameters.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

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

FittedRest fit_rest(const core::Body &body, const FoundationTerm &foundation, const std::vector<char> &is_gone,
                    const msm::NodalConditions &conditions, const Settings &settings) {
    std::vector<char> is_there;
    for (const char gone : is_gone)
        is_there.push_back(gone == 0 ? 1 : 0);
    auto part = msm::part_of_body(body, is_there, conditions);
    auto springs = springs_of_part(part, foundation, is_gone.size(), settings);
    auto stepping = chosen_steps(part.body, springs, part.conditions, settings);
    return {std::move(part), std::move(springs), std::move(stepping)};
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
                             : remains_of(body_.mesh, is_gone(cuts_.size()));
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
    if (!steps_->remove(tetrahedra))
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
    fewest_parts_ = are_unscaled || part < 1.0 ? num_parts_of(time_step_, part * lengths.longest_time_step) : 1;
    num_parts_ = fewest_parts_ * num_parts_of(time_step_ / fewest_parts_, part * lengths.pressed_time_step);
}

void Scene::undo_cuts(std::size_t num_left) {
    cuts_.resize(num_left);
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
    const auto found = find_cut(body_.mesh, remains_, is_constrained_facet_, stands_,
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
    start = core::Clock::now();
    const double critical = critical_step_around(
        prepared_->body, foundation_, gone_then, found.tetrahedra, constrained_conditions(is_constrained_),
        untouched_parts(scaling, body_.mesh, found.tetrahedra), prepared_->settings);
    reading.seconds_to_check = lap();
    take_out(found.tetrahedra);
    reading.seconds_of_springs = lap();
    cuts_.push_back({request.tool, found.tetrahedra, critical});
    show_remains();
    touchable_ = touchable_remains();
    divide_steps();
    reading.volume = found.volume;
    reading.wound_area = wound_area(remains_);
    reading.margin = found.margin;
    reading.num_loose = found.num_loose;
    reading.num_pieces = found.num_pieces;
    return reading;
}

} // namespace livermark::live
