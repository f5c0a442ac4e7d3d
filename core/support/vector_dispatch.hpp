#pragma once

/// Defines a function that calls a kernel in the widest vectors that the machine has. It stands below HWY_ONCE at the
/// end of a source that Highway compiles once for each vector unit, in the namespace around HWY_NAMESPACE.
/// @param function    result and name
/// @param kernel      in HWY_NAMESPACE
/// @param parameters  of both, in brackets
/// @param arguments   their names, in brackets
// NOLINTBEGIN(bugprone-macro-parentheses): brackets are part of the arguments.
#define LIVERMARK_DISPATCH(function, kernel, parameters, arguments)                                                    \
    namespace {                                                                                                        \
    HWY_EXPORT(kernel);                                                                                                \
    }                                                                                                                  \
    function parameters {                                                                                              \
        return HWY_DYNAMIC_DISPATCH(kernel) arguments;                                                                 \
    }
// NOLINTEND(bugprone-macro-parentheses)
