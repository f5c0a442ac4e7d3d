#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace livermark::support {

/// Values one behind the other as bytes, for a process of the same program: see own_process.hpp.
class Packer {
  public:
    template <class Value> void put(const Value &value) {
        static_assert(std::is_trivially_copyable_v<Value>);
        append(&value, sizeof(value));
    }
    void put(const std::string &text) {
        put(static_cast<std::uint64_t>(text.size()));
        append(text.data(), text.size());
    }
    template <class Value> void put(const std::vector<Value> &values) {
        put(static_cast<std::uint64_t>(values.size()));
        if constexpr (std::is_trivially_copyable_v<Value>)
            append(values.data(), values.size() * sizeof(Value));
        else
            for (const auto &value : values)
                put(value);
    }
    std::string bytes() && { return std::move(bytes_); }

  private:
    void append(const void *data, std::size_t size) { bytes_.append(static_cast<const char *>(data), size); }
    std::string bytes_;
};

/// The same values in the same order.
class Unpacker {
  public:
    explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}

    template <class Value> void get(Value &value) { take(&value, sizeof(value)); }
    void get(std::string &text) {
        text.resize(count());
        take(text.data(), text.size());
    }
    template <class Value> void get(std::vector<Value> &values) {
        values.resize(count());
        if constexpr (std::is_trivially_copyable_v<Value>)
            take(values.data(), values.size() * sizeof(Value));
        else
            for (auto &value : values)
                get(value);
    }

  private:
    std::size_t count() {
        std::uint64_t number = 0;
        get(number);
        if (number > bytes_.size()) // no value has less than a byte
            throw std::runtime_error("a process has sent less than it said");
        return static_cast<std::size_t>(number);
    }
    void take(void *to, std::size_t size) {
        if (size > bytes_.size())
            throw std::runtime_error("a process has sent less than it said");
        if (size > 0)
            std::memcpy(to, bytes_.data(), size);
        bytes_.remove_prefix(size);
    }
    std::string_view bytes_;
};

} // namespace livermark::support
