#include "msm/integrator.hpp"

#include "support/known_names.hpp"

namespace livermark::msm {

const Integrator &find_integrator(const std::string &name, std::span<const Integrator> known) {
    return support::find_named(known, name, "integrator");
}

} // namespace livermark::msm
