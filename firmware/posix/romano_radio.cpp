// romano-radio: the radio's side of a robot whose controller is another chip: HDLC over a UART on
// one hand, UDP on the other.

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>

#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"
#include "firmware/posix/udp_board.h"
#include "firmware/radio/line.h"
#include "firmware/robot/address.h"
#include "romano/base/random.h"
#include "romano/cli/real_number.h"
#include "romano/message/romano_id.h"

namespace {

using namespace romano;
using namespace std::chrono_literals;

constexpr const char* examples = R"(Examples:
  romano-radio --uart /dev/ttyUSB0 --id abcd1234
      a controller at a serial line, 115200 baud
  romano-radio --uart hdlc.sock --id abcd1234 --local 127.0.0.1
      a controller in QEMU: qemu-system-arm ... -chardev socket,id=h,path=hdlc.sock,server=on,wait=off -serial chardev:h
  romano-radio --uart hdlc.sock --id abcd1234 --bit-errors 1e-4
      the same over a bad line

Exit code: 0 when the line ends (or Ctrl-C), 2 when a setting is not possible.)";

struct Settings {
    std::string uart;
    std::string id;
    std::string local = "0.0.0.0";
    std::string group;
    std::string cell_group;
    double bit_errors = 0;
    std::uint64_t seed = 1;
};

volatile std::sig_atomic_t interrupted = 0;

[[noreturn]] void refuse(const std::string& option, const std::string& value,
                         const std::string& why) {
    throw std::invalid_argument("--" + option + " '" + value + "': " + why);
}

int connect_socket(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.size() >= sizeof address.sun_path) refuse("uart", path, "is too long for a socket");
    path.copy(address.sun_path, path.size());
    const int end = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::connect(end, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        refuse("uart", path, std::string{"cannot be connected to: "} + std::strerror(errno));
    }
    ::fcntl(end, F_SETFL, O_NONBLOCK);
    return end;
}

int open_tty(const std::string& path) {
    const int end = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    termios settings{};
    if (end < 0 || ::tcgetattr(end, &settings) != 0) {
        refuse("uart", path, std::string{"is no serial line: "} + std::strerror(errno));
    }
    ::cfmakeraw(&settings);
    ::cfsetspeed(&settings, B115200);
    ::tcsetattr(end, TCSANOW, &settings);
    return end;
}

int open_uart(const std::string& path) {
    struct stat what {};
    if (::stat(path.c_str(), &what) != 0) refuse("uart", path, std::strerror(errno));
    return S_ISSOCK(what.st_mode) ? connect_socket(path) : open_tty(path);
}

class Radio {
public:
    Radio(const Settings& settings, const message::RomanoId& id)
        : id_(id),
          uart_(open_uart(settings.uart)),
          errors_per_million_(static_cast<std::uint32_t>(settings.bit_errors * 8e6)),
          random_(settings.seed) {
        romano_address local{};
        if (!romano_udp_address(settings.local.c_str(), 0, &local)) {
            refuse("local", settings.local, "is no IP address");
        }
        if (const int error = romano_udp_open(&udp_, &local)) {
            refuse("local", settings.local, std::strerror(error));
        }
        scope_ = local.scope;
        if (!settings.group.empty()) udp_.group = group_in("group", settings.group);
        if (settings.cell_group.empty()) return;
        const romano_address cell = group_in("cell-group", settings.cell_group);
        if (const int error = romano_udp_listen(&udp_, &local, &cell)) {
            refuse("cell-group", settings.cell_group, std::strerror(error));
        }
    }
    ~Radio() {
        romano_udp_close(&udp_);
        ::close(uart_);
    }
    Radio(const Radio&) = delete;
    Radio& operator=(const Radio&) = delete;

    void run() {
        std::array<pollfd, 3> ready{{{.fd = uart_, .events = POLLIN, .revents = 0},
                                     {.fd = udp_.socket, .events = POLLIN, .revents = 0},
                                     {.fd = udp_.cell, .events = POLLIN, .revents = 0}}};
        while (interrupted == 0) {
            tell_id();
            line_.on_tick(net::now());
            write_line();
            (void)::poll(ready.data(), ready.size(), 20);
            if (!read_line()) break;
            read_datagrams();
        }
        std::printf("%u frames heard, %u bad, %u repeated; %u datagrams lost\n",
                    line_.link().frame_counters().frames, line_.link().frame_counters().bad_fcs,
                    line_.link().repeats(), line_.lost());
    }

private:
    static romano_address group_in(const std::string& option, const std::string& text) {
        const auto group = net::parse_endpoint(text);
        if (!group || !net::is_multicast(*group) || group->port == 0) {
            refuse(option, text, "is no multicast group and port");
        }
        return firmware::address_of(*group);
    }

    /// The controller's name is the radio's address; it begins when it knows it.
    void tell_id() {
        if (id_told_) return;
        id_told_ =
            line_.send_packet(net::now(), radio::PacketType::hwaddr_get, as_octets(id_.text()));
    }

    /// False when the line has ended.
    bool read_line() {
        std::array<std::uint8_t, 512> octets{};
        const ssize_t size = ::read(uart_, octets.data(), octets.size());
        if (size < 0) return errno == EAGAIN || errno == EINTR;
        if (size == 0) return false;
        for (ssize_t i = 0; i < size; ++i) {
            const auto input =
                line_.on_octet(net::now(), disturbed(octets[static_cast<std::size_t>(i)]));
            if (input.packet && input.packet->type == radio::PacketType::hwaddr_ack) {
                std::puts("the controller knows its id");
                std::fflush(stdout);
            }
            if (input.datagram) send_datagram(*input.datagram);
            write_line();
        }
        return true;
    }

    void send_datagram(const radio::Datagram& datagram) {
        romano_address to = firmware::address_of(datagram.peer);
        to.scope = scope_;
        udp_.board.send(udp_.board.self, &to, datagram.octets.data(),
                        static_cast<std::uint32_t>(datagram.octets.size()));
    }

    void read_datagrams() {
        romano_address from{};
        std::uint32_t size = 0;
        while (const auto* octets = udp_.board.receive(udp_.board.self, &from, &size)) {
            line_.send(net::now(),
                       {firmware::endpoint_of(from), radio::unknown_dbm, {octets, size}});
        }
    }

    void write_line() {
        for (const std::uint8_t octet : line_.line_out()) {
            const std::uint8_t sent = disturbed(octet);
            pollfd ready{.fd = uart_, .events = POLLOUT, .revents = 0};
            while (::write(uart_, &sent, 1) < 0 && errno == EAGAIN && interrupted == 0) {
                (void)::poll(&ready, 1, 100);
            }
        }
        line_.clear_line_out();
    }

    std::uint8_t disturbed(std::uint8_t octet) {
        if (errors_per_million_ == 0 || !random_.happens(errors_per_million_)) return octet;
        return octet ^ static_cast<std::uint8_t>(1U << random_.below(8));
    }

    message::RomanoId id_;
    int uart_;
    std::uint32_t errors_per_million_;  // octets with a wrong bit
    Random random_;
    romano_udp_board udp_{};
    std::uint32_t scope_ = 0;
    std::array<std::uint8_t, 8192> to_send_{};
    std::array<std::uint8_t, 2048> to_receive_{};
    radio::Line line_{radio::PacketType::forward_udp, to_send_, to_receive_,
                      hdlc::default_repeat_after};
    bool id_told_ = false;
};

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{
        "The radio's side of a robot: HDLC over a UART to its controller, UDP to the "
        "brokers.",
        "romano-radio"};
    app.footer(examples);
    Settings settings;
    app.add_option("--uart", settings.uart, "A serial device, or QEMU's socket")
        ->type_name("PATH")
        ->required();
    app.add_option("--id", settings.id, "The robot's ROMANO id")->type_name("ID")->required();
    app.add_option("--local", settings.local, "Own IP address; its family is spoken")
        ->type_name("ADDR")
        ->capture_default_str();
    app.add_option("--group", settings.group,
                   "Where discovery asks (default: 225.1.1.1:1883 or [ff02::225:1:1:1]:1883)")
        ->type_name("ADDR:PORT");
    app.add_option("--cell-group", settings.cell_group,
                   "Listen to this multicast group, too, for a controller that listens to its "
                   "broker's cell (its --cell-group)")
        ->type_name("ADDR:PORT");
    app.add_option("--bit-errors", settings.bit_errors, "Make the line bad: this share of bits")
        ->check(real_number(0, 0.1))
        ->capture_default_str();
    app.add_option("--seed", settings.seed, "Of the bad line")->capture_default_str();
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGINT, [](int) { interrupted = 1; });
    std::signal(SIGTERM, [](int) { interrupted = 1; });
    try {
        app.parse(argc, argv);
        const auto id = message::RomanoId::parse(settings.id);
        if (!id) refuse("id", settings.id, "must be 8 lower-case hexadecimal digits");
        Radio{settings, *id}.run();
        return 0;
    } catch (const CLI::Success& asked) {
        return app.exit(asked);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "romano-radio: %s\n", error.what());
        return 2;
    }
}
