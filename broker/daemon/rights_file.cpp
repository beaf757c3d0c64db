#include "broker/daemon/rights_file.h"

#include <fstream>

namespace romano::daemon {

Result<rights::Rules, std::string> read_rights_file(const std::string& file) {
    std::ifstream input(file, std::ios::binary);
    std::string text(rights::most_octets + 1, '\0');
    input.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (input.bad() || (input.fail() && !input.eof())) {
        return std::string{"cannot be read; give a file as `romano rights usual` prints one"};
    }
    text.resize(static_cast<std::size_t>(input.gcount()));
    auto rules = rights::parse(text);
    if (rules) return std::move(*rules);
    return "line " + std::to_string(rules.error().line) + ": " + rules.error().what;
}

}  // namespace romano::daemon
