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
    for (std::size_t c = 0; c < parts.volume_stiffness.size(); ++c)
        body.volume_stiffness[number_of_volume[c]] = static_cast<T>(0.25 * parts.volume_stiffness[c] * volume[c]);
}

template void slice_nodal_springs(const StepParts &, const std::vector<core::Vector3> &, const std::vector<int> &,
                                  const Lines &, SlicedBody<float> &);
template void slice_nodal_springs(const StepParts &, const std::vector<core::Vector3> &, const std::vector<int> &,
                                  const Lines &, SlicedBody<double> &);

} // namespace livermark::msm
