#include "core/modes.hpp"

namespace livermark::core {

double modal_assurance(const TetraMesh &mesh, std::span<const Vector3> a, std::span<const Vector3> b) {
    const auto volumes = nodal_volumes(mesh);
    double aa = 0.0, bb = 0.0, ab = 0.0;
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        aa += volumes[i] * a[i].squaredNorm();
        bb += volumes[i] * b[i].squaredNorm();
        ab += volumes[i] * a[i].dot(b[i]);
    }
    return ab * ab / (aa * bb);
}

} // namespace livermark::core
