// --web: the fleet in a browser. `romano web` runs as a process beside the broker and is a client
// of it like any other, so that nothing that a browser does, and no fault of the page, can hold the
// broker up. When it ends it is started again; when the broker ends, however it ends, the kernel
// ends the page.
#pragma once

#include <sys/types.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "broker/daemon/settings.h"
#include "broker/net/turn_clock.h"

namespace romano::daemon {

/// What `romano` is told, for a broker that serves `addresses`.
[[nodiscard]] std::vector<std::string> web_arguments(const WebSettings& settings,
                                                     const std::vector<Endpoint>& addresses);

class WebPage {
public:
    static constexpr std::chrono::seconds shortest_pause{1};
    static constexpr std::chrono::seconds longest_pause{60};

    /// Does nothing without the setting. Throws Refusal: the address cannot be served, the key
    /// or what keeps strangers out cannot be read, or there is no `romano` beside the broker's
    /// program.
    WebPage(boost::asio::io_context& io, const Settings& settings);
    ~WebPage();
    WebPage(const WebPage&) = delete;
    WebPage& operator=(const WebPage&) = delete;

    /// The broker serves there from now on.
    void show(const std::vector<Endpoint>& addresses);

private:
    void start();
    void wait_for_end();
    void on_end(const std::string& how);

    net::TurnClock& turns_;
    std::optional<WebSettings> settings_;
    std::string program_;
    std::vector<std::string> arguments_;
    boost::asio::signal_set ends_;  // of processes that this one started
    boost::asio::steady_timer timer_;
    std::chrono::seconds pause_ = shortest_pause;
    std::chrono::steady_clock::time_point started_{};
    pid_t process_ = 0;  // 0: none runs
};

}  // namespace romano::daemon
