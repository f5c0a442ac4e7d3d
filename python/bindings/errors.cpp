#include "python/bindings/errors.hpp"

#include <exception>

#include "support/input_error.hpp"

namespace livermark::python {

namespace {

void set_error(const char *type, const char *sentence) {
    const auto of_package = pybind11::module_::import("livermark.errors").attr(type);
    PyErr_SetString(of_package.ptr(), sentence);
}

} // namespace

void translate_input_errors() {
    // NOLINTNEXTLINE(performance-unnecessary-value-param): pybind11 asks for this signature
    pybind11::register_local_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown)
                std::rethrow_exception(thrown);
        } catch (const support::InputError &error) {
            set_error("InputError", error.what());
        }
    });
}

void raise(const char *type, const std::string &sentence) {
    set_error(type, sentence.c_str());
    throw pybind11::error_already_set();
}

} // namespace livermark::python
