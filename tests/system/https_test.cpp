// Metrics and page beyond this machine: curl, openssl s_client and a browser, which nobody here
// wrote, and our own clients.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/https_files.h"
#include "tests/system/broker_fixture.h"

namespace romano::system::https_test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

struct BeyondThisMachine : BrokerFixture {
    [[nodiscard]] std::vector<std::string> with_metrics() const {
        return {"--metrics",   addresses.service(1), "--metrics-token",
                files.token(), "--http-certificate", files.certificate()};
    }
    [[nodiscard]] std::string metrics_url() const { return url_of(addresses.service(1)); }
    /// By its name, as whoever reaches it from elsewhere.
    [[nodiscard]] static std::string url_of(const std::string& at) {
        return "https://r1:" + at.substr(at.rfind(':') + 1);
    }
    /// What a program said, stdout and stderr.
    static std::string said_by(const std::string& program,
                               const std::vector<std::string>& arguments) {
        Process run(program, arguments);
        std::string said = run.rest_of_output();
        (void)run.wait_for_exit();
        return said + run.errors();
    }
    [[nodiscard]] std::string curl(const std::string& at, const std::string& path,
                                   std::vector<std::string> more = {}) const {
        const auto colon = at.rfind(':');
        more.insert(more.end(),
                    {"-sS", "-i", "--max-time", "30", "--cacert", files.authority(), "--resolve",
                     "r1:" + at.substr(colon + 1) + ":" + at.substr(0, colon), url_of(at) + path});
        return said_by("/usr/bin/curl", more);
    }
    [[nodiscard]] std::vector<std::string> bearer() const {
        return {"-H", std::string{"Authorization: Bearer "} + tests::HttpsFiles::word};
    }
    [[nodiscard]] std::string openssl(const std::string& at, const std::string& more) const {
        return said_by(
            "/bin/sh",
            {"-c", "printf 'GET /metrics HTTP/1.1\\r\\nHost: r1\\r\\nAuthorization: Bearer " +
                       std::string{tests::HttpsFiles::word} +
                       "\\r\\n\\r\\n' | openssl s_client -ign_eof -verify_return_error "
                       "-verify_hostname r1 -CAfile " +
                       files.authority().string() + " -connect " + at + " " + more + " 2>&1"});
    }
    [[nodiscard]] std::string status(const std::vector<std::string>& more) const {
        std::vector<std::string> arguments{"status", "--every", "0.2"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return said_by(ROMANO_PROGRAM, arguments);
    }
    /// Its address, as it is served.
    std::string start_web(std::vector<std::string> more) {
        const std::string at = addresses.service(1);
        const auto colon = at.rfind(':');
        more.insert(more.begin(), {"web", "-h", at.substr(0, colon), "-p", at.substr(colon + 1),
                                   "--listen", "127.0.0.1:0"});
        web = std::make_unique<Process>(ROMANO_PROGRAM, more);
        const std::string line = web->wait_for("the fleet is shown at ");
        EXPECT_THAT(line, HasSubstr("https://127.0.0.1:")) << web->errors();
        const auto place = line.find("127.0.0.1:");
        return line.substr(place, line.find('/', place) - place);
    }
    [[nodiscard]] std::string start_guarded_web() {
        return start_web({"--certificate", files.certificate(), "--token", files.token()});
    }
    /// Past empty lines, which stand between events.
    static bool comes(Process& events, const std::string& words) {
        const auto end = std::chrono::steady_clock::now() + 30s;
        while (std::chrono::steady_clock::now() < end) {
            if (events.next_line(1s).find(words) != std::string::npos) return true;
        }
        return false;
    }
    static std::string refusal(std::vector<std::string> arguments) {
        Process broker(ROMANO_BROKER, arguments);
        EXPECT_EQ(broker.wait_for_exit(), 2);
        EXPECT_EQ(broker.rest_of_output(), "");
        return broker.errors();
    }

    tests::HttpsFiles files;
    std::unique_ptr<Process> web;
};

TEST_F(BeyondThisMachine, CurlReadsMetricsWithTheTokenAlone) {
    start_broker(1, with_metrics());
    const std::string at = addresses.service(1);
    const std::string page = curl(at, "/metrics", bearer());
    EXPECT_THAT(page, AllOf(HasSubstr("200 OK"), HasSubstr("romano_broker_info{name=\"r1\"")));
    EXPECT_THAT(curl(at, "/metrics"), AllOf(HasSubstr("401 "), Not(HasSubstr("romano_"))));
    EXPECT_THAT(curl(at, "/metrics", {"-u", ":wrong-wrong-wrong"}), HasSubstr("401 "));
    EXPECT_THAT(curl(at, "/metrics", {"-u", std::string{"prometheus:"} + tests::HttpsFiles::word}),
                HasSubstr("200 OK"));
    EXPECT_THAT(curl(at, "/nothing"), HasSubstr("401 ")) << "nor what is not there";
    std::string counted;
    for (const auto end = std::chrono::steady_clock::now() + 30s;
         std::chrono::steady_clock::now() < end &&
         counted.find("{reason=\"no_token\"} 2") == std::string::npos;) {
        counted = curl(at, "/metrics", bearer());  // is made anew each tenth of a second
    }
    EXPECT_THAT(counted,
                AllOf(HasSubstr("romano_metrics_refusals_total{reason=\"no_token\"} 2"),
                      HasSubstr("romano_metrics_refusals_total{reason=\"wrong_token\"} 1")));
    EXPECT_THAT(said_by("/usr/bin/curl", {"-sS", "http://" + at + "/metrics"}),
                HasSubstr("here is https"));
}

TEST_F(BeyondThisMachine, OpensslAgreesOnTls12AndTls13) {
    start_broker(1, with_metrics());
    const std::string at = addresses.service(1);
    EXPECT_THAT(openssl(at, "-tls1_2"), AllOf(HasSubstr("ECDHE-ECDSA-"), HasSubstr("200 OK"),
                                              HasSubstr("romano_sessions")));
    EXPECT_THAT(openssl(at, "-tls1_3"),
                AllOf(HasSubstr("TLS_AES_"), HasSubstr("200 OK"), HasSubstr("romano_sessions")));
    EXPECT_THAT(openssl(at, "-tls1_1 -cipher ALL:@SECLEVEL=0"), Not(HasSubstr("200 OK")));
    EXPECT_THAT(openssl(at, "-tls1_2 -cipher AES128-SHA"), Not(HasSubstr("200 OK")));
}

TEST_F(BeyondThisMachine, StatusSpeaksHttps) {
    start_broker(1, with_metrics());
    const std::string at = "https://" + addresses.service(1);
    const std::string ca = files.authority();
    const std::string token = files.token();
    EXPECT_THAT(status({at, "--ca", ca, "--name", "r1", "--token", token}),
                HasSubstr("broker    r1, version"));
    EXPECT_THAT(status({at, "--ca", ca, "--name", "r1"}),
                HasSubstr("the broker wants its token; give the file with --token"));
    EXPECT_THAT(status({at, "--ca", ca, "--name", "r2", "--token", token}),
                AllOf(HasSubstr("certificate verify failed"), HasSubstr("--name")));
    EXPECT_THAT(status({at, "--name", "r1", "--token", token}),
                HasSubstr("certificate verify failed"));
    EXPECT_THAT(status({addresses.service(1), "--token", token}),
                HasSubstr("are for https://HOST:PORT"));
    EXPECT_THAT(status({at, "--token", ca + "x"}), HasSubstr("cannot be read"));
}

TEST_F(BeyondThisMachine, TheCertificateInTheFolderOfKeysProvesTheBroker) {
    const tests::TemporaryFolder folder;
    const std::filesystem::path fleet = folder / "fleet";
    (void)said_by(ROMANO_PROGRAM, {"keys", "new", fleet, "--broker", "r1", "--robot", "abcd1234"});
    brokers.push_back(std::make_unique<BrokerProcess>(
        std::vector<std::string>{"--listen", "protected://" + addresses.service(1), "--name", "r1",
                                 "--keys", fleet / "brokers/r1", "--metrics", addresses.service(1),
                                 "--metrics-token", files.token()}));
    brokers.back()->wait_until_serving();
    EXPECT_THAT(status({"https://" + addresses.service(1), "--ca", fleet / "authority.pem",
                        "--name", "r1", "--token", files.token()}),
                HasSubstr("broker    r1, version"));
}

TEST_F(BeyondThisMachine, ThePageIsForThoseWithTheToken) {
    start_broker(1);
    const std::string at = start_guarded_web();
    EXPECT_THAT(curl(at, "/"), AllOf(HasSubstr("401 "), HasSubstr("WWW-Authenticate: Basic")));
    EXPECT_THAT(curl(at, "/api/stop", {"-X", "POST", "-H", "Content-Type: application/json"}),
                HasSubstr("401 "));
    const std::string user = std::string{"anna:"} + tests::HttpsFiles::word;
    EXPECT_THAT(curl(at, "/", {"-u", user}), HasSubstr("<title>"));
    EXPECT_THAT(curl(at, "/api/state", bearer()), HasSubstr("\"brokers\""));
    EXPECT_THAT(
        curl(at, "/api/stop", {"-u", user, "-X", "POST", "-H", "Content-Type: application/json"}),
        HasSubstr("202 Accepted"));
    EXPECT_THAT(curl(at, "/api/stop",
                     {"-u", user, "-X", "POST", "-H", "Origin: https://evil.example", "-H",
                      "Content-Type: application/json"}),
                HasSubstr("403 "))
        << "the browser of who has logged in shows other pages, too";
    EXPECT_EQ(web->errors(), "") << "who shows none is no intruder yet";
    EXPECT_THAT(curl(at, "/api/state", {"-u", "anna:a-wrong-one"}), HasSubstr("401 "));
    EXPECT_THAT(web->errors(),
                HasSubstr("refused: 1 wrong tokens so far, the last from 127.0.0.1"));
}

TEST_F(BeyondThisMachine, EventsComeOverHttps) {
    start_broker(1);
    const std::string at = start_guarded_web();
    Process events("/usr/bin/curl",
                   {"-sSN", "--cacert", files.authority(), "-u",
                    std::string{":"} + tests::HttpsFiles::word, "https://" + at + "/api/events"});
    EXPECT_TRUE(comes(events, "event: state")) << events.errors();
    Process robot(ROMANO_ROBOT, {"--id", "abcd1234", "--broker", addresses.service(1)});
    EXPECT_TRUE(comes(events, "abcd1234")) << events.errors();
}

TEST_F(BeyondThisMachine, ABrokerShowsThePageBehindTheGate) {
    const std::string port = "127.0.0.1:" + std::to_string(20'000 + ::getpid() % 10'000);
    BrokerProcess& broker = start_broker(1, {"--web", port, "--web-token", files.token(),
                                             "--http-certificate", files.certificate()});
    for (int tries = 0; tries < 2'000; ++tries) {
        if (broker.errors().find("shown at https://" + port) != std::string::npos) break;
        std::this_thread::sleep_for(10ms);
    }
    EXPECT_THAT(curl(port, "/api/state", bearer()), HasSubstr("\"brokers\""));
    EXPECT_THAT(curl(port, "/api/state"), HasSubstr("401 "));
}

TEST_F(BeyondThisMachine, WhatCannotBeIsRefusedInASentence) {
    const std::string token = files.token();
    const std::string certificate = files.certificate();
    EXPECT_THAT(refusal({"--metrics", "0.0.0.0:0"}),
                AllOf(HasSubstr("--metrics '0.0.0.0:0': is reached by other machines"),
                      HasSubstr("--metrics-token FILE, or --allow-plain")));
    EXPECT_THAT(refusal({"--metrics", "127.0.0.1:0", "--metrics-token", token}),
                HasSubstr("needs a certificate too; give --http-certificate FILE, or --keys"));
    EXPECT_THAT(refusal({"--metrics", "127.0.0.1:0", "--metrics-token", token, "--http-certificate",
                         files.authority()}),
                HasSubstr("chmod 600"));
    EXPECT_THAT(refusal({"--metrics", "127.0.0.1:0", "--metrics-token", token, "--http-certificate",
                         files.write("no.pem", "nonsense")}),
                HasSubstr("has no certificate that can be used"));
    EXPECT_THAT(refusal({"--web", "127.0.0.1:0", "--web-token", certificate, "--http-certificate",
                         certificate}),
                HasSubstr("is no token"));
    const std::string web_refusal =
        said_by(ROMANO_PROGRAM, {"web", "--listen", "0.0.0.0:0", "--token", token});
    EXPECT_THAT(web_refusal, HasSubstr("--token requires --certificate"));
}

#ifdef LOGIN_TEST
TEST_F(BeyondThisMachine, ABrowserAsksForTheTokenAndShowsThePage) {
    start_broker(1);
    const std::string at = start_guarded_web();
    ::setenv("PAGE_TEST_MODULES", PAGE_TEST_MODULES, 1);
    ::setenv("CHROMIUM", CHROMIUM_PROGRAM, 1);
    Process page(NODE_PROGRAM, {LOGIN_TEST, "https://" + at + "/", tests::HttpsFiles::word});
    EXPECT_NE(page.wait_for("without the token nothing is shown", 60s), "") << page.errors();
    EXPECT_NE(page.wait_for("with it the fleet is shown", 60s), "") << page.errors();
    EXPECT_NE(page.wait_for("all are told to stop", 60s), "") << page.errors();
    EXPECT_EQ(page.wait_for_exit(), 0) << page.errors();
}
#endif

}  // namespace
}  // namespace romano::system::https_test
