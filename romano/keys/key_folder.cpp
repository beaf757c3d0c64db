#include "romano/keys/key_folder.h"

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "romano/keys/broker_record.h"
#include "romano/keys/key_error.h"
#include "romano/keys/peer_papers.h"
#include "romano/keys/private_file.h"
#include "romano/keys/random_octets.h"

namespace romano::keys {
namespace {

namespace fs = std::filesystem;

constexpr const char* of_brokers = "brokers";

const char* folder_name(Role role) {
    return role == Role::robot ? "robots" : "operators";
}

void make_private_folder(const fs::path& folder) {
    std::error_code error;
    if (fs::create_directories(folder, error)) {
        fs::permissions(folder, fs::perms::owner_all, error);
    }
    if (error) throw KeyError(folder.string() + ": cannot be made (" + error.message() + ")");
}

void add_client(ClientKeys& keys, const std::string& name, Role role) {
    if (!is_name(name)) {
        throw KeyError("--" + std::string{name_of(role)} + " '" + name +
                       "': must be 1 to 20 letters, digits, '-' and '_'");
    }
    ClientKey client{role, {}};
    fill_at_random(client.key);
    if (!keys.emplace(name, client).second) {
        throw KeyError("--" + std::string{name_of(role)} + " '" + name +
                       "': has a key already; for a new one say first: romano keys withdraw DIR " +
                       name);
    }
}

std::vector<fs::path> entries_of(const fs::path& folder) {
    std::error_code none;
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder, none)) found.push_back(entry.path());
    std::ranges::sort(found);
    return found;
}

/// Carries on behind what is wrong.
class Findings {
public:
    template <typename Look>
    void look(Look&& at) {
        try {
            at();
        } catch (const KeyError& error) {
            add(error.what());
        }
    }
    void add(std::string sentence) { sentences_.push_back(std::move(sentence)); }
    std::vector<std::string> take() { return std::move(sentences_); }

private:
    std::vector<std::string> sentences_;
};

void check_own_file(const fs::path& file, const ClientKeys* table, Findings& findings) {
    findings.look([&] {
        const OwnKey own = read_own_key(file);
        if (file.stem() != own.name) {
            findings.add(file.string() + ": is the key of " + own.name + "; name it " + own.name +
                         ".key");
        }
        if (table == nullptr) return;
        const auto known = table->find(own.name);
        if (known == table->end()) {
            findings.add(file.string() + ": " + own.name +
                         " stands in no broker's table (withdrawn?); remove the file");
        } else if (known->second != own.client) {
            findings.add(file.string() + ": is another key of " + own.name +
                         " than the brokers', who will drop its packets");
        }
    });
}

void check_equal_keys(const fs::path& file, const ClientKeys& keys, Findings& findings) {
    std::map<protection::Key, std::string> owners;
    for (const auto& [name, client] : keys) {
        const auto [other, is_new] = owners.emplace(client.key, name);
        if (!is_new) {
            findings.add(file.string() + ": " + other->second + " and " + name +
                         " have one key; each needs its own");
        }
    }
}

void check_certificate(const fs::path& file, Findings& findings) {
    if (!fs::exists(file)) return;
    findings.look([&] {
        if (const auto flaw = flaw_of(read_private_file(file))) {
            findings.add(file.string() + ": " + *flaw);
        }
    });
}

void check_broker_folder(const fs::path& folder, const ClientKeys* all, Findings& findings) {
    findings.look([&] {
        const ClientKeys keys = read_table(folder / table_name);
        if (all != nullptr && keys != *all) {
            findings.add((folder / table_name).string() +
                         ": has other clients or keys than the fleet; `romano keys new` on the "
                         "fleet's folder writes it anew");
        }
        if (all == nullptr) check_equal_keys(folder / table_name, keys, findings);
    });
    findings.look([&] { (void)read_broker_record(folder / record_name); });
    findings.look([&] { (void)read_given_place(folder / place_name); });
    findings.look([&] {
        for (std::string& problem : problems_of_peer_papers(folder))
            findings.add(std::move(problem));
    });
}

}  // namespace

fs::path KeyFolder::own_file(std::string_view name, Role role) const {
    return folder_ / folder_name(role) / (std::string{name} + ".key");
}

fs::path KeyFolder::broker_folder(std::string_view name) const {
    return folder_ / of_brokers / name;
}

std::vector<std::string> KeyFolder::brokers() const {
    std::vector<std::string> names;
    for (const fs::path& entry : entries_of(folder_ / of_brokers))
        names.push_back(entry.filename());
    return names;
}

ClientKeys KeyFolder::clients() const {
    const fs::path table = folder_ / table_name;
    return fs::exists(table) ? read_table(table) : ClientKeys{};
}

void KeyFolder::add(const Names& names) {
    ClientKeys keys = clients();
    for (const std::string& name : names.robots) add_client(keys, name, Role::robot);
    for (const std::string& name : names.operators) add_client(keys, name, Role::person);
    for (const std::string& name : names.brokers) {
        if (!is_name(name)) {
            throw KeyError("--broker '" + name + "': must be 1 to 20 letters, digits, '-' and '_'");
        }
    }
    for (const char* below : {of_brokers, folder_name(Role::robot), folder_name(Role::person)}) {
        make_private_folder(folder_ / below);
    }
    for (const std::string& name : names.brokers) {
        make_private_folder(broker_folder(name));
        give_place(broker_folder(name));
    }
    const auto write_own = [&](const std::vector<std::string>& list, Role role) {
        for (const std::string& name : list) {
            write_own_key(own_file(name, role), {name, keys.at(name), 0});
        }
    };
    write_own(names.robots, Role::robot);
    write_own(names.operators, Role::person);
    write_tables(keys);
    for (const std::string& name : names.brokers) {
        if (!has_peer_papers(broker_folder(name))) renew(name, broker_days);
    }
}

/// None that was given before; without one a broker does all but DTLS.
void KeyFolder::give_place(const fs::path& broker) const {
    if (read_given_place(broker / place_name)) return;  // not taken yet
    const fs::path given = folder_ / "places.given";
    const std::uint32_t place = read_given_place(given).value_or(0) + 1;
    if (place > most_places) return;
    write_given_place(given, place);
    write_given_place(broker / place_name, place);
}

void KeyFolder::withdraw(const std::vector<std::string>& names,
                         const std::vector<std::string>& brokers) {
    ClientKeys keys = clients();
    for (const std::string& name : names) {
        if (keys.erase(name) == 0) throw KeyError("'" + name + "': has no key here");
    }
    for (const std::string& name : brokers) {
        if (!is_name(name) || !fs::exists(broker_folder(name) / broker_certificate_name)) {
            throw KeyError("--broker '" + name + "': has no certificate here");
        }
    }
    if (!names.empty()) write_tables(keys);
    for (const std::string& name : brokers) {
        const fs::path own = broker_folder(name);
        write_revocations(Authority(folder_), read_private_file(own / broker_certificate_name));
        fs::remove_all(own);
    }
}

void KeyFolder::renew(const std::string& broker, int days) {
    if (!is_name(broker) || !fs::exists(broker_folder(broker))) {
        throw KeyError("'" + broker + "': is no broker of this fleet; say first: romano keys new " +
                       folder_.string() + " --broker " + broker);
    }
    const Authority authority(folder_);
    write_peer_papers(authority, broker, broker_folder(broker), days);
    write_revocations(authority, std::nullopt);
}

/// For the fleet, and for each of its brokers.
void KeyFolder::write_revocations(const Authority& authority,
                                  const std::optional<std::string>& revoked) const {
    const fs::path file = folder_ / revoked_name;
    std::optional<std::string> earlier;
    if (fs::exists(file)) earlier = read_private_file(file);
    const std::string list = authority.revocations(earlier, revoked);
    write_private_file(file, list);
    for (const std::string& name : brokers()) {
        write_private_file(broker_folder(name) / revoked_name, list);
    }
}

fs::path KeyFolder::certify(const std::string& client_id, int days) {
    const auto owns = [&](const auto& owner) {
        const auto ids = client_ids_of(owner.first, owner.second.role);
        return std::ranges::count(ids, client_id) != 0;
    };
    if (std::ranges::none_of(clients(), owns)) {
        throw KeyError("'" + client_id + "': has no key here; say first: romano keys new DIR");
    }
    const fs::path folder = folder_ / "certificates";
    make_private_folder(folder);
    std::string name = client_id;
    std::ranges::replace(name, '/', '-');
    const fs::path file = folder / (name + ".pem");
    write_private_file(file, Authority(folder_).issue(client_id, Holder::client, days));
    return file;
}

void KeyFolder::write_tables(const ClientKeys& keys) const {
    write_table(folder_ / table_name, keys);
    for (const std::string& name : brokers()) write_table(broker_folder(name) / table_name, keys);
}

std::vector<std::string> problems_of(const fs::path& path) {
    Findings findings;
    if (!fs::exists(path)) {
        findings.add(path.string() + ": is not there; `romano keys new` makes it");
    } else if (!fs::is_directory(path)) {
        check_own_file(path, nullptr, findings);
    } else if (!fs::exists(path / of_brokers)) {
        check_broker_folder(path, nullptr, findings);
    } else {
        findings.look([&] {
            const ClientKeys keys = read_table(path / table_name);
            check_equal_keys(path / table_name, keys, findings);
            for (const fs::path& broker : entries_of(path / of_brokers)) {
                check_broker_folder(broker, &keys, findings);
            }
            for (const fs::path& file : entries_of(path / "certificates")) {
                check_certificate(file, findings);
            }
            for (const Role role : {Role::robot, Role::person}) {
                for (const fs::path& file : entries_of(path / folder_name(role))) {
                    if (file.extension() == ".key") check_own_file(file, &keys, findings);
                }
            }
        });
    }
    return findings.take();
}

}  // namespace romano::keys
