#include "broker/daemon/http_settings.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "broker/daemon/address_setting.h"
#include "broker/daemon/refusal.h"
#include "broker/net/socket_address.h"
#include "romano/keys/key_error.h"

namespace romano::daemon {
namespace {

namespace fs = std::filesystem;

/// What `romano keys new` puts into a broker's folder, beside its clients' keys.
constexpr const char* certificate_of_the_keys = "broker.pem";

Endpoint check_http(std::string_view option, const std::string& text) {
    const Endpoint endpoint = address_and_port(option, text);
    if (net::is_multicast(endpoint)) {
        refuse_option(option, text, "is a multicast group; HTTP needs an address of this machine");
    }
    return endpoint;
}

/// HTTPS is served to those who show the token; without one there is no gate.
std::optional<https::GateFiles> check_gate(const SettingTexts& texts, std::string_view option,
                                           const std::optional<std::string>& token) {
    if (!token) return std::nullopt;
    if (texts.http_certificate) return https::GateFiles{*texts.http_certificate, *token};
    std::error_code unknown;
    if (texts.keys && fs::exists(fs::path{*texts.keys} / certificate_of_the_keys, unknown)) {
        return https::GateFiles{fs::path{*texts.keys} / certificate_of_the_keys, *token};
    }
    refuse_option(option, *token,
                  "needs a certificate too; give --http-certificate FILE, or --keys DIR with a "
                  "broker.pem");
}

}  // namespace

std::optional<MetricsSettings> check_metrics(const SettingTexts& texts) {
    if (texts.http_certificate && !texts.metrics_token && !texts.web_token) {
        refuse_option("http-certificate", *texts.http_certificate,
                      "is for those who show a token; give --metrics-token or --web-token too");
    }
    if (!texts.metrics) {
        if (texts.metrics_token) {
            refuse_option("metrics-token", *texts.metrics_token,
                          "is for the metrics; give --metrics ADDR:PORT too");
        }
        return std::nullopt;
    }
    MetricsSettings out{.listen = check_http("metrics", *texts.metrics),
                        .gate = check_gate(texts, "metrics-token", texts.metrics_token)};
    if (!out.gate && !net::is_loopback(out.listen) && !texts.allow_plain) {
        refuse_option("metrics", *texts.metrics,
                      "is reached by other machines, and whoever reaches it reads which brokers "
                      "there are and how much is said; give --metrics-token FILE, or --allow-plain "
                      "if everybody may, or an address of this machine alone such as "
                      "127.0.0.1:9883");
    }
    return out;
}

std::optional<WebSettings> check_web(const SettingTexts& texts,
                                     const std::vector<Endpoint>& listen) {
    if (!texts.web) {
        if (texts.web_key) {
            refuse_option("web-key", *texts.web_key, "is for the page; give --web ADDR:PORT too");
        }
        if (texts.web_token) {
            refuse_option("web-token", *texts.web_token,
                          "is for the page; give --web ADDR:PORT too");
        }
        if (texts.let_everybody_steer) {
            throw Refusal("--let-everybody-steer is for the page; give --web ADDR:PORT too");
        }
        return std::nullopt;
    }
    WebSettings out{.listen = check_http("web", *texts.web),
                    .key_file = texts.web_key,
                    .gate = check_gate(texts, "web-token", texts.web_token)};
    if (out.gate && texts.let_everybody_steer) {
        refuse_option("web-token", *texts.web_token,
                      "and --let-everybody-steer exclude each other; choose one");
    }
    if (!out.gate && !net::is_loopback(out.listen) && !texts.let_everybody_steer) {
        refuse_option("web", *texts.web,
                      "is reached by other machines, and whoever reaches the page can steer all "
                      "robots; give --web-token FILE, or choose an address of this machine alone "
                      "such as 127.0.0.1:8080, or give --let-everybody-steer");
    }
    const auto serves = [&listen](Endpoint::Packets packets) {
        return std::ranges::find(listen, packets, &Endpoint::packets) != listen.end();
    };
    if (out.key_file && !serves(Endpoint::Packets::sealed)) {
        refuse_option("web-key", *out.key_file,
                      "is for a broker with protected clients; give --listen "
                      "protected://ADDR:PORT too, or leave it out");
    }
    if (!out.key_file && !serves(Endpoint::Packets::plain)) {
        refuse_option("web", *texts.web,
                      "needs --web-key FILE, a key that `romano keys new --operator` makes: all "
                      "addresses of this broker are for clients with keys");
    }
    return out;
}

std::shared_ptr<https::Gate> open_gate(std::string_view token_option,
                                       const std::optional<https::GateFiles>& files) {
    if (!files) return nullptr;
    try {
        return std::make_shared<https::Gate>(*files);
    } catch (const keys::KeyError& error) {
        refuse_option(token_option, files->token.string(), error.what());
    }
}

}  // namespace romano::daemon
