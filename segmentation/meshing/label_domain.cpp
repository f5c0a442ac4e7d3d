#include "segmentation/meshing/label_domain.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace livermark::segmentation {

namespace {

using core::Vector3;

/// The cube of samples around a place, and how far in it lies.
struct Cell {
    std::array<std::size_t, 8> sample;
    std::array<double, 8> share;
};

bool find_cell(const LabelFields &fields, const Vector3 &place, Cell &cell) {
    std::array<std::size_t, 3> index;
    Vector3 part;
    for (int d = 0; d < 3; ++d) {
        const double position = (place[d] - fields.low[d]) / fields.spacing;
        if (!(position >= 0.0 && position < fields.size[d] - 1))
            return false;
        index[d] = static_cast<std::size_t>(position);
        part[d] = position - static_cast<double>(index[d]);
    }
    const std::size_t row = fields.size[0];
    const std::size_t slice = row * fields.size[1];
    const std::size_t first = index[0] + row * index[1] + slice * index[2];
    for (std::size_t c = 0; c < 8; ++c) {
        const bool x = (c & 1U) != 0;
        const bool y = (c & 2U) != 0;
        const bool z = (c & 4U) != 0;
        cell.sample[c] = first + (x ? 1 : 0) + (y ? row : 0) + (z ? slice : 0);
        cell.share[c] = (x ? part[0] : 1.0 - part[0]) * (y ? part[1] : 1.0 - part[1]) * (z ? part[2] : 1.0 - part[2]);
    }
    return true;
}

double interpolate(const std::vector<float> &values, const Cell &cell) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 8; ++c)
        sum += cell.share[c] * static_cast<double>(values[cell.sample[c]]);
    return sum;
}

/// The level that splits values so that `count` of them are above (or all, or none).
double split(std::vector<double> values, double count) {
    const auto above = static_cast<std::size_t>(std::clamp(std::round(count), 0.0, static_cast<double>(values.size())));
    std::ranges::sort(values, std::greater());
    if (values.empty() || above == values.size())
        return 0.0;
    return above == 0 ? values.front() : 0.5 * (values[above - 1] + values[above]);
}

/// The weighted field of the strongest region but one.
double strongest_other(const LabelDomain &domain, std::size_t sample, std::size_t region) {
    double strongest = 0.0;
    for (std::size_t r = 0; r < domain.weight.size(); ++r)
        if (r != region)
            strongest = std::max(strongest, domain.weight[r] * static_cast<double>(domain.fields.inside[r][sample]));
    return strongest;
}

void match_threshold(LabelDomain &domain) {
    double volume = 0.0;
    for (const double v : domain.fields.volume)
        volume += v;
    std::vector<double> values;
    for (const float value : domain.body)
        if (value > 0.0F)
            values.push_back(static_cast<double>(value));
    // Far from 1/2 only for a body that is thinner than its blurred border.
    domain.threshold = std::clamp(split(values, volume / std::pow(domain.fields.spacing, 3)), 0.1, 0.9);
}

/// A region wins a sample where its field over the strongest other is above 1 / weight.
void match_weight(LabelDomain &domain, std::size_t region) {
    std::vector<double> lead;
    for (std::size_t sample = 0; sample < domain.body.size(); ++sample) {
        const auto value = static_cast<double>(domain.fields.inside[region][sample]);
        if (value > 1e-3 && static_cast<double>(domain.body[sample]) > domain.threshold)
            lead.push_back(value / std::max(1e-9, strongest_other(domain, sample, region)));
    }
    const double count = domain.fields.volume[region] / std::pow(domain.fields.spacing, 3);
    domain.weight[region] = 1.0 / std::clamp(split(lead, count), 0.01, 100.0);
}

std::int16_t winner(const LabelDomain &domain, std::size_t sample) {
    if (!(static_cast<double>(domain.body[sample]) > domain.threshold))
        return outside;
    std::size_t best = 0;
    double strongest = -1.0;
    for (std::size_t r = 0; r < domain.weight.size(); ++r)
        if (const double value = domain.weight[r] * static_cast<double>(domain.fields.inside[r][sample]);
            value > strongest) {
            strongest = value;
            best = r;
        }
    return static_cast<std::int16_t>(best);
}

} // namespace

LabelDomain match_volumes(LabelFields fields) {
    LabelDomain domain;
    domain.body.assign(fields.inside.front().size(), 0.0F);
    for (const auto &inside : fields.inside)
        for (std::size_t sample = 0; sample < inside.size(); ++sample)
            domain.body[sample] += inside[sample];
    domain.weight.assign(fields.inside.size(), 1.0);
    domain.fields = std::move(fields);
    match_threshold(domain);
    // Lesions that touch take from each other, so a few rounds; the first region is what they leave.
    const int rounds = domain.weight.size() > 2 ? 3 : 1;
    for (int round = 0; round < rounds; ++round)
        for (std::size_t region = 1; region < domain.weight.size(); ++region)
            match_weight(domain, region);
    for (std::size_t sample = 0; sample < domain.body.size(); ++sample)
        domain.label.push_back(winner(domain, sample));
    return domain;
}

int label_at(const LabelDomain &domain, const Vector3 &place) {
    Cell cell;
    if (!find_cell(domain.fields, place, cell))
        return outside;
    // Where all corners agree so does what lies between them.
    const int first = domain.label[cell.sample[0]];
    if (std::ranges::all_of(cell.sample, [&](std::size_t sample) { return domain.label[sample] == first; }))
        return first;
    if (!(interpolate(domain.body, cell) > domain.threshold))
        return outside;
    // A region that wins none of the corners is left out: it could be no more than a speck between them.
    int best = outside;
    double strongest = -1.0;
    for (std::size_t c = 0; c < cell.sample.size(); ++c) {
        const int label = domain.label[cell.sample[c]];
        if (label == outside || label == best)
            continue;
        const double value = domain.weight[label] * interpolate(domain.fields.inside[label], cell);
        if (value > strongest || (value == strongest && label < best)) {
            strongest = value;
            best = label;
        }
    }
    return best;
}

Levels level_differences(const LabelDomain &domain, const Vector3 &place, const std::vector<int> &labels) {
    Levels levels = Levels::Zero(static_cast<Eigen::Index>(labels.size()) - 1);
    Cell cell;
    if (!find_cell(domain.fields, place, cell))
        return levels;
    const auto value = [&](int label) { return domain.weight[label] * interpolate(domain.fields.inside[label], cell); };
    for (Eigen::Index i = 0; i < levels.size(); ++i)
        levels[i] = labels[i] == outside ? domain.threshold - interpolate(domain.body, cell)
                                         : value(labels[i]) - value(labels[i + 1]);
    return levels;
}

LevelGradients level_gradients(const LabelDomain &domain, const Vector3 &place, const std::vector<int> &labels) {
    const double step = 0.5 * domain.fields.spacing;
    LevelGradients gradients(static_cast<Eigen::Index>(labels.size()) - 1, 3);
    for (int d = 0; d < 3; ++d) {
        const Vector3 offset = step * Vector3::Unit(d);
        gradients.col(d) =
            (level_differences(domain, place + offset, labels) - level_differences(domain, place - offset, labels)) /
            (2.0 * step);
    }
    return gradients;
}

LevelGradients independent_normals(LevelGradients gradients) {
    constexpr double grazing = 0.15; // sine of the angle between two surfaces
    for (Eigen::Index i = 0; i < gradients.rows(); ++i) {
        const double length = gradients.row(i).norm();
        for (Eigen::Index j = 0; j < i; ++j)
            if (const double square = gradients.row(j).squaredNorm(); square > 0.0)
                gradients.row(i) -= gradients.row(i).dot(gradients.row(j)) / square * gradients.row(j);
        if (gradients.row(i).norm() <= grazing * length)
            gradients.row(i).setZero();
    }
    return gradients;
}

Vector3 project_to_levels(const LabelDomain &domain, Vector3 place, const std::vector<int> &labels,
                          const Levels &values) {
    constexpr int max_steps = 5;
    const double close_enough = 1e-3 * domain.fields.spacing;
    const double longest = 2.0 * domain.fields.spacing; // where the field is flat a step would leave for nowhere
    for (int i = 0; i < max_steps; ++i) {
        const LevelGradients gradients = level_gradients(domain, place, labels);
        const LevelGradients normals = independent_normals(gradients);
        const Levels miss = values - level_differences(domain, place, labels);
        Vector3 step = Vector3::Zero();
        for (Eigen::Index row = 0; row < normals.rows(); ++row)
            if (const double square = normals.row(row).squaredNorm(); square > 0.0)
                step += (miss[row] - gradients.row(row).dot(step)) / square * normals.row(row).transpose();
        if (const double length = step.norm(); length > longest)
            step *= longest / length;
        place += step;
        if (step.norm() < close_enough)
            break;
    }
    return place;
}

} // namespace livermark::segmentation
