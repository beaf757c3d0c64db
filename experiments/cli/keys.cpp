#include "experiments/cli/keys.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "romano/keys/key_folder.h"

namespace romano::experiments {
namespace {

constexpr const char* keys_examples = R"(Examples:
  romano keys new fleet --broker b1 --broker b2 --robot abcd1234 --operator anna
      makes the folder fleet with a key for each, and says what goes where
  romano keys new fleet --robot 00000007
      one more robot: its own file, and a new table for all brokers
  romano keys withdraw fleet abcd1234
      its packets are refused as soon as brokers have the new table
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
            "they read it within a second");
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
    auto names = std::make_shared<std::vector<std::string>>();
    CLI::App& command = *keys.add_subcommand("withdraw", "Take clients from the brokers' tables");
    command.add_option("DIR", *folder, "The fleet's folder")->required();
    command.add_option("NAME", *names, "Robots and operators")->required();
    command.callback([folder, names, &exit_code] {
        keys::KeyFolder(*folder).withdraw(*names);
        std::puts("copy the new clients.keys to all brokers; they read it within a second");
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
        *program.add_subcommand("keys", "Make and check the keys of protected packets");
    command.require_subcommand(1);
    command.footer(keys_examples);
    add_new(command, exit_code);
    add_withdraw(command, exit_code);
    add_check(command, exit_code);
}

}  // namespace romano::experiments
