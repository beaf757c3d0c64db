// A client's end of its protected packets with its key file: for programs, one of these a client.
// For a client that speaks DTLS it keeps the key's place from other programs, and nothing more.
//
// The file's bound is stored before a number below it is used. Several programs may use one
// person's key at a time: each is another client, with another key and numbers of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "romano/base/bytes.h"
#include "romano/keys/client_keys.h"
#include "romano/keys/lock_file.h"
#include "romano/protection/robot_end.h"
#include "romano/protection/skipped_blocks.h"

namespace romano::keys {

/// What a key is used for.
enum class Speech : std::uint8_t { packets, dtls };

class ClientPackets {
public:
    /// `client_id` must be one of the key's; empty: the first that no other program has. Throws
    /// KeyError.
    explicit ClientPackets(const std::filesystem::path& key_file, const std::string& client_id = {},
                           Speech speech = Speech::packets);
    ClientPackets(const ClientPackets&) = delete;
    ClientPackets& operator=(const ClientPackets&) = delete;

    [[nodiscard]] const std::string& client_id() const { return client_id_; }
    [[nodiscard]] Speech speech() const { return speech_; }
    /// Of DTLS.
    [[nodiscard]] protection::Key pre_shared_key() const;

    /// The packet, valid until the next call; empty when none can be made. Throws KeyError when the
    /// file cannot be written.
    [[nodiscard]] Bytes seal(Bytes message);
    /// The message, which lies in `packet`; empty when it is none for us.
    [[nodiscard]] Bytes open(MutableBytes packet);

    [[nodiscard]] const protection::Refusals& refusals() const { return end_.refusals(); }

private:
    [[nodiscard]] std::string take_session(const std::string& wanted);
    [[nodiscard]] OwnKey read_own();
    void store_bound();

    std::filesystem::path file_;
    Speech speech_;
    LockFile lock_;
    OwnKey own_;
    std::string client_id_;
    protection::DirectionKeys keys_;
    protection::RobotEnd end_;
    protection::SkippedBlocks skipped_;
    std::vector<std::uint8_t> packet_;
};

}  // namespace romano::keys
