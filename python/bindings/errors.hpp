#pragma once

#include <pybind11/pybind11.h>

namespace livermark::python {

/// Makes a support::InputError of this module's functions a livermark.InputError with the same sentence.
void translate_input_errors();

} // namespace livermark::python
