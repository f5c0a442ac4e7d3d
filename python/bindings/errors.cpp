#include "python/bindings/errors.hpp"

#include <exception>

#include "support/input_error.hpp"

namespace livermark::python {

void translate_input_errors() {
    // NOLINTNEXTLINE(performance-unnecessary-value-param): pybind11 asks for this signature
    pybind11::register_local_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown)
                std::rethrow_exception(thrown);
        } catch (const support::InputError &error) {
            const auto type = pybind11::module_::import("livermark.errors").attr("InputError");
            PyErr_SetString(type.ptr(), error.what());
        }
    });
}

} // namespace livermark::python
