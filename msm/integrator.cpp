#include "msm/integrator.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vector>

#include "support/input_error.hpp"

namespace livermark::msm {

const Integrator &find_integrator(const std::string &name, std::span<const Integrator> known) {
    const auto found = std::ranges::find(known, name, &Integrator::name);
    if (found == known.end()) {
        std::vector<std::string> names;
        for (const auto &integrator : known)
            names.push_back(integrator.name);
        throw support::InputError(
            fmt::format("there is no integrator '{}'; known are: {}", name, fmt::join(names, ", ")));
    }
    return *found;
}

} // namespace livermark::msm
