#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <optional>
#include <pthread.h>
#include <pybind11/pybind11.h>
#include <string>
#include <thread>
#include <type_traits>
#include <unistd.h>
#include <utility>

#include "core/support/input_error.hpp"

namespace livermark::python {

/// Raises an exception of livermark.errors at the next return to Python.
/// @param type  its name
inline void set_error(const char *type, const char *sentence) {
    const auto package_type = pybind11::module_::import("livermark.errors").attr(type);
    PyErr_SetString(package_type.ptr(), sentence);
}

/// Raises an exception of livermark.errors.
/// @param type  its name
[[noreturn]] inline void raise(const char *type, const std::string &sentence) {
    set_error(type, sentence.c_str());
    throw pybind11::error_already_set();
}

/// Makes a support::InputError of this module's functions a livermark.InputError with the same sentence.
inline void translate_input_errors() {
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

/// Work that goes on while the program ends would use what the program takes down. So when the interpreter ends it
/// waits for it, but not for long, and other threads begin no more.
namespace work_at_the_end {
inline std::atomic<int> num_running = 0;
inline std::atomic<bool> is_ending = false;
inline std::thread::id ending_thread;

/// Endless wait of a thread of a program that ends, in place of more work.
[[noreturn]] inline void wait_for_the_end() {
    while (true)
        pause();
}

/// For each module, once.
inline void register_with() {
    pthread_atfork(nullptr, nullptr, [] { num_running = 0; }); // the threads are not there
    pybind11::module_::import("atexit").attr("register")(pybind11::cpp_function([] {
        ending_thread = std::this_thread::get_id();
        is_ending = true;
        const pybind11::gil_scoped_release others_go_on;
        constexpr auto longest = std::chrono::seconds(5);
        for (const auto start = std::chrono::steady_clock::now();
             num_running > 0 && std::chrono::steady_clock::now() - start < longest;)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }));
}
} // namespace work_at_the_end

/// Does work while other threads of Python run, and returns what it returns or throws what it throws.
///
/// pybind11's own way ends the process by abort() where a thread of a program comes back after the program has ended:
/// Python then ends the thread by pthread_exit(), which goes through all destructors on the way as an exception does.
/// So the interpreter is taken back outside of any destructor, and with no exception on its way.
template <class Work> auto without_interpreter(const Work &work) {
    using Found = std::invoke_result_t<Work>;
    PyThreadState *const state = PyEval_SaveThread();
    using namespace work_at_the_end;
    ++num_running;
    if (is_ending && std::this_thread::get_id() != ending_thread) {
        --num_running;
        wait_for_the_end();
    }
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
    --num_running;
    PyEval_RestoreThread(state);
    if (thrown)
        std::rethrow_exception(thrown);
    if constexpr (!std::is_void_v<Found>)
        return std::move(*found);
}

} // namespace livermark::python
