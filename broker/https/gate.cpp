#include "broker/https/gate.h"

#include <algorithm>

#include "broker/https/tls.h"

namespace romano::https {

Gate::Gate(const GateFiles& files) : tls_(server_tls(files.certificate)), token_(files.token) {}

bool Gate::begins_handshake(const Address& from, Time now) {
    using std::chrono::seconds;
    const auto is_recent = [now](const Begun& one) {
        return one.at != Time::min() && now - one.at < seconds{1};
    };
    const auto is_half = [](auto count, std::size_t most) {
        return static_cast<std::size_t>(count) >= most / 2;
    };
    const auto of_its_own = std::ranges::count_if(
        begun_, [&](const Begun& one) { return is_recent(one) && one.from == from; });
    if (handshakes_.size() >= most_handshakes || is_recent(begun_[oldest_]) ||
        is_half(std::ranges::count(handshakes_, from), most_handshakes) ||
        is_half(of_its_own, most_in_a_second)) {
        return false;
    }
    begun_[oldest_] = {from, now};
    oldest_ = (oldest_ + 1) % begun_.size();
    handshakes_.push_back(from);
    return true;
}

void Gate::ends_handshake(const Address& from, bool is_agreed) {
    handshakes_.erase(std::ranges::find(handshakes_, from));
    if (!is_agreed) ++counts_.handshakes_failed;
}

bool Gate::lets_in(std::string_view authorization, const Address& from) {
    if (token_.is_shown_in(authorization)) return true;
    if (authorization.empty()) {
        ++counts_.without_token;
        return false;
    }
    ++counts_.wrong_tokens;
    last_wrong_ = from;
    return false;
}

}  // namespace romano::https
