#include "studies/sensitivity/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/mesh/deformation.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "studies/sensitivity/patient.hpp"

namespace livermark::studies {

namespace {

/// The tumour of the largest volume.
int largest_tumour(const core::Body &body, const std::vector<int> &tumours) {
    std::vector<double> volume(body.materials.size(), 0.0);
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        volume[body.mesh.region[t]] += volumes[t];
    return *std::ranges::max_element(tumours, {}, [&](int region) { return volume[region]; });
}

core::Vector3 centroid_displacement(const core::TetraMesh &mesh, const std::vector<core::Vector3> &displacement,
                                    int region) {
    const std::vector<core::Vector3> rest(displacement.size(), core::Vector3::Zero());
    return core::deformation(mesh, displacement).centroid[region] - core::deformation(mesh, rest).centroid[region];
}

double largest_displacement(const std::vector<core::Vector3> &displacement, int num_nodes) {
    double peak = 0.0;
    for (int i = 0; i < num_nodes; ++i)
        peak = std::max(peak, displacement[i].norm());
    return peak;
}

} // namespace

const char *name_of(Output output) {
    switch (output) {
    case Output::stiffness_at_tool:
        return "stiffness_at_tool";
    case Output::peak_displacement:
        return "peak_displacement";
    case Output::tumour_displacement:
        return "tumour_displacement";
    }
    throw std::logic_error("an output without a name");
}

const char *unit_of(Output output) {
    return output == Output::stiffness_at_tool ? "N/m" : "m";
}

std::vector<Output> outputs_of(const core::Problem &nominal) {
    std::vector<Output> outputs;
    if (!core::tool_places(nominal.body->mesh, nominal.load_case).empty())
        outputs.push_back(Output::stiffness_at_tool);
    outputs.push_back(Output::peak_displacement);
    if (!tumour_regions(*nominal.body).empty())
        outputs.push_back(Output::tumour_displacement);
    return outputs;
}

OutputValues values_of(const std::vector<Output> &outputs, const core::Problem &nominal, const core::Problem &problem,
                       const core::Solution &solution) {
    OutputValues found;
    if (solution.status != core::SolutionStatus::ok) {
        found.values.assign(outputs.size(), std::numeric_limits<double>::quiet_NaN());
        found.tumour.setConstant(std::numeric_limits<double>::quiet_NaN());
        return found;
    }
    const auto &mesh = problem.body->mesh;
    for (const auto output : outputs)
        switch (output) {
        case Output::stiffness_at_tool:
            found.values.push_back(
                core::stiffness_at(mesh, problem.load_case, core::tool_places(mesh, problem.load_case), 0, solution));
            break;
        case Output::peak_displacement:
            found.values.push_back(largest_displacement(solution.displacement, nominal.body->mesh.num_nodes()));
            break;
        case Output::tumour_displacement:
            found.tumour = centroid_displacement(mesh, solution.displacement,
                                                 largest_tumour(*nominal.body, tumour_regions(*nominal.body)));
            found.values.push_back(found.tumour.norm());
            break;
        }
    return found;
}

std::vector<double> relative_differences(const std::vector<Output> &outputs, const OutputValues &values,
                                         const OutputValues &reference) {
    std::vector<double> differences;
    for (std::size_t o = 0; o < outputs.size(); ++o)
        differences.push_back(outputs[o] == Output::tumour_displacement
                                  ? (values.tumour - reference.tumour).norm() / reference.tumour.norm()
                                  : values.values[o] / reference.values[o] - 1.0);
    return differences;
}

} // namespace livermark::studies
