#include "overlay/dds/wakeup.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <chrono>
#include <thread>

namespace romano::dds::wakeup_test {
namespace {

TEST(Wakeup, FromOtherThreadsIsAnsweredInTheBrokersAndAfterTheLastRing) {
    constexpr int each = 1000;
    boost::asio::io_context io;
    const auto open = boost::asio::make_work_guard(io);
    std::atomic<int> arrived = 0;
    int taken = 0;  // the broker's own
    const auto wakeup = std::make_shared<Wakeup>(io, [&] { taken = arrived.load(); });

    std::array<std::thread, 3> threads;
    for (std::thread& thread : threads) {
        thread = std::thread([&] {
            for (int i = 0; i < each; ++i) {
                ++arrived;
                wakeup->ring();
            }
        });
    }
    while (taken < 3 * each && io.run_one_for(std::chrono::seconds{30}) == 1) {
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(taken, 3 * each);
}

TEST(Wakeup, RingsThatComeTogetherAreOneAnswer) {
    boost::asio::io_context io;
    int answers = 0;
    const auto wakeup = std::make_shared<Wakeup>(io, [&] { ++answers; });
    for (int i = 0; i < 3; ++i) wakeup->ring();
    io.poll();
    EXPECT_EQ(answers, 1);
}

TEST(Wakeup, ThatIsGoneAnswersNoRing) {
    boost::asio::io_context io;
    int answers = 0;
    auto wakeup = std::make_shared<Wakeup>(io, [&] { ++answers; });
    wakeup->ring();
    wakeup.reset();
    io.poll();
    EXPECT_EQ(answers, 0);
}

}  // namespace
}  // namespace romano::dds::wakeup_test
