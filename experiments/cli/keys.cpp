#include "experiments/cli/keys.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "romano/keys/key_error.h"
#include "romano/keys/key_folder.h"
#include "romano/keys/peer_papers.h"
#include "romano/protection/keys.h"

namespace romano::experiments {
namespace {

constexpr const char* keys_examples = R"(Examples:
  romano keys new fleet --broker b1 --broker b2 --robot abcd1234 --operator anna
      makes the folder fleet with a key for each, and says what goes where
  romano keys new fleet --robot 00000007
      one more robot: its own file, and a new table for all brokers
  romano keys withdraw fleet abcd1234
      its packets are refused as soon as brokers have the new table
  romano keys withdraw fleet --broker b2
      a stolen broker: peers refuse it as soon as they have the new revoked.pem and were restarted
  romano keys renew fleet b1 --days 730
      another certificate, by which other brokers know b1, before the first one expires
  romano keys psk fleet/robots/abcd1234.key
      identity and pre-shared key for a standard client of DTLS 1.2:
      read id psk < <(romano keys psk abcd1234.key)
      openssl s_client -dtls1_2 -quiet -psk_identity $id -psk $psk -connect ADDR:PORT
  romano keys certificate fleet anna
      a certificate for a standard client of DTLS 1.2 (ECDSA):
      openssl s_client -dtls1_2 -quiet -CAfile authority.pem -cert anna.pem -key anna.pem -connect ADDR:PORT
  romano keys check fleet        (or a broker's folder, or one key file)
      says in a sentence what is wrong; exit code 1 if something is
)";

struct NewKeys {
    std::string folder;
    keys::Names names;
};

void say_what_goes_where(const NewKeys& made) {
    const keys::KeyFolder folder(made.folder);
    const keys::ClientKeys all = folder.clients();
    for (const std::string& name : made.names.robots) {
        const auto file = folder.own_file(name, keys::Role::robot);
        std::printf(
            "robot %s: move %s to it; there: romano-robot --key %s.key --broker ADDR:PORT\n",
            name.c_str(), file.c_str(), name.c_str());
        std::printf("    its key in digits, for a robot without files: %s\n",
                    keys::hex(all.at(name).key).c_str());
    }
    for (const std::string& name : made.names.operators) {
        const auto file = folder.own_file(name, keys::Role::person);
        std::printf("operator %s: move %s there; then: romano sub --key %s.key -h ADDR -t TOPIC\n",
                    name.c_str(), file.c_str(), name.c_str());
    }
    for (const std::string& name : made.names.brokers) {
        std::printf(
            "broker %s: move the folder %s there; then: romano-broker --name %s --keys FOLDER "
            "--listen protected://ADDR:PORT\n",
            name.c_str(), folder.broker_folder(name).c_str(), name.c_str());
    }
    const bool has_older_brokers = folder.brokers().size() > made.names.brokers.size();
    if (has_older_brokers && made.names.robots.size() + made.names.operators.size() > 0) {
        std::puts(
            "brokers that have their folder already: copy their new clients.keys over the old one; "
            "they read it within two seconds");
    }
}

void add_new(CLI::App& keys, int& exit_code) {
    auto made = std::make_shared<NewKeys>();
    CLI::App& command = *keys.add_subcommand("new", "Make keys, or more of them");
    command.add_option("DIR", made->folder, "The fleet's folder; made when it is missing")
        ->required();
    command.add_option("--broker", made->names.brokers, "A broker's name (repeatable)")
        ->type_name("NAME");
    command.add_option("--robot", made->names.robots, "A robot's client id (repeatable)")
        ->type_name("ID");
    command.add_option("--operator", made->names.operators, "A person (repeatable)")
        ->type_name("NAME");
    command.callback([made, &exit_code] {
        keys::KeyFolder(made->folder).add(made->names);
        say_what_goes_where(*made);
        exit_code = 0;
    });
}

void add_withdraw(CLI::App& keys, int& exit_code) {
    auto folder = std::make_shared<std::string>();
    auto withdrawn = std::make_shared<keys::Names>();
    auto& clients = withdrawn->robots;
    CLI::App& command = *keys.add_subcommand(
        "withdraw", "Take clients from the brokers' tables; revoke brokers' certificates");
    command.add_option("DIR", *folder, "The fleet's folder")->required();
    command.add_option("NAME", clients, "Robots and operators");
    command.add_option("--broker", withdrawn->brokers, "A broker (repeatable)")->type_name("NAME");
    command.callback([folder, withdrawn, &exit_code] {
        const keys::Names& names = *withdrawn;
        if (names.robots.empty() && names.brokers.empty()) {
            throw keys::KeyError("give the NAME of a robot or an operator, or --broker NAME");
        }
        keys::KeyFolder(*folder).withdraw(names.robots, names.brokers);
        if (!names.robots.empty()) {
            std::puts("copy the new clients.keys to all brokers; they read it within two seconds");
        }
        if (!names.brokers.empty()) {
            std::printf(
                "copy the new %s to all other brokers, and restart one after the other; who has "
                "%s knows the clients' keys: withdraw them too, and make new ones\n",
                keys::revoked_name, names.brokers.front().c_str());
        }
        exit_code = 0;
    });
}

void add_renew(CLI::App& keys, int& exit_code) {
    auto folder = std::make_shared<std::string>();
    auto brokers = std::make_shared<std::vector<std::string>>();
    auto days = std::make_shared<int>(keys::broker_days);
    CLI::App& command =
        *keys.add_subcommand("renew", "Make another certificate and permissions for brokers");
    command.add_option("DIR", *folder, "The fleet's folder")->required();
    command.add_option("NAME", *brokers, "Brokers")->required();
    command.add_option("--days", *days, "So long they are valid")
        ->check(CLI::Range(1, 7300))
        ->capture_default_str();
    command.callback([folder, brokers, days, &exit_code] {
        keys::KeyFolder fleet(*folder);
        for (const std::string& name : *brokers) {
            fleet.renew(name, *days);
            std::printf("broker %s: copy %s, %s and %s of %s over the old ones, and restart it\n",
                        name.c_str(), keys::broker_certificate_name, keys::permissions_name,
                        keys::revoked_name, fleet.broker_folder(name).c_str());
        }
        exit_code = 0;
    });
}

void add_psk(CLI::App& keys, int& exit_code) {
    auto file = std::make_shared<std::string>();
    auto client_id = std::make_shared<std::string>();
    CLI::App& command = *keys.add_subcommand(
        "psk", "Print a client's identity and pre-shared key for DTLS, in hexadecimal digits");
    command.add_option("FILE", *file, "A robot's or a person's key file")->required();
    command
        .add_option("--client-id", *client_id,
                    "Which of a person's clients: NAME/1 to NAME/15 (default: NAME)")
        ->type_name("ID");
    command.callback([file, client_id, &exit_code] {
        const keys::OwnKey own = keys::read_own_key(*file);
        const std::string id = client_id->empty() ? own.name : *client_id;
        const auto ids = keys::client_ids_of(own.name, own.client.role);
        if (std::ranges::find(ids, id) == ids.end()) {
            throw keys::KeyError("--client-id '" + id + "': is not of the key " + *file +
                                 ", which is of " +
                                 (ids.size() == 1 ? ids[0] : ids.front() + " to " + ids.back()));
        }
        const auto key = protection::pre_shared_key(keys::key_of(own.client, id));
        std::printf("%s %s\n", id.c_str(), keys::hex(key).c_str());
        exit_code = 0;
    });
}

void add_certificate(CLI::App& keys, int& exit_code) {
    auto folder = std::make_shared<std::string>();
    auto client_id = std::make_shared<std::string>();
    auto days = std::make_shared<int>(730);
    CLI::App& command = *keys.add_subcommand("certificate", "Make a client's certificate for DTLS");
    command.add_option("DIR", *folder, "The fleet's folder")->required();
    command
        .add_option("ID", *client_id, "The client: a robot, an operator NAME, or NAME/1 to NAME/15")
        ->required();
    command.add_option("--days", *days, "So long they are valid")
        ->check(CLI::Range(1, 7300))
        ->capture_default_str();
    command.callback([folder, client_id, days, &exit_code] {
        keys::KeyFolder fleet(*folder);
        const auto file = fleet.certify(*client_id, *days);
        const auto authority = std::filesystem::path(*folder) / keys::authority_name;
        std::printf(
            "client %s: move %s to it, and copy %s there, by which it knows the brokers\n"
            "keep %s where nobody else can read it: it makes more of them\n",
            client_id->c_str(), file.c_str(), authority.c_str(),
            (std::filesystem::path(*folder) / keys::authority_key_name).c_str());
        exit_code = 0;
    });
}

void add_check(CLI::App& keys, int& exit_code) {
    auto path = std::make_shared<std::string>();
    CLI::App& command = *keys.add_subcommand("check", "Say what is wrong with keys");
    command.add_option("PATH", *path, "A fleet's folder, a broker's, or a key file")->required();
    command.callback([path, &exit_code] {
        const auto problems = keys::problems_of(*path);
        for (const std::string& problem : problems) std::puts(problem.c_str());
        if (problems.empty()) std::printf("%s: nothing is wrong\n", path->c_str());
        exit_code = problems.empty() ? 0 : 1;
    });
}

}  // namespace

void add_keys(CLI::App& program, int& exit_code) {
    CLI::App& command =
        *program.add_subcommand("keys", "Make and check the keys of clients and brokers");
    command.require_subcommand(1);
    command.footer(keys_examples);
    add_new(command, exit_code);
    add_withdraw(command, exit_code);
    add_renew(command, exit_code);
    add_psk(command, exit_code);
    add_certificate(command, exit_code);
    add_check(command, exit_code);
}

}  // namespace romano::experiments
