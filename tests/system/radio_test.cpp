// romano-radio with a controller that is not as it should be at the other end of its line.

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <string>

#include "firmware/hdlc/frame.h"
#include "tests/system/process.h"
#include "tests/temporary_folder.h"

namespace romano::system::radio_test {
namespace {

/// The controller's end of a line, as QEMU offers it to the radio.
class ControllersEnd {
public:
    explicit ControllersEnd(const std::string& path)
        : listening_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        const auto* any = reinterpret_cast<const sockaddr*>(&address);
        if (::bind(listening_, any, sizeof address) != 0 || ::listen(listening_, 1) != 0) {
            ADD_FAILURE() << "no socket at " << path;
        }
    }
    ~ControllersEnd() {
        ::close(line_);
        ::close(listening_);
    }
    ControllersEnd(const ControllersEnd&) = delete;
    ControllersEnd& operator=(const ControllersEnd&) = delete;

    void accept() { line_ = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC); }

    /// Says as much as the radio takes, and hears nothing of its acknowledgements.
    void talk_until_the_line_is_full() const {
        std::array<std::uint8_t, hdlc::max_encoded> octets{};
        for (std::uint8_t seq = 0;; ++seq) {
            pollfd room{.fd = line_, .events = POLLOUT, .revents = 0};
            if (::poll(&room, 1, 1000) == 0) return;
            const std::size_t size = hdlc::encode(
                {hdlc::FrameKind::data, static_cast<std::uint8_t>(seq & 7U), {}}, octets);
            if (::send(line_, octets.data(), size, MSG_NOSIGNAL) < 0) return;
        }
    }

private:
    int listening_;
    int line_ = -1;
};

TEST(Radio, EndsWhenToldThoughItsLineIsStuck) {
    const tests::TemporaryFolder folder;
    ControllersEnd controller(folder / "uart");
    Process radio(ROMANO_RADIO,
                  {"--uart", folder / "uart", "--id", "abcd1234", "--local", "127.0.0.1"});
    controller.accept();
    controller.talk_until_the_line_is_full();
    radio.signal(SIGTERM);
    EXPECT_EQ(radio.wait_for_exit(), 0);
}

}  // namespace
}  // namespace romano::system::radio_test
