#include "romano/keys/broker_record.h"

#include <array>
#include <cstdio>
#include <string>

#include "romano/keys/key_error.h"
#include "romano/keys/private_file.h"
#include "romano/keys/random_octets.h"
#include "romano/protection/reserve.h"

namespace romano::keys {

namespace {

BrokerRecord new_record() {
    BrokerRecord record;
    fill_at_random(record.identity);
    return record;
}

}  // namespace

BrokerRecord read_broker_record(const std::filesystem::path& file) {
    if (!std::filesystem::exists(file)) return new_record();
    BrokerRecord record;
    const std::string text = read_private_file(file);
    unsigned long long identity = 0;
    int end = 0;
    const int fields = std::sscanf(text.c_str(), "identity %16llx bound %10u %nplace %3u %n",
                                   &identity, &record.bound, &end, &record.place, &end);
    if (fields < 2 || static_cast<std::size_t>(end) != text.size() || record.place > most_places) {
        throw KeyError(file.string() +
                       ": is damaged; remove it, and the broker takes a new identity");
    }
    if (record.bound >= protection::max_number) return new_record();
    for (std::size_t i = 0; i < record.identity.size(); ++i) {
        record.identity[i] = static_cast<std::uint8_t>(identity >> (56 - 8 * i));
    }
    return record;
}

void write_broker_record(const std::filesystem::path& file, const BrokerRecord& record) {
    unsigned long long identity = 0;
    for (const std::uint8_t octet : record.identity) identity = identity << 8U | octet;
    std::array<char, 64> line{};
    std::snprintf(line.data(), line.size(), "identity %016llx bound %u place %u\n", identity,
                  record.bound, record.place);
    write_private_file(file, line.data());
}

std::optional<std::uint32_t> read_given_place(const std::filesystem::path& file) {
    if (!std::filesystem::exists(file)) return std::nullopt;
    const std::string text = read_private_file(file);
    std::uint32_t place = 0;
    int end = 0;
    if (std::sscanf(text.c_str(), "place %3u %n", &place, &end) != 1 ||
        static_cast<std::size_t>(end) != text.size() || place == 0 || place > most_places) {
        throw KeyError(file.string() +
                       ": is damaged; `romano keys new FLEET --broker NAME` gives another place");
    }
    return place;
}

void write_given_place(const std::filesystem::path& file, std::uint32_t place) {
    write_private_file(file, "place " + std::to_string(place) + '\n');
}

}  // namespace romano::keys
