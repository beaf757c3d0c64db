// What a daemon tells the service manager that started it (systemd: Type=notify, WatchdogSec): that
// it serves, that it still works, that it ends. sd_notify(3): a datagram a sentence, to the socket
// that NOTIFY_SOCKET names. Without that variable it says nothing.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <string>

namespace romano::net {

class ServiceManager {
public:
    explicit ServiceManager(boost::asio::io_context& io);
    ~ServiceManager();
    ServiceManager(const ServiceManager&) = delete;
    ServiceManager& operator=(const ServiceManager&) = delete;

    /// From now on the io_context's own work is the sign of life, twice in each WATCHDOG_USEC.
    void serving(const std::string& status);
    void ending();

private:
    void tell(const std::string& sentences) const;
    void give_signs_of_life();

    boost::asio::steady_timer timer_;
    std::chrono::microseconds every_{0};  // 0: nobody waits for them
    int socket_ = -1;
};

}  // namespace romano::net
