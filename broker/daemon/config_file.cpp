#include "broker/daemon/config_file.h"

#include <toml++/toml.h>

#include <cctype>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>

#include "broker/daemon/refusal.h"

namespace romano::daemon {
namespace {

/// What an option's value is in the file; its type name says so.
enum class Kind : std::uint8_t { flag, number, fraction, text, number_or_text };

Kind kind_of(const CLI::Option& option) {
    if (option.get_items_expected_max() == 0) return Kind::flag;
    const std::string type = option.get_type_name();
    if (type.find('|') != std::string::npos) return Kind::number_or_text;
    if (type == "PHI") return Kind::fraction;
    const bool is_number = type == "N" || type == "MS" || type == "MIB" || type == "S" ||
                           (!type.empty() && std::isdigit(static_cast<unsigned char>(type[0])));
    return is_number ? Kind::number : Kind::text;
}

const char* words_for(Kind kind) {
    switch (kind) {
        case Kind::flag:
            return "true or false";
        case Kind::number:
            return "a whole number";
        case Kind::fraction:
            return "a number";
        case Kind::text:
            return "a text in quotes";
        case Kind::number_or_text:
            break;
    }
    return "a whole number or a text in quotes";
}

bool takes_a_list(const CLI::Option& option) {
    return option.get_items_expected_max() > 1;
}

std::string in_line(const toml::source_region& source) {
    return " in line " + std::to_string(source.begin.line);
}

/// Flags go into CLI11 as "true" and "false".
std::optional<std::string> text_of(const toml::node& node, Kind kind) {
    if (kind == Kind::flag) {
        const auto truth = node.value_exact<bool>();
        if (!truth) return std::nullopt;
        return *truth ? "true" : "false";
    }
    if (kind != Kind::text) {
        if (const auto number = node.value_exact<std::int64_t>()) return std::to_string(*number);
    }
    if (kind == Kind::fraction) {
        const auto fraction = node.value_exact<double>();
        if (!fraction) return std::nullopt;
        std::ostringstream text;
        text << *fraction;
        return text.str();
    }
    if (kind != Kind::number) return node.value_exact<std::string>();
    return std::nullopt;
}

std::vector<std::string> values_of(const CLI::Option& option, const std::string& key,
                                   const toml::node& node) {
    const Kind kind = kind_of(option);
    const auto refuse = [&](const toml::node& wrong) {
        const std::string what = takes_a_list(option)
                                     ? std::string("must be a list of: ") + words_for(kind)
                                     : std::string("must be ") + words_for(kind);
        throw Refusal("'" + key + "'" + in_line(wrong.source()) + " " + what);
    };
    std::vector<std::string> values;
    const auto take = [&](const toml::node& one) {
        const auto text = text_of(one, kind);
        if (!text) refuse(one);
        values.push_back(*text);
    };
    const toml::array* list = node.as_array();
    if (list == nullptr) {
        take(node);
    } else if (!takes_a_list(option)) {
        refuse(node);
    } else {
        for (const toml::node& one : *list) take(one);
    }
    return values;
}

std::string all_of(std::istream& input) {
    try {
        return {std::istreambuf_iterator<char>(input), {}};
    } catch (const std::ios_base::failure&) {  // a folder
        throw Refusal("the file cannot be read; give a TOML file");
    }
}

toml::table parse(std::istream& input) {
    try {
        return toml::parse(all_of(input));
    } catch (const toml::parse_error& error) {
        throw Refusal("is no TOML" + in_line(error.source()) + ": " +
                      std::string(error.description()));
    }
}

bool is_setting(const CLI::Option* option) {
    if (option == nullptr) return false;
    const std::string name = option->get_single_name();
    return name != "help" && name != "version" && name != "config" && name != "default-config";
}

}  // namespace

std::vector<CLI::ConfigItem> ConfigFile::from_config(std::istream& input) const {
    const toml::table table = parse(input);
    std::vector<CLI::ConfigItem> settings;
    for (const auto& [name, node] : table) {
        const std::string key{name.str()};
        const CLI::Option* option = app_.get_option_no_throw("--" + key);
        if (!is_setting(option)) {
            throw Refusal("'" + key + "'" + in_line(name.source()) +
                          " is no setting; the keys are the long options of --help");
        }
        CLI::ConfigItem item;
        item.name = key;
        item.inputs = values_of(*option, key, node);
        if (!item.inputs.empty()) settings.push_back(std::move(item));
    }
    return settings;
}

std::string default_config(const CLI::App& app) {
    std::ostringstream out;
    out << "# romano-broker's settings and their defaults. What the command line says goes "
           "before.\n";
    for (const std::string& group : app.get_groups()) {
        const auto in_group = [&group](const CLI::Option* option) {
            return is_setting(option) && option->get_group() == group;
        };
        const auto options = app.get_options(in_group);
        if (options.empty()) continue;
        out << "\n# --- " << (group == "Options" ? "Broker" : group) << '\n';
        for (const CLI::Option* option : options) {
            const std::string key = option->get_single_name();
            const Kind kind = kind_of(*option);
            out << "\n# " << option->get_description() << '\n';
            if (kind == Kind::flag) {
                out << '#' << key << " = false\n";
            } else if (option->get_default_str().empty()) {
                const std::string type = option->get_type_name();
                out << "# " << key << " = "
                    << (takes_a_list(*option) ? "[\"" + type + "\", ...]"
                        : kind == Kind::text  ? '"' + type + '"'
                                              : type)
                    << '\n';
            } else {
                const bool quoted = kind == Kind::text;
                out << '#' << key << " = " << (quoted ? "\"" : "") << option->get_default_str()
                    << (quoted ? "\"" : "") << '\n';
            }
        }
    }
    return out.str();
}

}  // namespace romano::daemon
