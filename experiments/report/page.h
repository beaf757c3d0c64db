// What all pages of results have in common: head, style, figures.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "experiments/report/figures.h"

namespace romano::experiments {

/// Up to and with the page's heading; `title` is what the browser calls it.
[[nodiscard]] std::string page_begin(std::string_view title);
inline constexpr std::string_view page_end = "</body>\n</html>\n";

/// The drawn panels with their words; the plots' scripts are left in `scripts`.
[[nodiscard]] std::string to_html(const Figure& figure, const std::filesystem::path& scripts);

}  // namespace romano::experiments
