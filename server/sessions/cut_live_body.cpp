#include "server/sessions/cut_live_body.hpp"

#include <charconv>
#include <fmt/format.h>
#include <limits>
#include <string_view>

#include "live/cutting/remains.hpp"
#include "support/input_error.hpp"

namespace livermark::server {

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
    return left;
}

} // namespace

CutLiveBody cut_live_body(const LiveBody &whole, const std::string &gone) {
    const auto remains = live::remains_of(whole.body->mesh, marks_of(gone, whole.body->mesh.tetrahedra.size()));
    if (remains.tetrahedron.empty())
        throw support::InputError("nothing is left of the body; take a smaller part away");
    auto body = *whole.body;
    auto &mesh = body.mesh;
    mesh = remains.mesh;
    mesh.points.clear();
    std::vector<int> number(remains.mesh.points.size(), -1);
    for (const auto &tetrahedron : mesh.tetrahedra)
        for (const int node : tetrahedron)
            number[node] = 0;
    CutLiveBody cut;
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

} // namespace livermark::server
