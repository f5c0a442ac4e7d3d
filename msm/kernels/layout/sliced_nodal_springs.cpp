#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/tetrahedron_volume.hpp"

namespace livermark::msm {

namespace {

/// V0_c of each control volume around a node. @return shape (C) [m^3]
std::vector<double> rest_volumes(const StepParts &parts, const Eigen::VectorXd &x) {
    std::vector<double> volume(parts.centre.size(), 0.0);
    for (std::size_t t = 0; t < parts.tetrahedra.size(); ++t)
        for (const int c : parts.corner_volume[t])
            volume[c] += 0.25 * volume_gradient(x, parts.tetrahedra[t]).volume;
    return volume;
}

struct Entry {
    int row, column;
    double value;
};

template <class T> SlicedMatrix<T> sliced_matrix(const std::vector<Entry> &entries, int num_rows) {
    std::vector<int> length(num_rows, 0);
    for (const auto &entry : entries)
        ++length[entry.row];
    SlicedMatrix<T> matrix{slice_offsets(length), {}, {}};
    matrix.column.assign(static_cast<std::size_t>(matrix.offset.back()) * slice_size, 0);
    matrix.value.assign(matrix.column.size(), T(0));
    std::vector<int> used(num_rows, 0);
    for (const auto &[row, column, value] : entries) {
        const auto at = next_index(matrix.offset, row, used[row]);
        matrix.column[at] = column;
        matrix.value[at] = static_cast<T>(value);
    }
    return matrix;
}

} // namespace

template <class T>
void slice_nodal_springs(const StepParts &parts, const std::vector<core::Vector3> &positions,
                         const std::vector<int> &number_of_volume, const Lines &lines, SlicedBody<T> &body) {
    if (parts.coupled_modulus.empty())
        return;
    const bool is_neo_hookean = parts.coupled_energy == CoupledEnergy::neo_hookean;
    const auto x = to_unknowns(positions);
    auto inner = parts.inner_modulus;
    if (is_neo_hookean)
        for (std::size_t t = 0; t < inner.size(); ++t)
            inner[t] *= volume_gradient(x, parts.tetrahedra[t]).volume;
    body.inner_modulus = on_lines<T>(inner, lines);
    for (auto &member : body.member)
        member *= is_neo_hookean ? 4 : 8;
    body.coupled_modulus.assign(body.volume_row.size(), T(0));
    const auto volume = rest_volumes(parts, x);
    for (std::size_t c = 0; c < volume.size(); ++c)
        body.coupled_modulus[number_of_volume[c]] = static_cast<T>(
            is_neo_hookean ? 0.25 * parts.coupled_modulus[c] : parts.coupled_modulus[c] / (16.0 * volume[c]));
    if (!is_neo_hookean)
        return;
    body.inverse_volume.assign(body.volume_row.size(), T(0));
    for (std::size_t c = 0; c < volume.size(); ++c)
        body.inverse_volume[number_of_volume[c]] = static_cast<T>(0.25 / volume[c]);
}

template <class T>
void slice_means(const StepParts &parts, const std::vector<core::Vector3> &positions,
                 const std::vector<int> &number_of_volume, SlicedBody<T> &body) {
    if (parts.mean.empty())
        return;
    const auto volume = rest_volumes(parts, to_unknowns(positions));
    std::vector<Entry> change, pressure;
    for (const auto &[c, other, weight] : parts.mean) {
        const int number = number_of_volume[c], other_number = number_of_volume[other];
        change.push_back({number, other_number, 0.25 * weight / volume[other]});
        const double modulus = parts.volume_stiffness[c] * volume[c];
        pressure.push_back({other_number, number, 0.25 * weight * modulus * volume[c] / volume[other]});
    }
    body.has_logarithmic_volume = parts.has_logarithmic_volume;
    const auto size = static_cast<int>(body.volume_row.size());
    body.mean_change = sliced_matrix<T>(change, size);
    body.mean_pressure = sliced_matrix<T>(pressure, size);
}

template void slice_nodal_springs(const StepParts &, const std::vector<core::Vector3> &, const std::vector<int> &,
                                  const Lines &, SlicedBody<float> &);
template void slice_nodal_springs(const StepParts &, const std::vector<core::Vector3> &, const std::vector<int> &,
                                  const Lines &, SlicedBody<double> &);
template void slice_means(const StepParts &, const std::vector<core::Vector3> &, const std::vector<int> &,
                          SlicedBody<float> &);
template void slice_means(const StepParts &, const std::vector<core::Vector3> &, const std::vector<int> &,
                          SlicedBody<double> &);

} // namespace livermark::msm
