// The line to romano-host on one machine: JSON objects through ssh, both ways. The machine is gone
// when ssh ends, or when nothing is heard of it for ten seconds.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/streambuf.hpp>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "experiments/testbed/ssh.h"

namespace romano::experiments {

class HostChannel {
public:
    using OnWords = std::function<void(const nlohmann::json& words)>;

    /// Throws std::runtime_error when ssh cannot be started. `on_words` is called for all that is
    /// told, but for answers.
    HostChannel(boost::asio::io_context& io, const Ssh& ssh, OnWords on_words);
    /// Everything that was started there ends; waits for that, up to five seconds.
    ~HostChannel();
    HostChannel(const HostChannel&) = delete;
    HostChannel& operator=(const HostChannel&) = delete;

    [[nodiscard]] const Host& host() const { return ssh_.host(); }

    void tell(const nlohmann::json& words);
    /// Asks for an object with the key `key`, one at a time. Until it has come, what else is told
    /// goes to on_words.
    void begin_asking(const nlohmann::json& words, const std::string& key);
    /// Turns the io_context until the answer is there. Throws std::runtime_error with one sentence
    /// when the machine is gone, has an error, or does not answer in time.
    nlohmann::json await_answer(std::chrono::seconds patience);
    nlohmann::json ask(const nlohmann::json& words, const std::string& key,
                       std::chrono::seconds patience) {
        begin_asking(words, key);
        return await_answer(patience);
    }

    [[nodiscard]] bool is_gone() const { return !why_gone_.empty(); }
    /// A sentence without the host's name: "its ssh connection ended".
    [[nodiscard]] const std::string& why_gone() const { return why_gone_; }

private:
    void read();
    void write();
    void look();
    void on_line(const std::string& line);
    void lose(const std::string& why);

    boost::asio::io_context& io_;
    const Ssh& ssh_;
    OnWords on_words_;
    pid_t pid_ = -1;
    /// Of ssh's input and output. A pipe would end this program when ssh has ended (SIGPIPE).
    boost::asio::local::stream_protocol::socket socket_;
    boost::asio::streambuf heard_;
    std::deque<std::string> to_say_;
    bool is_writing_ = false;
    boost::asio::steady_timer timer_;
    int silent_looks_ = 0;  // of our own clock: a standstill of ours is no silence of theirs
    std::string why_gone_;
    /// Handlers that are due when this goes find it gone.
    std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
    std::string awaited_key_;  // empty: nothing is asked
    std::optional<nlohmann::json> answer_;
    std::string error_;
};

}  // namespace romano::experiments
