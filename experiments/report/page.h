// What all pages of results have in common: head, style, figures.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "experiments/report/figures.h"

namespace romano::experiments {

inline constexpr std::string_view project_title = "ROMANO without a central broker";
/// Up to and with the page's heading; `title` is what the browser calls it.
[[nodiscard]] std::string page_begin(std::string_view title,
                                     std::string_view heading = project_title);
inline constexpr std::string_view page_end = "</body>\n</html>\n";

/// The drawn panels, as many beside each other as the reader's screen has room for; their scripts
/// are left in `scripts`.
[[nodiscard]] std::string panels_to_html(const Plot& plot, const std::filesystem::path& scripts);

/// The drawn panels with their words.
[[nodiscard]] std::string to_html(const Figure& figure, const std::filesystem::path& scripts);

}  // namespace romano::experiments
