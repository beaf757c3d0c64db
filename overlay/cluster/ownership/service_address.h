// What a cluster asks of the machine it runs on: service addresses to serve or to give up, and
// lines for its trace.
#pragma once

#include <string>
#include <variant>

#include "romano/base/endpoint.h"

namespace romano::cluster {

/// Serve this address from now on, before all others who do, and say whether that worked. Another
/// process on this host may still hold it and let it go only when told: bind it beside that one all
/// the same, and anew when it is bound here already.
struct TakeAddress {
    Endpoint address;
};
/// Stop serving this address.
struct GiveUpAddress {
    Endpoint address;
};
/// Tell the neighbours once more that this served address is here: another machine had it, too.
struct AnnounceAddress {
    Endpoint address;
};
/// A line for the trace: something that people want to know.
struct Notice {
    std::string text;
    bool is_warning = false;
};

using LocalAction = std::variant<TakeAddress, GiveUpAddress, AnnounceAddress, Notice>;

}  // namespace romano::cluster
