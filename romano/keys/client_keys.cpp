#include "romano/keys/client_keys.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <sstream>
#include <utility>

#include "romano/keys/key_error.h"
#include "romano/keys/private_file.h"
#include "romano/protection/reserve.h"

namespace romano::keys {
namespace {

struct Line {
    OwnKey own;
    bool has_bound = false;
};

std::optional<Role> role_named(std::string_view word) {
    if (word == name_of(Role::robot)) return Role::robot;
    if (word == name_of(Role::person)) return Role::person;
    return std::nullopt;
}

std::optional<protection::Key> key_from(std::string_view text) {
    protection::Key key;
    if (text.size() != 2 * key.size()) return std::nullopt;
    for (std::size_t i = 0; i < key.size(); ++i) {
        const char* from = text.data() + 2 * i;
        const auto [end, error] = std::from_chars(from, from + 2, key[i], 16);
        if (error != std::errc{} || end != from + 2) return std::nullopt;
    }
    return key;
}

class Lines {
public:
    Lines(const std::filesystem::path& file, const std::string& text) : file_(file), text_(text) {}

    std::optional<Line> next() {
        for (std::string text; std::getline(text_, text);) {
            ++number_;
            std::istringstream words(text);
            const std::vector<std::string> all{std::istream_iterator<std::string>(words), {}};
            if (!all.empty() && !all[0].starts_with('#')) return parse(all);
        }
        return std::nullopt;
    }

    [[noreturn]] void refuse(const std::string& why) const {
        throw KeyError(file_.string() + " line " + std::to_string(number_) + ": " + why);
    }

private:
    [[nodiscard]] Line parse(const std::vector<std::string>& words) const {
        if (words.size() < 3 || words.size() > 4) {
            refuse("must be ROLE NAME KEY, and in a client's own file the bound of its numbers");
        }
        const auto role = role_named(words[0]);
        if (!role) refuse("'" + words[0] + "' must be robot or operator");
        if (!is_name(words[1])) {
            refuse("the name '" + words[1] + "' must be 1 to 20 letters, digits, '-' and '_'");
        }
        const auto key = key_from(words[2]);
        if (!key) {
            refuse("the key of " + words[1] + " must be 32 hexadecimal digits, and has " +
                   std::to_string(words[2].size()) + " characters");
        }
        Line line{{words[1], {*role, *key}, 0}, words.size() == 4};
        if (!line.has_bound) return line;
        const std::string& bound = words[3];
        const char* end = bound.data() + bound.size();
        const auto [stop, error] = std::from_chars(bound.data(), end, line.own.bound);
        if (error != std::errc{} || stop != end) {
            refuse("the bound '" + bound + "' is no number; " + words[1] + " needs a new key");
        }
        return line;
    }

    const std::filesystem::path& file_;
    std::istringstream text_;
    int number_ = 0;
};

std::string line_of(std::string_view name, const ClientKey& client) {
    return std::string{name_of(client.role)} + ' ' + std::string{name} + ' ' + hex(client.key);
}

}  // namespace

std::string_view name_of(Role role) {
    return role == Role::robot ? "robot" : "operator";
}

std::vector<std::string> client_ids_of(std::string_view name, Role role) {
    std::vector<std::string> ids{std::string{name}};
    if (role == Role::robot) return ids;
    for (unsigned n = 1; n < sessions_of_a_person; ++n) {
        ids.push_back(ids[0] + '/' + std::to_string(n));
    }
    return ids;
}

protection::RobotKey key_of(const ClientKey& owner, std::string_view client_id) {
    if (owner.role == Role::robot) return {owner.key};
    return protection::session_key({owner.key}, client_id);
}

bool is_name(std::string_view text) {
    constexpr std::size_t longest = 20;
    return !text.empty() && text.size() <= longest && std::ranges::all_of(text, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '-' || c == '_';
    });
}

ClientKeys read_table(const std::filesystem::path& file) {
    const std::string text = read_private_file(file);
    if (text.empty()) throw KeyError(file.string() + ": is empty, and no table; copy it again");
    if (text.back() != '\n') {
        throw KeyError(file.string() + ": its last line has no end, a part may be missing behind " +
                       "it; copy it again, or end the line");
    }
    Lines lines(file, text);
    ClientKeys keys;
    while (const auto line = lines.next()) {
        if (line->has_bound) lines.refuse("is a client's own file and no broker's table");
        if (!keys.emplace(line->own.name, line->own.client).second) {
            lines.refuse(line->own.name + " stands there twice");
        }
    }
    return keys;
}

void write_table(const std::filesystem::path& file, const ClientKeys& keys) {
    std::string text =
        "# The clients whose protected packets a ROMANO broker takes, with their keys. Mode 600.\n";
    for (const auto& [name, client] : keys) text += line_of(name, client) + '\n';
    write_private_file(file, text);
}

OwnKey read_own_key(const std::filesystem::path& file) {
    Lines lines(file, read_private_file(file));
    const auto line = lines.next();
    if (!line) throw KeyError(file.string() + ": holds no key");
    if (!line->has_bound) {
        lines.refuse("is a broker's table, or lacks the bound of the numbers that were used; " +
                     line->own.name + " needs a new key");
    }
    if (lines.next()) lines.refuse("a client's own file has one key");
    if (line->own.bound >= protection::max_number) {
        lines.refuse("all numbers of this key are used; " + line->own.name + " needs a new key");
    }
    return line->own;
}

void write_own_key(const std::filesystem::path& file, const OwnKey& own) {
    write_private_file(
        file,
        "# Whoever has this key is this client. Behind it stands which numbers it has used, kept "
        "by\n"
        "# the program: never go back to an older copy of this file, make a new key.\n" +
            line_of(own.name, own.client) + ' ' + std::to_string(own.bound) + '\n');
}

std::string hex(const protection::Key& key) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const std::uint8_t octet : key) {
        text += digits[octet >> 4U];
        text += digits[octet & 0xFU];
    }
    return text;
}

}  // namespace romano::keys
