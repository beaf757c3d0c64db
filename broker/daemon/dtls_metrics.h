// What the DTLS addresses of a broker counted.
#pragma once

#include "broker/dtls/openssl/listener.h"
#include "broker/metrics/page.h"

namespace romano::daemon {

void add_dtls(metrics::Page& page, const dtls::Listener& listener);

}  // namespace romano::daemon
