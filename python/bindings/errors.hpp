#pragma once

#include <pybind11/pybind11.h>
#include <string>

namespace livermark::python {

/// Makes a support::InputError of this module's functions a livermark.InputError with the same sentence.
void translate_input_errors();

/// Raises an exception of livermark.errors.
/// @param type  its name
[[noreturn]] void raise(const char *type, const std::string &sentence);

} // namespace livermark::python
