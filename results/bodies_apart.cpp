#include "results/bodies_apart.hpp"

#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <string_view>
#include <utility>

#include "support/fnv_hash.hpp"

namespace livermark::results {

namespace {

template <class Row> std::string_view bytes_of(const std::vector<Row> &rows) {
    return {reinterpret_cast<const char *>(rows.data()), rows.size() * sizeof(Row)};
}

std::uint32_t digits_of(const core::TetraMesh &mesh) {
    support::FnvHash hash;
    hash.add(bytes_of(mesh.points));
    hash.add(bytes_of(mesh.tetrahedra));
    hash.add(bytes_of(mesh.region));
    return static_cast<std::uint32_t>(hash.value() >> 32);
}

} // namespace

std::vector<std::string> tell_bodies_apart(std::span<Result> results) {
    std::vector<std::uint32_t> digits;
    std::map<std::string, std::map<std::uint32_t, std::string>> names; // by body and digits
    for (const auto &result : results) {
        const auto &body = *result.problem.body;
        digits.push_back(digits_of(body.mesh));
        names[body.name][digits.back()] = fmt::format("{}#{:08x}", body.name, digits.back());
    }
    std::vector<std::string> sentences;
    for (const auto &[name, of_mesh] : names) {
        if (of_mesh.size() < 2)
            continue;
        std::vector<std::string> apart;
        for (const auto &[mesh, own_name] : of_mesh)
            apart.push_back(own_name);
        sentences.push_back(fmt::format("result files of {} different bodies have the name {}; they are called {}",
                                        of_mesh.size(), name, fmt::join(apart, ", ")));
    }
    for (std::size_t r = 0; r < results.size(); ++r)
        if (const auto &of_mesh = names[results[r].problem.body->name]; of_mesh.size() > 1) {
            auto body = std::make_shared<core::Body>(*results[r].problem.body);
            body->name = of_mesh.at(digits[r]);
            results[r].problem.body = std::move(body);
        }
    return sentences;
}

} // namespace livermark::results
