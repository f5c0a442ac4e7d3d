#include "segmentation/surfaces/plain_surface_text.hpp"

#include <string_view>
#include <utility>

#include "support/file_ending.hpp"

namespace livermark::segmentation {

namespace {

/// Whether an STL file is text with keywords that are not in lower case. Binary files may begin with the same word.
bool has_capitals(const std::string &text) {
    constexpr std::string_view first = "solid", second = "facet";
    constexpr std::size_t looked_at = 1000;
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string::npos || support::lower_case(text.substr(begin, first.size())) != first)
        return false;
    const auto head = text.substr(begin, looked_at);
    return head.find('\0') == std::string::npos && head.find(second) == std::string::npos &&
           support::lower_case(head).find(second) != std::string::npos;
}

/// Without lines ("l 1 2") and points ("p 1").
std::string only_faces(const std::string &text, std::size_t &num_left_out) {
    std::string faces;
    for (std::size_t begin = 0; begin < text.size();) {
        const auto end = text.find('\n', begin);
        const auto next = end == std::string::npos ? text.size() : end + 1;
        const auto word = text.find_first_not_of(" \t", begin);
        const bool is_other = word != std::string::npos && word + 1 < next &&
                              (text[word] == 'l' || text[word] == 'p') &&
                              (text[word + 1] == ' ' || text[word + 1] == '\t');
        if (is_other)
            ++num_left_out;
        else
            faces.append(text, begin, next - begin);
        begin = next;
    }
    return faces;
}

} // namespace

PlainSurfaceText plain_surface_text(std::string text, const std::string &ending) {
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
    PlainSurfaceText plain;
    if (text.starts_with(byte_order_mark)) {
        text.erase(0, byte_order_mark.size());
        plain.text = text;
    }
    if (ending == ".stl" && has_capitals(text))
        plain.text = support::lower_case(text);
    if (ending == ".obj")
        if (auto faces = only_faces(text, plain.num_left_out); plain.num_left_out > 0)
            plain.text = std::move(faces);
    return plain;
}

} // namespace livermark::segmentation
