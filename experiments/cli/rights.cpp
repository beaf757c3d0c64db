#include "experiments/cli/rights.h"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "broker/daemon/rights_file.h"
#include "broker/net/clock.h"
#include "broker/rights/rules.h"
#include "experiments/cli/broker_options.h"
#include "experiments/cli/brokers.h"
#include "experiments/cli/denial.h"
#include "experiments/report/summary_table.h"
#include "experiments/robots/socket_client.h"
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
  romano rights set rights --key anna.key -h 192.168.1.5
      at once at all brokers of the cluster, in place of their files, as anna may (an operator)
  romano rights reset --key anna.key -h 192.168.1.5
      each broker obeys its own file again
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
            "\nthe brokers disagree: say `romano rights set FILE`; or copy one file to all, and "
            "send "
            "each SIGHUP. `romano rights check FILE` tells a file's digits");
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

/// The file's text, when nothing is wrong with it.
std::string rights_text(const std::string& file) {
    const auto rules = daemon::read_rights_file(file);
    if (!rules) throw CommandError(file + ": " + rules.error());
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// An empty text takes back what was set.
class RightsSetter {
public:
    RightsSetter(const BrokerOptions& options, std::string text)
        : options_(options),
          text_(std::move(text)),
          client_id_(options.id_or("romano-rights")),
          client_(
              io_, resolve_broker(io_, options.host, options.port), options.timing(),
              static_cast<std::uint64_t>(::getpid()),
              [this](const client::Event& event) { on_event(event); }, options.packets()) {}

    void run() {
        client_.connect({.client_id = client_id_,
                         .clean_session = true,
                         .keep_alive = std::chrono::seconds{options_.keep_alive_s}});
        wait_for([this] { return client_.core().is_connected(); });
        const auto begun =
            client_.publish(client::topic_name(rights::rights_topic), as_octets(text_),
                            {.qos = mqttsn::Qos::at_least_once, .retain = true});
        if (!begun) throw CommandError("the file is too long for one message");
        wait_for([this] { return is_set_; });
        client_.disconnect();
        wait_for([this] { return is_gone_; });
    }

private:
    void on_event(const client::Event& event) {
        if (std::holds_alternative<client::Published>(event)) {
            is_set_ = true;
        } else if (std::holds_alternative<client::Failed>(event)) {
            error_ = "the broker at " + options_.where() +
                     " refused it: the owner of the key must be an operator whom a rule lets "
                     "(topic write " +
                     std::string{rights::rights_topic} + "), before and afterwards";
        } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
            error_ = "the broker at " + options_.where() +
                     " refused the connection: " + words_for(refused->return_code);
        } else if (std::holds_alternative<client::Congested>(event)) {
            error_ = "the broker at " + options_.where() + " is full";
        } else if (std::holds_alternative<client::Lost>(event)) {
            error_ = options_.unreachable(client_.was_refused());
        } else if (std::holds_alternative<client::Disconnected>(event)) {
            is_gone_ = true;
        }
    }

    template <typename Done>
    void wait_for(const Done& done) {
        while (!done()) {
            io_.run_one_for(std::chrono::milliseconds{20});
            if (!error_.empty()) throw CommandError(error_);
        }
    }

    const BrokerOptions& options_;
    std::string text_;
    std::string client_id_;
    boost::asio::io_context io_{1};
    bool is_set_ = false;
    bool is_gone_ = false;
    std::string error_;
    SocketClient client_;
};

/// Until all brokers obey, or ten seconds are over.
void wait_for_all(const BrokerOptions& options, const std::string& digest) {
    const Instant end = net::now() + std::chrono::seconds{10};
    bool obey_all = false;
    while (!obey_all && net::now() < end) {
        see_brokers(options, [&](const BrokerWatch& watch) {
            obey_all = std::ranges::all_of(watch.brokers(), [&](const auto& each) {
                return !each.second.status.alive || each.second.status.rights == digest;
            });
        });
    }
    see_brokers(options, show_rights);
    if (!obey_all) {
        throw CommandError("not all brokers obey rights " + digest +
                           " yet; `romano rights show` tells when they do");
    }
}

void add_rights_set(CLI::App& rights, int& exit_code) {
    auto options = std::make_shared<BrokerOptions>();
    auto file = std::make_shared<std::string>();
    CLI::App& command =
        *rights.add_subcommand("set", "Let all brokers obey these rights, as an operator");
    options->add_to(command);
    options->add_key_to(command);
    command.add_option("FILE", *file, "As given to romano-broker --rights")->required();
    command.callback([options, file, &exit_code] {
        if (options->key_file.empty()) throw CommandError("--key is needed: that of an operator");
        const std::string text = rights_text(*file);
        RightsSetter(*options, text).run();
        wait_for_all(*options, rights::digest_of(*rights::parse(text)));
        exit_code = 0;
    });
}

void add_rights_reset(CLI::App& rights, int& exit_code) {
    auto options = std::make_shared<BrokerOptions>();
    CLI::App& command = *rights.add_subcommand(
        "reset", "Let each broker obey its own file again, or the usual rights");
    options->add_to(command);
    options->add_key_to(command);
    command.callback([options, &exit_code] {
        if (options->key_file.empty()) throw CommandError("--key is needed: that of an operator");
        RightsSetter(*options, {}).run();
        std::puts("each broker obeys its own file again, within a second");
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
        "rights", "Who may publish and read what: check files, see brokers, set them for all");
    command.require_subcommand(1);
    command.footer(rights_examples);
    add_rights_check(command, exit_code);
    add_rights_show(command, exit_code);
    add_rights_set(command, exit_code);
    add_rights_reset(command, exit_code);
    add_usual_rights(command, exit_code);
}

}  // namespace romano::experiments
