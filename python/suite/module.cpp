#include "python/bindings/errors.hpp"
#include "python/bindings/without_interpreter.hpp"
#include "python/suite/problem.hpp"

/// Problems, models and the reference: the whole suite, with deal.II and CHOLMOD behind it.
PYBIND11_MODULE(_suite, module) {
    module.doc() = "Problems, solutions and scores of Livermark; import livermark instead.";
    livermark::python::translate_input_errors();
    livermark::python::work_at_the_end::register_with();
    livermark::python::add_problem(module);
    livermark::python::add_advise(module);
    livermark::python::add_catalogue(module);
    livermark::python::add_cut(module);
}
