#include "tests/golden.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

namespace livermark::tests {

void expect_golden(const std::string &name, const std::string &text) {
    const auto path = std::filesystem::path(LIVERMARK_SOURCE_DIR) / "tests" / "golden" / (name + ".txt");
    if (std::getenv("LIVERMARK_WRITE_GOLDEN") != nullptr) {
        std::filesystem::create_directories(path.parent_path());
        std::ofstream(path, std::ios::binary) << text;
        return;
    }
    std::ifstream file(path, std::ios::binary);
    ASSERT_TRUE(file) << path << " is not there: call scripts/golden";
    std::stringstream reviewed_text;
    reviewed_text << file.rdbuf();
    if (reviewed_text.str() == text)
        return;
    std::istringstream found_lines(text);
    reviewed_text.seekg(0);
    std::string reviewed, found;
    for (int number = 1;; ++number) {
        const bool is_reviewed = static_cast<bool>(std::getline(reviewed_text, reviewed));
        const bool is_found = static_cast<bool>(std::getline(found_lines, found));
        if (is_reviewed && is_found && reviewed == found)
            continue;
        FAIL() << path << ", line " << number << "\n  reviewed: " << (is_reviewed ? reviewed : "(ends)")
               << "\n  found:    " << (is_found ? found : "(ends)")
               << "\nIf the new text is right, call scripts/golden.";
    }
}

} // namespace livermark::tests
