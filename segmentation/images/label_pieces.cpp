#include "segmentation/images/label_pieces.hpp"

#include <algorithm>
#include <optional>

#include "meshes/generators/surface_mesh.hpp"

namespace livermark::segmentation {

namespace {

using core::Vector3;

Vector3 place_of(const LabelFields &fields, std::size_t sample) {
    const std::size_t row = fields.size[0];
    const std::size_t column = fields.size[1];
    const std::array<std::size_t, 3> index{sample % row, sample / row % column, sample / row / column};
    return fields.low + fields.spacing * Vector3(static_cast<double>(index[0]), static_cast<double>(index[1]),
                                                 static_cast<double>(index[2]));
}

/// Distances in the index to the six samples around one; the grid is wider than the body, so all of them are there.
std::array<std::ptrdiff_t, 6> neighbour_offsets(const LabelFields &fields) {
    const std::ptrdiff_t row = fields.size[0];
    const std::ptrdiff_t slice = row * fields.size[1];
    return {-1, 1, -row, row, -slice, slice};
}

/// All samples of the piece that holds one of them.
std::vector<std::size_t> flood(const LabelDomain &domain, std::size_t start, std::vector<bool> &seen) {
    const auto offsets = neighbour_offsets(domain.fields);
    std::vector<std::size_t> piece{start};
    seen[start] = true;
    for (std::size_t next = 0; next < piece.size(); ++next)
        for (const auto offset : offsets)
            if (const std::size_t other = piece[next] + offset;
                !seen[other] && domain.label[other] == domain.label[start]) {
                seen[other] = true;
                piece.push_back(other);
            }
    return piece;
}

/// The last sample that a front from the border reaches.
std::size_t deepest_sample(const LabelDomain &domain, const std::vector<std::size_t> &piece,
                           std::vector<bool> &reached) {
    const auto offsets = neighbour_offsets(domain.fields);
    const int label = domain.label[piece.front()];
    std::vector<std::size_t> front;
    for (const auto sample : piece)
        if (std::ranges::any_of(offsets, [&](auto offset) { return domain.label[sample + offset] != label; })) {
            front.push_back(sample);
            reached[sample] = true;
        }
    for (std::size_t next = 0; next < front.size(); ++next)
        for (const auto offset : offsets)
            if (const std::size_t other = front[next] + offset; !reached[other] && domain.label[other] == label) {
                reached[other] = true;
                front.push_back(other);
            }
    return front.back();
}

std::optional<BorderPoint> first_border(const LabelDomain &domain, const Vector3 &start, const Vector3 &direction) {
    const int from = label_at(domain, start);
    const double step = 0.5 * domain.fields.spacing;
    const int max_steps = 2 * (domain.fields.size[0] + domain.fields.size[1] + domain.fields.size[2]);
    for (int i = 1; i <= max_steps; ++i) {
        Vector3 there = start + i * step * direction;
        int to = label_at(domain, there);
        if (to == from)
            continue;
        Vector3 here = there - step * direction;
        for (int halving = 0; halving < 20; ++halving) {
            const Vector3 middle = 0.5 * (here + there);
            if (const int label = label_at(domain, middle); label == from) {
                here = middle;
            } else {
                there = middle;
                to = label;
            }
        }
        return BorderPoint{there, from, to};
    }
    return std::nullopt;
}

} // namespace

std::vector<LabelPiece> find_pieces(const LabelDomain &domain, double smallest) {
    const double sample_volume = domain.fields.spacing * domain.fields.spacing * domain.fields.spacing;
    std::vector<bool> seen(domain.label.size(), false);
    std::vector<bool> reached(domain.label.size(), false);
    std::vector<LabelPiece> pieces;
    for (std::size_t sample = 0; sample < domain.label.size(); ++sample) {
        if (domain.label[sample] == outside || seen[sample])
            continue;
        const auto piece = flood(domain, sample, seen);
        pieces.push_back({domain.label[sample], sample_volume * static_cast<double>(piece.size()),
                          place_of(domain.fields, deepest_sample(domain, piece, reached))});
    }
    std::ranges::stable_sort(pieces, [](const auto &a, const auto &b) {
        return a.region != b.region ? a.region < b.region : a.volume > b.volume;
    });
    std::vector<LabelPiece> kept;
    for (const auto &piece : pieces)
        if (piece.volume >= smallest || kept.empty() || kept.back().region != piece.region)
            kept.push_back(piece);
    return kept;
}

std::vector<BorderPoint> border_points(const LabelDomain &domain, const std::vector<LabelPiece> &pieces, double edge) {
    std::vector<BorderPoint> points;
    for (const auto &piece : pieces) {
        const auto rays = [&](const std::vector<Vector3> &directions) {
            std::vector<BorderPoint> found;
            for (const auto &direction : directions)
                if (const auto point = first_border(domain, piece.deepest, direction))
                    found.push_back(*point);
            return found;
        };
        std::vector<Vector3> directions;
        for (int d = 0; d < 3; ++d)
            for (const double sign : {-1.0, 1.0})
                directions.push_back(sign * Vector3::Unit(d));
        auto found = rays(directions);
        double depth = edge;
        for (const auto &point : found)
            depth = std::min(depth, (point.place - piece.deepest).norm());
        // Six directions make an octahedron, which is what a piece of about one edge can be at best.
        if (depth > 0.75 * edge)
            found = rays(meshes::geodesic_sphere(depth > 2.0 * edge ? 2 : 1).points);
        const double apart = std::min(0.6 * edge, 0.9 * depth);
        for (const auto &point : found)
            if (std::ranges::none_of(points,
                                     [&](const auto &other) { return (other.place - point.place).norm() < apart; }))
                points.push_back(point);
    }
    return points;
}

} // namespace livermark::segmentation
