#include "report/patch_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "report/colour_map.hpp"
#include "report/surface_picture.hpp"

namespace livermark::report {

namespace {

using core::Vector3;

/// The boundary with corners of its own for each facet, so that colours end where facets do.
struct Facets {
    std::vector<Vector3> points;
    std::vector<std::array<int, 3>> triangles;
    std::vector<double> values; ///< number of the patch
};

Facets facets_of(const core::TetraMesh &mesh) {
    Facets facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const int first = static_cast<int>(facets.points.size());
        facets.triangles.push_back({first, first + 1, first + 2});
        for (const int node : mesh.boundary_triangles[f]) {
            facets.points.push_back(mesh.points[node]);
            facets.values.push_back(mesh.boundary_patch[f]);
        }
    }
    return facets;
}

/// @param toward  points at who looks
View side_view(const Facets &facets, const Vector3 &right, const Vector3 &toward, int width, double side) {
    View view{.right = right,
              .up = toward.cross(right),
              .toward = toward,
              .low_x = 0.0,
              .low_y = 0.0,
              .pixel = side / width,
              .width = width,
              .height = width};
    std::array<double, 2> low{INFINITY, INFINITY}, high{-INFINITY, -INFINITY};
    for (const auto &point : facets.points)
        for (const auto &[axis, along] : {std::pair{0, view.right}, {1, view.up}}) {
            low.at(axis) = std::min(low.at(axis), point.dot(along));
            high.at(axis) = std::max(high.at(axis), point.dot(along));
        }
    view.low_x = 0.5 * (low[0] + high[0] - side);
    view.low_y = 0.5 * (low[1] + high[1] - side);
    return view;
}

/// Pictures of one height, from left to right.
Picture beside(const std::vector<Picture> &pictures) {
    Picture all{0, pictures.front().height, {}};
    for (const auto &picture : pictures)
        all.width += picture.width;
    for (int y = 0; y < all.height; ++y)
        for (const auto &picture : pictures) {
            const auto row = picture.rgb.begin() + static_cast<std::ptrdiff_t>(3) * y * picture.width;
            all.rgb.insert(all.rgb.end(), row, row + static_cast<std::ptrdiff_t>(3) * picture.width);
        }
    return all;
}

} // namespace

PatchPicture draw_patches(const core::TetraMesh &mesh, int width) {
    const auto facets = facets_of(mesh);
    const double last = std::max(1.0, static_cast<double>(mesh.patch_names.size()) - 1.0);
    const Surface surface{.triangles = facets.triangles,
                          .points = facets.points,
                          .values = facets.values,
                          .largest = last,
                          .quantity = Quantity::displacement};
    Vector3 low = facets.points.front(), high = low;
    for (const auto &point : facets.points) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    const double side = 1.05 * (high - low).maxCoeff();
    PatchPicture drawn;
    std::vector<Picture> pictures;
    const Vector3 x = Vector3::UnitX(), y = Vector3::UnitY(), z = Vector3::UnitZ();
    for (const auto &[right, toward] : {std::pair{x, Vector3(-y)}, {Vector3(-x), y}, {x, z}, {x, Vector3(-z)}})
        pictures.push_back(draw_surface(surface, side_view(facets, right, toward, width, side)));
    drawn.picture = beside(pictures);
    for (std::size_t patch = 0; patch < mesh.patch_names.size(); ++patch)
        drawn.legend.emplace_back(mesh.patch_names[patch],
                                  hex(colour_at(Quantity::displacement, static_cast<double>(patch) / last)));
    return drawn;
}

} // namespace livermark::report
