#include "support/processes/memory.hpp"

#include <fmt/format.h>
#include <new>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace livermark::support {

std::string reason_of(const std::exception &error, std::string_view remedy) {
    const std::string_view text = error.what();
    // deal.II has an exception of its own, of several lines.
    const bool is_of_deal_ii = text.find("tried to allocate some memory") != std::string_view::npos;
    if (is_of_deal_ii || dynamic_cast<const std::bad_alloc *>(&error) != nullptr)
        return fmt::format("there is too little memory; {}", remedy);
    return std::string(text);
}

void return_freed_memory() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

} // namespace livermark::support
