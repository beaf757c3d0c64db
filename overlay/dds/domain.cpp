#include "overlay/dds/domain.h"

#include <dds/ddsrt/log.h>
#include <spdlog/spdlog.h>

#include <string_view>

namespace romano::dds {
namespace {

// Cyclone tells of every packet that a cut link refuses; that is no news to the people who read
// the trace at its usual level.
void trace_line(void*, const dds_log_data_t* data) {
    std::string_view line(data->message, data->size);
    while (!line.empty() && line.back() == '\n') line.remove_suffix(1);
    spdlog::debug("dds: {}", line);
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
           "</Internal>"
           "</Domain></CycloneDDS>";
}

Domain::Domain(const DomainOptions& options) : Domain(options.id, configuration_of(options)) {}

Domain::Domain(std::uint32_t id, const std::string& configuration) : id_(id) {
    dds_set_log_sink(trace_line, nullptr);
    dds_set_trace_sink(trace_line, nullptr);
    domain_ =
        Entity(dds_create_domain(id, configuration.c_str()), "DDS domain " + std::to_string(id));
}

Entity Domain::make_participant() const {
    return {dds_create_participant(id_, nullptr, nullptr),
            "participant in DDS domain " + std::to_string(id_)};
}

}  // namespace romano::dds
