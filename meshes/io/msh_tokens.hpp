#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace livermark::meshes {

/// Walks through the words of an MSH file and knows in which line it stands.
class MshTokens {
  public:
    MshTokens(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

    /// @return false at the end of the file
    bool at_word();
    std::string_view word();
    std::string quoted();
    std::int64_t integer();
    /// An integer of at least this size, that fits an int.
    int count(int smallest = 0);
    double number();
    void expect(std::string_view wanted);
    void skip_words(std::int64_t num_words);
    /// Goes on behind the next line that is this word.
    void skip_to(std::string_view wanted);

    /// @throws support::InputError "file:line: what"
    [[noreturn]] void fail(const std::string &what) const;

  private:
    std::string_view text_;
    std::string file_;
    std::size_t position_ = 0;
    int line_ = 1;
};

} // namespace livermark::meshes
