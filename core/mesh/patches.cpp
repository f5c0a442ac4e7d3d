#include "core/mesh/patches.hpp"

#include <algorithm>

namespace livermark::core {

namespace {

template <class Visit> void for_each_part(std::string_view name, const Visit &visit) {
    for (std::size_t begin = 0; begin <= name.size();) {
        const auto end = std::min(name.find(patch_joint, begin), name.size());
        visit(name.substr(begin, end - begin));
        begin = end + 1;
    }
}

} // namespace

bool is_in_patch(std::string_view name_of_facet, std::string_view patch) {
    bool is_in = name_of_facet == patch;
    for_each_part(name_of_facet, [&](std::string_view part) { is_in = is_in || part == patch; });
    return is_in;
}

std::vector<std::string> patches_of(const TetraMesh &mesh) {
    std::vector<std::string> patches;
    for (const auto &name : mesh.patch_names)
        for_each_part(name, [&](std::string_view part) {
            if (std::ranges::find(patches, part) == patches.end())
                patches.emplace_back(part);
        });
    return patches;
}

std::vector<int> facets_in_patch(const TetraMesh &mesh, std::string_view patch) {
    std::vector<bool> is_in;
    for (const auto &name : mesh.patch_names)
        is_in.push_back(is_in_patch(name, patch));
    std::vector<int> facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (is_in[static_cast<std::size_t>(mesh.boundary_patch[f])])
            facets.push_back(f);
    return facets;
}

} // namespace livermark::core
