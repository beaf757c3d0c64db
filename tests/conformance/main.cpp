// The suite as a program: against romano-broker processes of its own, or any broker at an address.

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "broker/net/endpoint_text.h"
#include "tests/conformance/broker.h"

int main(int argc, char** argv) {
    using namespace romano;
    testing::InitGoogleTest(&argc, argv);
    conformance::Agreement& agreed = conformance::agreement();
    CLI::App app{
        "MQTT-SN 1.2 conformance: a case a rule of the specification, over IPv4 and IPv6.\n"
        "Options of GoogleTest (--gtest_filter, --gtest_list_tests, --gtest_output) work too."};
    std::string address;
    int quiet_ms = 200;
    app.add_option("--broker", address,
                   "A broker that runs already (without it: romano-broker processes of this run); "
                   "cases that need other settings or the other family are skipped")
        ->type_name("ADDR:PORT")
        ->envname("MQTTSN_BROKER");
    app.add_option("--predefined-id", agreed.predefined_id, "A predefined topic id of the broker")
        ->type_name("ID")
        ->capture_default_str();
    app.add_option("--predefined-topic", agreed.predefined_topic, "The topic it stands for")
        ->type_name("TOPIC")
        ->capture_default_str();
    app.add_option("--quiet-ms", quiet_ms,
                   "With --broker: how long nothing must come until that is believed")
        ->type_name("MS")
        ->capture_default_str();
    app.footer(
        "Examples:\n"
        "  conformance_test\n"
        "  conformance_test --broker 127.0.0.1:1883 --predefined-id 1 --predefined-topic a/b\n"
        "  conformance_test --gtest_filter='*S6_9*/Ipv4'\n\n"
        "Exit code: 0 when all cases pass, 1 when one fails, 2 when a setting is not possible.");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& done) {
        return app.exit(done);
    } catch (const CLI::ParseError& error) {
        app.exit(error);
        return 2;
    }
    if (!address.empty()) {
        agreed.address = net::parse_endpoint(address);
        agreed.quiet = std::chrono::milliseconds{quiet_ms};
        if (!agreed.address) {
            std::cerr << "conformance_test: --broker " << address
                      << " is not possible: an address and a port, like 127.0.0.1:1883 or "
                         "[::1]:1883\n";
            return 2;
        }
    }
    return RUN_ALL_TESTS();
}
