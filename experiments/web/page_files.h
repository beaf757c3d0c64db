// The page's files, which are part of the program: page/ as it was when it was built.
#pragma once

#include <span>
#include <string_view>

namespace romano::experiments {

struct PageFile {
    std::string_view path;  // "/fleet.js"
    std::string_view content_type;
    std::string_view content;
};

[[nodiscard]] std::span<const PageFile> page_files();

}  // namespace romano::experiments
