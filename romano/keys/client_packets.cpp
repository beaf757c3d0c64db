#include "romano/keys/client_packets.h"

#include <algorithm>
#include <utility>

#include "romano/keys/key_error.h"

namespace romano::keys {
namespace {

// Places of the lock file: each session has its own, and whoever writes the key file one more.
constexpr unsigned writing = sessions_of_a_person;

/// None is made beside what is no key file.
std::filesystem::path lock_of(const std::filesystem::path& key_file) {
    (void)read_own_key(key_file);
    return key_file.string() + ".lock";
}

}  // namespace

ClientPackets::ClientPackets(const std::filesystem::path& key_file, const std::string& client_id,
                             Speech speech)
    : file_(key_file),
      speech_(speech),
      lock_(lock_of(key_file)),
      own_(read_own()),
      client_id_(take_session(client_id)),
      keys_(protection::direction_keys(key_of(own_.client, client_id_))),
      end_(keys_, client_id_, own_.bound) {
    if (speech_ == Speech::packets) store_bound();
}

protection::Key ClientPackets::pre_shared_key() const {
    return protection::pre_shared_key(key_of(own_.client, client_id_));
}

/// As it is now; other programs of this person may have written it.
OwnKey ClientPackets::read_own() {
    lock_.take(writing);
    OwnKey own = read_own_key(file_);
    lock_.give_back(writing);
    return own;
}

std::string ClientPackets::take_session(const std::string& wanted) {
    const auto ids = client_ids_of(own_.name, own_.client.role);
    if (!wanted.empty() && std::ranges::count(ids, wanted) == 0) {
        throw KeyError("the client id '" + wanted + "' is not of the key " + file_.string() +
                       ", which is of " +
                       (ids.size() == 1 ? ids[0] : ids.front() + " to " + ids.back()));
    }
    for (unsigned place = 0; place < ids.size(); ++place) {
        if ((wanted.empty() || wanted == ids[place]) && lock_.try_take(place)) {
            own_ = read_own();  // whoever had this place may just have gone
            return ids[place];
        }
    }
    throw KeyError("the key " + file_.string() + " is in use by " +
                   (ids.size() == 1 || !wanted.empty()
                        ? std::string{"another program"}
                        : std::to_string(ids.size()) + " other programs"));
}

Bytes ClientPackets::seal(Bytes message) {
    if (skipped_.is_due(message)) end_.skip_block();
    store_bound();
    packet_.resize(message.size() + protection::most_overhead);
    return Bytes{packet_}.first(end_.seal(message, packet_));
}

Bytes ClientPackets::open(MutableBytes packet) {
    const Bytes message = end_.open(packet);
    if (!message.empty()) skipped_.on_heard();
    return message;
}

void ClientPackets::store_bound() {
    const auto wanted = end_.reserve().to_store();
    if (!wanted) return;
    lock_.take(writing);
    own_.bound = std::max(*wanted, read_own_key(file_).bound);
    write_own_key(file_, own_);
    lock_.give_back(writing);
    end_.reserve().on_stored(*wanted);
}

}  // namespace romano::keys
