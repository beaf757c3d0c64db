// Small files read and written as a whole. Throws SweepError, one sentence that names the file.
#pragma once

#include <filesystem>
#include <string>

namespace romano::experiments {

/// Empty when there is none.
[[nodiscard]] std::string read_text(const std::filesystem::path& file);
void write_text(const std::filesystem::path& file, const std::string& text);
/// With those above it.
void make_folder(const std::filesystem::path& folder);

}  // namespace romano::experiments
