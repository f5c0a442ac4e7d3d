#include "app/server/sessions/live_fem.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/live/find_cut.hpp"
#include "app/live/parameters.hpp"
#include "app/server/sessions/live_body.hpp"
#include "core/stopwatch.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "studies/models/model_table.hpp"
#include "studies/models/pushed_model.hpp"

namespace livermark::server {

/// Remains of a body after cuts, as a body of its own.
struct CutLiveBody {
    LiveBody left;         ///< its boundary triangles in the order of live::Remains
    std::vector<int> node; ///< (N) of each node: its number in the whole body, ascending
    std::size_t num_nodes; ///< of the whole body, with those that are parted
};

namespace {

std::vector<char> marks_of(std::string_view text, std::size_t num_tetrahedra) {
    std::vector<char> marks(num_tetrahedra, 0);
    long last = -1;
    while (!text.empty()) {
        const auto word = text.substr(0, text.find(','));
        long number = -1;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
        if (error != std::errc{} || end != word.data() + word.size() || number <= last ||
            number >= static_cast<long>(num_tetrahedra))
            throw support::InputError(
                fmt::format("gone has '{}', where a number from {} to {} belongs; send tetrahedra "
                            "in ascending order",
                            support::shown(word), last + 1, num_tetrahedra - 1));
        marks[static_cast<std::size_t>(number)] = 1;
        last = number;
        text.remove_prefix(std::min(word.size() + 1, text.size()));
    }
    return marks;
}

/// Parts that blades have changed: nodes that are new or in other places, each with its number and its place [m], and
/// tetrahedra that have other nodes, each with its number and its nodes.
struct PartedNumbers {
    std::vector<double> nodes, tetrahedra;
};

int whole_number(double number, std::size_t end, const char *what) {
    if (!(number >= 0.0 && number < static_cast<double>(end) && number == std::floor(number)))
        throw support::InputError(
            fmt::format("{} has {:g}, where a whole number from 0 to {} belongs", what, number, end - 1));
    return static_cast<int>(number);
}

core::TetraMesh parted_whole(const core::TetraMesh &original, const PartedNumbers &parted) {
    if (parted.nodes.size() % 4 != 0 || parted.tetrahedra.size() % 5 != 0)
        throw support::InputError("parted_nodes takes four numbers for each node and parted_tetrahedra five for each "
                                  "tetrahedron; send them all");
    auto points = original.points;
    for (std::size_t i = 0; i < parted.nodes.size(); i += 4) {
        const auto node = static_cast<std::size_t>(whole_number(parted.nodes[i], points.size() + 1, "parted_nodes"));
        if (node == points.size())
            points.emplace_back();
        points[node] = {parted.nodes[i + 1], parted.nodes[i + 2], parted.nodes[i + 3]};
    }
    auto tetrahedra = original.tetrahedra;
    for (std::size_t i = 0; i < parted.tetrahedra.size(); i += 5) {
        auto &nodes = tetrahedra[static_cast<std::size_t>(
            whole_number(parted.tetrahedra[i], tetrahedra.size(), "parted_tetrahedra"))];
        for (std::size_t k = 0; k < 4; ++k)
            nodes[k] = whole_number(parted.tetrahedra[i + 1 + k], points.size(), "parted_tetrahedra");
    }
    auto mesh = live::parted_mesh(original, std::move(points), std::move(tetrahedra));
    if (std::ranges::any_of(core::tetrahedron_volumes(mesh), [](double volume) { return !(volume > 0.0); }))
        throw support::InputError("a parted tetrahedron has no volume; load the page again");
    return mesh;
}

core::LoadCase constraints_of(const core::LoadCase &whole, const std::vector<int> &facets) {
    auto left = whole;
    left.condition_on.clear();
    left.value.clear();
    for (const int facet : facets) {
        const bool is_wound = facet < 0;
        left.condition_on.push_back(is_wound ? -1 : whole.condition_on[facet]);
        left.value.push_back(is_wound ? core::Vector3(core::Vector3::Constant(std::numeric_limits<double>::quiet_NaN()))
                                      : whole.value[facet]);
    }
    left.foundation = foundation_on(whole.foundation, facets);
    return left;
}

} // namespace

/// @param gone    numbers of tetrahedra of the whole body, with commas between them; each once, ascending
/// @param parted  see parted_whole()
/// @throws support::InputError if they are not that, or nothing is left
CutLiveBody cut_live_body(const LiveBody &whole, const std::string &gone, const PartedNumbers &parted) {
    const auto &original = whole.body->mesh;
    const auto remains = live::remains_of(parted_whole(original, parted), marks_of(gone, original.tetrahedra.size()),
                                          original.boundary_triangles.size());
    if (remains.tetrahedron.empty())
        throw support::InputError("nothing is left of the body; take a smaller part away");
    auto body = *whole.body;
    body.modulus_factor = live::remaining_factors(remains, *whole.body);
    auto &mesh = body.mesh;
    mesh = remains.mesh;
    mesh.points.clear();
    std::vector<int> number(remains.mesh.points.size(), -1);
    for (const auto &tetrahedron : mesh.tetrahedra)
        for (const int node : tetrahedron)
            number[node] = 0;
    CutLiveBody cut{.left = {}, .node = {}, .num_nodes = number.size()};
    for (std::size_t node = 0; node < number.size(); ++node)
        if (number[node] == 0) {
            number[node] = mesh.num_nodes();
            mesh.points.push_back(remains.mesh.points[node]);
            cut.node.push_back(static_cast<int>(node));
        }
    const auto renumber = [&](auto &lists) {
        for (auto &list : lists)
            for (int &node : list)
                node = number[node];
    };
    renumber(mesh.tetrahedra);
    renumber(mesh.boundary_triangles);
    cut.left = {.file = whole.file,
                .body = std::make_shared<const core::Body>(std::move(body)),
                .constrained = constraints_of(whole.constrained, remains.facet)};
    return cut;
}

namespace {

/// A question that is not waited for any longer, see ReportProgress.
struct Interrupted {};

/// CHOLMOD, METIS and BLAS, as they are packaged, do not say that several threads may use them at once; and two factors
/// in the making need the memory of both.
/// @throws Interrupted
std::unique_lock<std::timed_mutex> alone(const ReportProgress &report) {
    constexpr std::chrono::milliseconds between_looks{200};
    static std::timed_mutex mutex;
    std::unique_lock lock(mutex, std::try_to_lock);
    while (!lock && !lock.try_lock_for(between_looks))
        if (!report("Another page is being served."))
            throw Interrupted();
    return lock;
}

bool are_equal(const core::Material &a, const core::Material &b) {
    return a.density == b.density && a.young_modulus == b.young_modulus && a.poisson_ratio == b.poisson_ratio;
}

/// Whether two bodies have the same stiffness, facet by facet.
bool are_equal(const core::Body &a, const core::Body &b) {
    return a.mesh.points == b.mesh.points && a.mesh.tetrahedra == b.mesh.tetrahedra && a.mesh.region == b.mesh.region &&
           a.mesh.boundary_triangles == b.mesh.boundary_triangles && a.modulus_factor == b.modulus_factor &&
           a.capsule == b.capsule && a.vessels == b.vessels &&
           std::ranges::equal(a.materials, b.materials, [](const core::Material &first, const core::Material &second) {
               return are_equal(first, second);
           });
}

/// All that there are, for who asks next.
struct Known {
    std::mutex mutex;
    std::vector<std::weak_ptr<SharedFem>> all;
};

Known &known() {
    static Known known;
    return known;
}

} // namespace

struct SharedFem::Impl {
    std::shared_ptr<const core::Body> body;
    core::LoadCase constrained;
    fem_reference::RepeatedLoads loads;
};

SharedFem::SharedFem(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SharedFem::~SharedFem() = default;

std::shared_ptr<SharedFem> SharedFem::of(const std::shared_ptr<const core::Body> &body,
                                         const core::LoadCase &constrained, const ReportProgress &report) {
    // Whoever wants the same waits here until the first one has made it.
    const auto lock = alone(report);
    const std::lock_guard looking(known().mutex);
    auto &all = known().all;
    std::erase_if(all, [](const auto &one) { return one.expired(); });
    for (const auto &one : all)
        if (auto shared = one.lock(); shared && core::are_statically_equal(shared->impl_->constrained, constrained) &&
                                      are_equal(*shared->impl_->body, *body))
            return shared;
    std::unique_ptr<Impl> impl(new Impl{body, constrained, {*body, constrained, report}});
    std::shared_ptr<SharedFem> made(new SharedFem(std::move(impl)));
    all.push_back(made);
    return made;
}

hyperelastic::PathSolution SharedFem::solve_hyperelastic(const core::Problem &problem, const ReportProgress &report,
                                                         const fem_reference::InnerForces &inner) {
    // Forces out of balance over the loads: the indentation is then right to fewer digits than a page shows.
    constexpr double tolerance = 1e-5;
    constexpr double percent = 100.0;
    const auto lock = alone(report);
    const auto start = core::Clock::now();
    const auto tell = [&](const std::string &sentence) {
        if (!report(sentence))
            throw Interrupted();
    };
    tell(fmt::format("Hyperelastic elements are asked for the same forces: {} tetrahedra are being assembled.",
                     problem.body->mesh.num_tetrahedra()));
    int iterations = 0;
    const auto observe = [&](const hyperelastic::LoadStep &step) {
        const auto asked = fmt::format("Hyperelastic elements are asked for the same forces: after {:.0f} s and {} "
                                       "iterations of Newton's method",
                                       core::seconds_since(start), iterations);
        if (step.residuals.empty())
            return tell(fmt::format("{} it goes to {:g} % of the force.", asked, percent * step.fraction));
        ++iterations;
        if (step.residuals.back() > tolerance)
            tell(fmt::format("{} {:.3g} % of the force is out of balance, and {:g} % is the end.", asked,
                             percent * step.residuals.back(), percent * tolerance));
    };
    const auto elements = *models::hyperelastic_elements(models::static_reference(core::Regime::large).on_mesh);
    auto found =
        hyperelastic::solve(problem, hyperelastic::material_law(std::string(elements.law)), elements.discretisation,
                            {.fractions = {1.0}, .tolerance = tolerance, .observe = observe}, {}, inner);
    if (found.solution.status != core::SolutionStatus::ok)
        throw support::InputError("they find no equilibrium under these forces; push less");
    return found;
}

int SharedFem::count() {
    const std::lock_guard looking(known().mutex);
    return static_cast<int>(std::ranges::count(known().all, false, &std::weak_ptr<SharedFem>::expired));
}

fem_reference::RepeatedLoads::Solution SharedFem::solve(const core::LoadCase &load_case, std::vector<double> &last,
                                                        const ReportProgress &report,
                                                        const fem_reference::InnerForces &inner) {
    const auto lock = alone(report);
    auto solution = impl_->loads.solve(load_case, last, inner);
    if (!solution.is_unique)
        throw support::InputError(
            "what is constrained leaves the body, or a part of it, free to move as a rigid body; choose a "
            "result whose load case constrains it in all six ways");
    if (!solution.has_converged)
        throw support::InputError("the iterations do not come to an end; choose a smaller Poisson's ratio");
    return solution;
}

namespace {

static_assert(std::endian::native == std::endian::little, "messages are copied as they lie in memory");

constexpr double largest_radius = 1e3, smallest_spread = 1e-3; // [m]

using Row = std::array<double, 4>; ///< facet, traction [Pa]; the first one of a message: middle, radius [m]

std::vector<Row> rows_of(const std::string &bytes) {
    if (bytes.size() % sizeof(Row) != 0)
        throw support::InputError(
            fmt::format("the message has {} bytes, which are no whole rows; send the middle and the radius of "
                        "a round load, then facets and three components of their tractions, as four float64 each",
                        bytes.size()));
    std::vector<Row> rows(bytes.size() / sizeof(Row));
    if (!rows.empty())
        std::memcpy(rows.data(), bytes.data(), bytes.size());
    return rows;
}

/// Spread of the tractions; nothing where they are even on each facet.
std::optional<core::RoundLoad> round_load(const Row &row) {
    const auto [x, y, z, radius] = row;
    const core::Vector3 middle(x, y, z);
    if (!middle.allFinite() || !(radius >= 0.0 && radius < largest_radius))
        throw support::InputError(fmt::format(
            "a round load of radius {:g} m around ({:g}, {:g}, {:g}) m is none; send a "
            "finite middle, and a radius below {:g} m, which is 0 for tractions that are even on each facet",
            radius, x, y, z, largest_radius));
    return radius > 0.0 ? std::optional(core::RoundLoad{middle, radius}) : std::nullopt;
}

/// @param factor  of all tractions
core::LoadCase with_tractions(core::LoadCase load_case, const std::optional<core::RoundLoad> &shape,
                              std::span<const Row> rows, double factor) {
    const auto num_facets = load_case.num_facets();
    const auto pressed = static_cast<int>(load_case.conditions.size());
    load_case.conditions.push_back({"probe", core::ConditionKind::traction, shape});
    std::vector<bool> is_taken(num_facets, false);
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const auto [number, x, y, z] = rows[r];
        if (!(number >= 0.0 && number < num_facets && number == std::floor(number)))
            throw support::InputError(
                fmt::format("row {}: {:g} is no facet; send whole numbers from 0 to {}", r, number, num_facets - 1));
        const core::Vector3 traction(x, y, z);
        if (!traction.allFinite())
            throw support::InputError(fmt::format("row {}: the traction is not finite; send numbers in Pa", r));
        const auto facet = static_cast<int>(number);
        if (is_taken[facet])
            throw support::InputError(
                fmt::format("row {}: facet {} has a traction already; send the sum of the two", r, facet));
        is_taken[facet] = true;
        if (!load_case.is_free(facet))
            continue; // what pulls at all that is constrained moves nothing
        load_case.condition_on[facet] = pressed;
        load_case.value[facet] = factor * traction;
    }
    return load_case;
}

/// A needle as far as its forces say where they act.
struct Pierced {
    fem_reference::InnerForces inner;
    int target = 0; ///< number of its place
};

Pierced pierced(const Fields &fields, double factor) {
    constexpr std::size_t numbers_of_needle = 7;
    const auto needle = required_numbers(fields, "needle"), forces = required_numbers(fields, "forces");
    if (needle.size() != numbers_of_needle)
        throw support::InputError(fmt::format("needle has {} numbers; send entry, target and the radius over which "
                                              "forces are spread",
                                              needle.size()));
    const core::Vector3 entry(needle[0], needle[1], needle[2]), target(needle[3], needle[4], needle[5]);
    const double spread = needle[6], length = (target - entry).norm();
    if (!(spread >= smallest_spread && spread < length && length < largest_radius))
        throw support::InputError(fmt::format("a needle of {:g} m, whose forces are spread over {:g} m, is none; send "
                                              "a target that is farther from the entry than the spread, which is at "
                                              "least {:g} m",
                                              length, spread, smallest_spread));
    auto line = core::needle_line({.name = {}, .entry = entry, .target = target, .spread = spread});
    if (forces.size() != 3 * line.places.size())
        throw support::InputError(fmt::format("there are {} forces, and the needle has {} places; send three numbers "
                                              "for each of these",
                                              forces.size(), line.places.size()));
    Pierced pierced{{std::move(line.places), {}}, line.target};
    for (std::size_t i = 0; i < forces.size(); i += 3)
        pierced.inner.forces.emplace_back(factor * core::Vector3(forces[i], forces[i + 1], forces[i + 2]));
    return pierced;
}

Message binary(std::span<const double> numbers, const std::vector<Eigen::Vector3f> &displacement) {
    const auto bytes_of = [](const auto *values, std::size_t count) {
        return std::string(reinterpret_cast<const char *>(values), count * sizeof(*values));
    };
    return {.is_binary = true,
            .bytes = bytes_of(numbers.data(), numbers.size()) + bytes_of(displacement.data(), displacement.size())};
}

double young_modulus_of(const core::Body &body) {
    return body.materials[live::largest_region(body.mesh)].young_modulus;
}

class LiveFem {
  public:
    LiveFem(LiveBody opened, const ReportProgress &report)
        : whole_(std::move(opened)), opened_(whole_), report_(report), body_(opened_.body),
          young_modulus_(young_modulus_of(*body_)) {}

    Message reply(const Message &message) {
        try {
            return reply_to(message);
        } catch (const Interrupted &) {
            return {.is_binary = false, .bytes = fields_text({{"interrupted", "by the next message"}})};
        }
    }

  private:
    Message reply_to(const Message &message) {
        if (message.is_binary)
            return respond(message.bytes);
        const auto fields = parse_fields(message.bytes);
        if (fields.contains("needle"))
            return pierce(fields);
        if (fields.contains("elements"))
            return take_elements(required_text(fields, "elements"));
        return fields.contains("gone") ? cut(fields) : choose(fields);
    }

    Message cut(const Fields &fields) {
        const auto numbers = [&](const char *name) {
            return fields.contains(name) ? required_numbers(fields, name) : std::vector<double>{};
        };
        const PartedNumbers parted{numbers("parted_nodes"), numbers("parted_tetrahedra")};
        // A body that is parted alone has lost nothing.
        const auto &gone = parted.tetrahedra.empty() ? required_text(fields, "gone") : fields.at("gone");
        auto cut = cut_live_body(whole_, gone, parted);
        num_nodes_ = cut.num_nodes;
        elements_.reset(); // before others need the memory
        last_.clear();
        poisson_ratio_.reset();
        stiffening_ = 1.0;
        opened_ = std::move(cut.left);
        young_modulus_ = young_modulus_of(*opened_.body);
        node_ = std::move(cut.node);
        body_ = opened_.body;
        return {.is_binary = false, .bytes = fields_text({{"nodes", std::to_string(node_.size())}})};
    }

    Message choose(const Fields &fields) {
        const auto chosen = live_material(fields);
        // Displacements are inversely proportional to a factor of all Young's moduli: the stiffness of the file's
        // moduli, and its factor, serve all of them, and only another Poisson's ratio needs new ones. Capsule,
        // vessels and foundation keep theirs, so a body that has some needs new ones for each.
        stiffening_ = chosen.young_modulus / young_modulus_of(*whole_.body);
        double young_modulus = young_modulus_of(*opened_.body);
        if (opened_.body->capsule || opened_.body->vessels || opened_.constrained.foundation)
            young_modulus *= std::exchange(stiffening_, 1.0);
        if (poisson_ratio_ != chosen.poisson_ratio || young_modulus_ != young_modulus) {
            elements_.reset(); // before others need the memory
            last_.clear();
            body_ = std::make_shared<const core::Body>(
                live::with_material(*opened_.body, young_modulus, chosen.poisson_ratio));
        }
        poisson_ratio_ = chosen.poisson_ratio;
        young_modulus_ = young_modulus;
        return {.is_binary = false,
                .bytes = fields_text({{"chosen", models::moving_reference(core::Regime::small).on_mesh}})};
    }

    Message take_elements(const std::string &name) {
        if (name != "linear" && name != "hyperelastic")
            throw support::InputError(
                fmt::format("elements are '{}'; send linear or hyperelastic", support::shown(name)));
        are_hyperelastic_ = name == "hyperelastic";
        const auto model = are_hyperelastic_ ? models::static_reference(core::Regime::large)
                                             : models::moving_reference(core::Regime::small);
        return {.is_binary = false, .bytes = fields_text({{"chosen", model.on_mesh}})};
    }

    Message respond(const std::string &bytes) {
        const auto rows = rows_of(bytes);
        if (rows.empty())
            return binary(std::array{0.0}, on_whole_body({}));
        const auto load_case = with_tractions(opened_.constrained, round_load(rows.front()), std::span(rows).subspan(1),
                                              1.0 / stiffening_);
        if (are_hyperelastic_) {
            // Their energy is in proportion to the moduli as well.
            const auto found = SharedFem::solve_hyperelastic({body_, load_case}, report_);
            return binary(std::array{stiffening_ * found.load_work}, on_whole_body(found.solution.displacement));
        }
        const auto solution = solve(load_case);
        // The tractions were divided by the factor of the moduli; the displacements are those of the whole ones.
        return binary(std::array{stiffening_ * solution.work}, on_whole_body(solution.displacement));
    }

    Message pierce(const Fields &fields) {
        const auto [inner, target] = pierced(fields, 1.0 / stiffening_);
        const auto answer = [&, at = static_cast<std::size_t>(target)](double work, const auto &at_places,
                                                                       const auto &displacement) {
            const auto &moved = at_places[at];
            return binary(std::array{stiffening_ * work, moved.x(), moved.y(), moved.z()}, on_whole_body(displacement));
        };
        try {
            if (are_hyperelastic_) {
                const auto found = SharedFem::solve_hyperelastic({body_, opened_.constrained}, report_, inner);
                return answer(found.load_work, found.at_places, found.solution.displacement);
            }
            const auto solution = solve(opened_.constrained, inner);
            return answer(solution.work, solution.at_places, solution.displacement);
        } catch (const std::invalid_argument &) {
            throw support::InputError("a part of the needle is outside the body; choose another entry or target");
        }
    }

    fem_reference::RepeatedLoads::Solution solve(const core::LoadCase &load_case,
                                                 const fem_reference::InnerForces &inner = {}) {
        if (!elements_)
            elements_ = SharedFem::of(body_, opened_.constrained, report_);
        return elements_->solve(load_case, last_, report_, inner);
    }

    /// @param on_left  displacements of the nodes of what is left, or none
    std::vector<Eigen::Vector3f> on_whole_body(const std::vector<core::Vector3> &on_left) {
        std::vector<Eigen::Vector3f> displacement(num_nodes_, Eigen::Vector3f::Zero());
        for (std::size_t i = 0; i < on_left.size(); ++i)
            displacement[node_.empty() ? i : static_cast<std::size_t>(node_[i])] = on_left[i].cast<float>();
        if (!std::ranges::all_of(displacement, [](const Eigen::Vector3f &u) { return u.allFinite(); })) {
            last_.clear();
            throw support::InputError("the body moves farther than a float32 can say; send smaller tractions");
        }
        return displacement;
    }

    LiveBody whole_;
    LiveBody opened_;       ///< what cuts have left of it
    std::vector<int> node_; ///< of each node of that, its number in the whole body; empty while nothing is cut
    std::size_t num_nodes_ = whole_.body->mesh.points.size(); ///< with those that are parted
    ReportProgress report_;
    std::shared_ptr<const core::Body> body_; ///< with the Young's moduli of the file, or those chosen beside a
                                             ///< capsule, vessels or a foundation
    double young_modulus_;                   ///< of the largest region of that [Pa]
    std::shared_ptr<SharedFem> elements_;    ///< of that body; none before the first solution
    std::vector<double> last_;               ///< solution, of all unknowns
    bool are_hyperelastic_ = false;          ///< the elements that answer
    double stiffening_ = 1.0;                ///< of the chosen Young's moduli over those
    std::optional<double> poisson_ratio_;    ///< chosen; none while it is that of the file
};

} // namespace

Session live_fem(const std::filesystem::path &folder, const Fields &query, const ReportProgress &report) {
    return [fem = std::make_shared<LiveFem>(open_live_body(folder, query), report)](const Message &message) {
        return fem->reply(message);
    };
}

} // namespace livermark::server
