#pragma once

#include <pybind11/pybind11.h>

namespace livermark::python {

/// Lets other threads of Python run while it lives. pybind11's own ends the process by abort() where a thread of a
/// program comes back after the program has ended: Python then ends the thread by pthread_exit(), which goes through
/// all destructors on the way as an exception does, and that one lets none through.
class ReleasedInterpreter {
  public:
    ReleasedInterpreter() : state_(PyEval_SaveThread()) {}
    ~ReleasedInterpreter() noexcept(false) { PyEval_RestoreThread(state_); }
    ReleasedInterpreter(const ReleasedInterpreter &) = delete;
    ReleasedInterpreter &operator=(const ReleasedInterpreter &) = delete;

  private:
    PyThreadState *state_;
};

} // namespace livermark::python
