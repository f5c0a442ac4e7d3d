#pragma once

#include <exception>
#include <string>
#include <string_view>

namespace livermark::support {

/// What to do where a run needs more memory than there is.
inline constexpr std::string_view memory_remedy = "take --jobs 1, or a mesh of fewer tetrahedra";

/// Why something failed, for a message: what the error says, or, where memory ran out, that and a remedy.
std::string reason_of(const std::exception &error, std::string_view remedy = memory_remedy);

/// Gives the machine back what was freed: blocks that are still there keep an allocator from doing it by itself.
void return_freed_memory();

} // namespace livermark::support
