// Small files with secrets: read only when nobody else may read them, written whole or not at all.
#pragma once

#include <filesystem>
#include <string>

namespace romano::keys {

/// Throws KeyError also when others than the owner may read or write it.
[[nodiscard]] std::string read_private_file(const std::filesystem::path& file);

/// In place of what is there, with mode 600. After a crash, a power cut included, the file is the
/// old one or the new one. Throws KeyError.
void write_private_file(const std::filesystem::path& file, const std::string& text);

}  // namespace romano::keys
