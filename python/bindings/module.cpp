#include "python/bindings/errors.hpp"
#include "python/bindings/springs.hpp"
#include "python/bindings/without_interpreter.hpp"

/// Springs and their motion: the components core and msm, and nothing under the GPL.
PYBIND11_MODULE(_livermark, module) {
    module.doc() = "Springs, time steps and simulation of Livermark; import livermark instead.";
    livermark::python::translate_input_errors();
    livermark::python::work_at_the_end::register_with();
    livermark::python::add_springs(module);
    livermark::python::add_time_steps(module);
    livermark::python::add_simulation(module);
}
