// Where the compiler reports what counting kernels read and write. They are compiled for ThreadSanitizer
// (-fsanitize=thread) and not linked with it, so its calls come here. This file itself is compiled without.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "benchmarks/work/counts.hpp"

namespace livermark::benchmarks {

namespace {

/// A cache with the line that was not used for longest in each set replaced. It is smaller than what a step of any
/// body here goes through, and larger than what a part of a pass comes back to. So what each pass over the body reads
/// and writes goes to memory once, and nodes that neighbours share do not go again.
class ModelCache {
  public:
    static constexpr std::uintptr_t line_size = 64;
    static constexpr std::size_t num_sets = 256, num_ways = 16; // 256 KiB

    void access(std::uintptr_t at, std::uintptr_t size, bool writes) {
        for (std::uintptr_t line = at / line_size; line <= (at + size - 1) / line_size; ++line)
            access_line(line, writes);
    }
    std::uint64_t num_moved() const { return num_moved_; } ///< lines, both ways
    void begin() {
        clean();
        num_moved_ = 0;
    }
    /// What was written goes back.
    void clean() {
        for (auto &set : sets_)
            for (auto &entry : set) {
                num_moved_ += entry.is_dirty ? 1 : 0;
                entry.is_dirty = false;
            }
    }

  private:
    struct Entry {
        std::uintptr_t line = 0;
        bool is_dirty = false;
    };

    void access_line(std::uintptr_t line, bool writes) {
        auto &set = sets_[line % num_sets];
        auto entry = std::find_if(set.begin(), set.end(), [&](const Entry &each) { return each.line == line; });
        if (entry == set.end()) {
            --entry;
            num_moved_ += entry->is_dirty ? 2 : 1;
            *entry = {line, false};
        }
        entry->is_dirty = entry->is_dirty || writes;
        std::rotate(set.begin(), entry, entry + 1); // the last one used comes first
    }

    std::array<std::array<Entry, num_ways>, num_sets> sets_{};
    std::uint64_t num_moved_ = 0;
};

ModelCache cache;
std::uint64_t num_operations = 0;
bool is_counting = false;

void report(const void *at, std::size_t size, bool writes) {
    if (is_counting && size > 0)
        cache.access(reinterpret_cast<std::uintptr_t>(at), size, writes);
}

} // namespace

void begin_counting() {
    cache.begin();
    num_operations = 0;
    is_counting = true;
}

Work end_counting() {
    is_counting = false;
    cache.clean();
    return {num_operations, cache.num_moved() * ModelCache::line_size};
}

void count_operations(int number) {
    if (is_counting)
        num_operations += static_cast<std::uint64_t>(number);
}

} // namespace livermark::benchmarks

// What GCC and Clang call for ThreadSanitizer.
using livermark::benchmarks::report;
#define LIVERMARK_ACCESSES(size)                                                                                       \
    void __tsan_read##size(void *at) {                                                                                 \
        report(at, size, false);                                                                                       \
    }                                                                                                                  \
    void __tsan_write##size(void *at) {                                                                                \
        report(at, size, true);                                                                                        \
    }                                                                                                                  \
    void __tsan_unaligned_read##size(void *at) {                                                                       \
        report(at, size, false);                                                                                       \
    }                                                                                                                  \
    void __tsan_unaligned_write##size(void *at) {                                                                      \
        report(at, size, true);                                                                                        \
    }
extern "C" {
LIVERMARK_ACCESSES(1)
LIVERMARK_ACCESSES(2)
LIVERMARK_ACCESSES(4)
LIVERMARK_ACCESSES(8)
LIVERMARK_ACCESSES(16)
void __tsan_read_range(void *at, std::size_t size) { // NOLINT(bugprone-reserved-identifier)
    report(at, size, false);
}
void __tsan_write_range(void *at, std::size_t size) { // NOLINT(bugprone-reserved-identifier)
    report(at, size, true);
}
void __tsan_vptr_read(void *at) { // NOLINT(bugprone-reserved-identifier)
    report(at, sizeof(void *), false);
}
void __tsan_vptr_update(void *at, void * /*value*/) { // NOLINT(bugprone-reserved-identifier)
    report(at, sizeof(void *), true);
}
void __tsan_init() {}                        // NOLINT(bugprone-reserved-identifier)
void __tsan_func_entry(void * /*caller*/) {} // NOLINT(bugprone-reserved-identifier)
void __tsan_func_exit() {}                   // NOLINT(bugprone-reserved-identifier)
// NOLINTNEXTLINE(bugprone-reserved-identifier)
unsigned int __tsan_atomic32_fetch_add(volatile void *at, unsigned int value, int /*order*/) {
    return __atomic_fetch_add(static_cast<volatile unsigned int *>(at), value, __ATOMIC_SEQ_CST);
}
unsigned char __tsan_atomic8_load(const volatile void *at, int /*order*/) { // NOLINT(bugprone-reserved-identifier)
    return __atomic_load_n(static_cast<const volatile unsigned char *>(at), __ATOMIC_SEQ_CST);
}
}
