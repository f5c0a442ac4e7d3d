#pragma once

#include <exception>
#include <optional>
#include <pybind11/pybind11.h>
#include <type_traits>
#include <utility>

namespace livermark::python {

/// Does work while other threads of Python run, and returns what it returns or throws what it throws.
///
/// pybind11's own way ends the process by abort() where a thread of a program comes back after the program has ended:
/// Python then ends the thread by pthread_exit(), which goes through all destructors on the way as an exception does.
/// So the interpreter is taken back outside of any destructor, and with no exception on its way.
template <class Work> auto without_interpreter(const Work &work) {
    using Found = std::invoke_result_t<Work>;
    PyThreadState *const state = PyEval_SaveThread();
    std::exception_ptr thrown;
    std::optional<std::conditional_t<std::is_void_v<Found>, bool, Found>> found;
    try {
        if constexpr (std::is_void_v<Found>)
            work();
        else
            found.emplace(work());
    } catch (...) {
        thrown = std::current_exception();
    }
    PyEval_RestoreThread(state);
    if (thrown)
        std::rethrow_exception(thrown);
    if constexpr (!std::is_void_v<Found>)
        return std::move(*found);
}

} // namespace livermark::python
