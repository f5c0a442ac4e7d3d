#pragma once

#include <filesystem>
#include <functional>

namespace livermark::server {

using AskAboutFile = std::function<bool(const std::filesystem::path &)>;

/// Asks once about each file until it changes (inode, size, time of the last change), and keeps the reply: a file
/// with thousands of models takes seconds to be told from others. Copies share what they keep, and threads may ask at
/// once.
AskAboutFile remembered(AskAboutFile ask);

} // namespace livermark::server
