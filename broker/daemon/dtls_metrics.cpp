#include "broker/daemon/dtls_metrics.h"

#include <cstddef>
#include <string>

namespace romano::daemon {

void add_dtls(metrics::Page& page, const dtls::Listener& listener) {
    const dtls::Counters& counters = listener.clients().counters();
    page.gauge("romano_dtls_associations", "DTLS associations that are known here.",
               static_cast<double>(listener.clients().size()));
    page.gauge("romano_dtls_handshakes", "DTLS handshakes that have begun and not ended.",
               static_cast<double>(listener.handshakes().size()));
    const auto handshakes = [&page](const char* end, std::uint64_t value) {
        page.counter("romano_dtls_handshakes_total", "DTLS handshakes that ended, by how.", value,
                     {{"end", end}});
    };
    handshakes("agreed", listener.handshakes().agreed());
    handshakes("failed", listener.handshakes().failed());
    const auto records = [&page](const char* direction, std::uint64_t value) {
        page.counter("romano_dtls_records_total", "DTLS records that were taken, or made.", value,
                     {{"direction", direction}});
    };
    records("in", counters.opened);
    records("out", counters.sealed);
    page.counter("romano_dtls_closed_total", "DTLS associations that their clients closed.",
                 counters.closed);
    page.counter("romano_dtls_moved_total",
                 "Times that a client with a Connection ID was heard from another address.",
                 counters.moved);
    for (std::size_t kind = 0; kind < dtls::refusal_names.size(); ++kind) {
        page.counter("romano_dtls_refusals_total",
                     "DTLS records that were not taken, or not made, by reason.",
                     counters.refused.of(static_cast<dtls::Refusal>(kind)),
                     {{"reason", std::string{dtls::refusal_names[kind]}}});
    }
}

}  // namespace romano::daemon
