#include "experiments/cli/rights.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "broker/daemon/rights_file.h"
#include "broker/rights/rules.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/brokers.h"
#include "experiments/report/summary_table.h"
#include "experiments/watch/broker_watch.h"
#include "romano/keys/client_keys.h"
#include "romano/keys/key_folder.h"

namespace romano::experiments {
namespace {

constexpr const char* rights_examples = R"(Examples:
  romano rights usual > rights
      the rules that hold where no file is given, to begin with
  romano rights check rights
      which line is wrong, and why; exit code 1 if one is
  romano rights check rights --keys fleet
      and which names in it have no key in the folder fleet
  romano-broker --rights rights ...; kill -HUP PID
      at each broker: it begins with them; it reads them again
  romano rights show --key anna.key -h 192.168.1.5
      which rights each broker uses: the same digits, the same rights
)";

/// All names that rules are about.
std::set<std::string> names_with_rules(const rights::Rules& rules) {
    std::set<std::string> names;
    for (const auto& [name, list] : rules.users) names.insert(name);
    for (const auto& [group, members] : rules.members) names.insert(members.begin(), members.end());
    return names;
}

std::size_t number_of_rules(const rights::Rules& rules) {
    std::size_t number = rules.everybody.size();
    for (const auto& [name, list] : rules.groups) number += list.size();
    for (const auto& [name, list] : rules.users) number += list.size();
    return number;
}

bool say_who_has_no_key(const rights::Rules& rules, const std::filesystem::path& folder) {
    const auto keys = keys::read_table(folder / keys::table_name);
    bool all_have = true;
    for (const std::string& name : names_with_rules(rules)) {
        if (keys.contains(name)) continue;
        all_have = false;
        std::printf("%s has rules, and no key in %s\n", name.c_str(), folder.c_str());
    }
    return all_have;
}

int check_rights(const std::string& file, const std::string& keys_folder) {
    const auto rules = daemon::read_rights_file(file);
    if (!rules) {
        std::printf("%s: %s\n", file.c_str(), rules.error().c_str());
        return 1;
    }
    if (!keys_folder.empty() && !say_who_has_no_key(*rules, keys_folder)) return 1;
    std::printf("%s: nothing is wrong; %zu rules, rights %s\n", file.c_str(),
                number_of_rules(*rules), rights::digest_of(*rules).c_str());
    return 0;
}

void show_rights(const BrokerWatch& watch) {
    const std::string usual = rights::digest_of(*rights::parse(rights::usual_rules()));
    SummaryTable table{.head = {"broker", "rights", ""}, .units = {}, .rows = {}};
    std::set<std::string> different;
    for (const auto& [name, seen] : watch.brokers()) {
        if (!seen.status.alive) continue;
        const std::string& rights = seen.status.rights;
        if (!rights.empty()) different.insert(rights);
        table.rows.push_back({name, rights.empty() ? "not known yet" : rights,
                              rights == usual ? "the usual ones" : ""});
    }
    std::fputs(to_text(table).c_str(), stdout);
    if (different.size() > 1) {
        std::puts(
            "\nthe brokers disagree: copy one file to all, and send each SIGHUP; `romano rights "
            "check FILE` tells a file's digits");
    }
}

void add_rights_check(CLI::App& rights, int& exit_code) {
    auto file = std::make_shared<std::string>();
    auto keys = std::make_shared<std::string>();
    CLI::App& command = *rights.add_subcommand("check", "Say what is wrong with a file of rights");
    command.add_option("FILE", *file, "As given to romano-broker --rights")->required();
    command.add_option("--keys", *keys, "A fleet's or a broker's folder: whose names have no key?")
        ->type_name("DIR");
    command.callback([file, keys, &exit_code] { exit_code = check_rights(*file, *keys); });
}

void add_rights_show(CLI::App& rights, int& exit_code) {
    auto options = std::make_shared<BrokerOptions>();
    CLI::App& command = *rights.add_subcommand("show", "Show which rights each broker uses");
    options->add_to(command);
    options->add_key_to(command);
    command.callback([options, &exit_code] {
        see_brokers(*options, show_rights);
        exit_code = 0;
    });
}

void add_usual_rights(CLI::App& rights, int& exit_code) {
    CLI::App& command =
        *rights.add_subcommand("usual", "Print the rules that hold where no file is given");
    command.callback([&exit_code] {
        const std::string text{rights::usual_rules()};
        std::fputs(text.c_str(), stdout);
        exit_code = 0;
    });
}

}  // namespace

void add_rights(CLI::App& program, int& exit_code) {
    CLI::App& command = *program.add_subcommand(
        "rights", "Who may publish and read what: check files, see brokers");
    command.require_subcommand(1);
    command.footer(rights_examples);
    add_rights_check(command, exit_code);
    add_rights_show(command, exit_code);
    add_usual_rights(command, exit_code);
}

}  // namespace romano::experiments
