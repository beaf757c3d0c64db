#include "overlay/dds/domain.h"

#include <dds/ddsrt/log.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

namespace romano::dds {
namespace {

/// What Cyclone takes for an error: the last one says why a participant cannot be made.
class Errors {
public:
    void add(std::string_view line) {
        const std::scoped_lock lock(mutex_);
        last_ = line.substr(0, line.find_first_of("\r\n"));
    }
    std::string take_last() {
        const std::scoped_lock lock(mutex_);
        return std::exchange(last_, {});
    }
    /// DDS refuses the same stranger each second.
    bool may_tell_of_refusal(std::chrono::steady_clock::time_point now) {
        const std::scoped_lock lock(mutex_);
        if (told_at_ && now < *told_at_ + std::chrono::minutes{1}) return false;
        told_at_ = now;
        return true;
    }

private:
    std::mutex mutex_;
    std::string last_;
    std::optional<std::chrono::steady_clock::time_point> told_at_;
};

Errors& errors() {
    static Errors all;
    return all;
}

// Cyclone tells of every packet that a cut link refuses; that is no news to the people who read
// the trace at its usual level. That somebody cannot prove itself is.
void trace_line(void*, const dds_log_data_t* data) {
    std::string_view line(data->message, data->size);
    while (!line.empty() && line.back() == '\n') line.remove_suffix(1);
    if ((data->priority & DDS_LC_ERROR) != 0) errors().add(line);
    const bool is_refusal = line.find("Certificate not valid") != std::string_view::npos;
    if (is_refusal && errors().may_tell_of_refusal(std::chrono::steady_clock::now())) {
        spdlog::warn(
            "a process in this DDS domain does not prove that it is a broker of this "
            "fleet, and is not heard (said once a minute at most): {}",
            line);
    } else {
        spdlog::debug("dds: {}", line);
    }
}

std::string escaped(const std::string& text) {
    std::string out;
    for (const char letter : text) {
        switch (letter) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            default:
                out += letter;
        }
    }
    return out;
}

/// The three built-in plugins of DDS Security.
std::string security_of(const std::optional<Papers>& papers) {
    if (!papers) return {};
    const auto file = [](const std::string& element, const std::string& path) {
        return "<" + element + ">file:" + escaped(std::filesystem::absolute(path).string()) + "</" +
               element + ">";
    };
    const auto library = [](const std::string& name, const std::string& kind) {
        return "<Library path=\"dds_security_" + name + "\" initFunction=\"init_" + kind +
               "\" finalizeFunction=\"finalize_" + kind + "\"/>";
    };
    return "<Security><Authentication>" + library("auth", "authentication") +
           file("IdentityCA", papers->authority) + file("IdentityCertificate", papers->own) +
           file("PrivateKey", papers->own) + file("CRL", papers->revoked) +
           "</Authentication><AccessControl>" + library("ac", "access_control") +
           file("PermissionsCA", papers->authority) + file("Governance", papers->governance) +
           file("Permissions", papers->permissions) + "</AccessControl><Cryptographic>" +
           library("crypto", "crypto") + "</Cryptographic></Security>";
}

}  // namespace

std::string configuration_of(const DomainOptions& options) {
    std::string interfaces;
    if (!options.interface.empty()) {
        // The loopback interface multicasts, but does not say so.
        const std::string_view multicast = options.interface == "lo" ? "true" : "default";
        interfaces = "<Interfaces><NetworkInterface name=\"" + options.interface +
                     "\" multicast=\"" + std::string(multicast) + "\"/></Interfaces>";
    }
    // Reliable samples are repaired within a millisecond; a participant that is silent for a second
    // no longer holds anything back. Its broker has been taken over long before. A writer goes at
    // once, though a dead reader has not acknowledged all: the broker would stand still meanwhile.
    return "<CycloneDDS><Domain id=\"any\">"
           "<General>" +
           interfaces + "<Transport>" + (options.over_ipv6 ? "udp6" : "udp") +
           "</Transport>"
           "<AllowMulticast>true</AllowMulticast></General>"
           "<Discovery><SPDPInterval>100ms</SPDPInterval><LeaseDuration>1s</LeaseDuration></"
           "Discovery>"
           "<Internal>"
           "<PreEmptiveAckDelay>1ms</PreEmptiveAckDelay><NackDelay>1ms</NackDelay>"
           "<AckDelay>1ms</AckDelay><WriterLingerDuration>0s</WriterLingerDuration>"
           "<HeartbeatInterval min=\"1ms\" minsched=\"5ms\" max=\"200ms\">20ms</HeartbeatInterval>"
           "<Watermarks><WhcLow>100kB</WhcLow><WhcHighInit>4MB</WhcHighInit><WhcHigh>4MB</WhcHigh>"
           "<WhcAdaptive>false</WhcAdaptive></Watermarks>"
           "</Internal>" +
           security_of(options.papers) + "</Domain></CycloneDDS>";
}

Domain::Domain(const DomainOptions& options) : Domain(options.id, configuration_of(options)) {}

Domain::Domain(std::uint32_t id, const std::string& configuration) : id_(id) {
    dds_set_log_sink(trace_line, nullptr);
    dds_set_trace_sink(trace_line, nullptr);
    domain_ =
        Entity(dds_create_domain(id, configuration.c_str()), "DDS domain " + std::to_string(id));
}

Entity Domain::make_participant() const {
    (void)errors().take_last();
    try {
        return {dds_create_participant(id_, nullptr, nullptr),
                "participant in DDS domain " + std::to_string(id_)};
    } catch (const DdsError& error) {
        const std::string why = errors().take_last();
        throw DdsError(why.empty() ? error.what() : why);
    }
}

}  // namespace romano::dds
