#include "studies/arena/whole_nodes.hpp"

#include <fmt/format.h>

#include "support/input_error.hpp"

namespace livermark::studies {

void refuse_single_components(const core::LoadCase &load_case) {
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.is_constrained(f) && load_case.value[f].array().isNaN().any())
            throw support::InputError(
                fmt::format("load case {}: '{}' leaves a component of the displacement free, and interactive methods "
                            "constrain whole nodes; give all three components, or choose another load case",
                            load_case.name, load_case.on(f)->place));
}

} // namespace livermark::studies
