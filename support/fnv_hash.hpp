#pragma once

#include <cstdint>
#include <string_view>

namespace livermark::support {

/// FNV-1a (Fowler, Noll, Vo) of 64 bits: tells contents apart, and is no protection against somebody who wants two of
/// them to look alike.
class FnvHash {
  public:
    /// Bytes of one text, which may come in pieces.
    void add_bytes(std::string_view bytes) {
        for (const char letter : bytes)
            add_byte(static_cast<unsigned char>(letter));
    }
    /// A whole text: two of them are not the same as both in one.
    void add(std::string_view text) {
        add_bytes(text);
        add_byte(0xff);
    }
    std::uint64_t value() const { return value_; }

  private:
    void add_byte(unsigned char byte) {
        value_ ^= byte;
        value_ *= 0x100000001b3ULL;
    }

    std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

} // namespace livermark::support
