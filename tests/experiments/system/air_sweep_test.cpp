// The same cell both ways: on the modelled radio in virtual time, and with real brokers and robots
// that have the radio between them in real time.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "experiments/sweep/csv.h"
#include "experiments/sweep/run_row.h"
#include "tests/experiments/system/processes.h"
#include "tests/temporary_folder.h"

namespace romano::experiments::air_sweep_test {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

class AirSweep : public ::testing::Test {
protected:
    Ran sweep(const std::string& world, const std::string& rest) const {
        std::ofstream(folder_ / (world + ".toml"))
            << "world = \"" << world << "\"\noutput = \"" << (folder_ / world).string() << "\"\n"
            << rest;
        return run_romano("sweep " + (folder_ / (world + ".toml")).string());
    }
    [[nodiscard]] std::vector<RunRow> rows(const std::string& world) const {
        std::ifstream stream(folder_ / world / "runs.csv");
        const std::string text{std::istreambuf_iterator<char>(stream), {}};
        std::vector<RunRow> rows;
        for (const CsvRow& fields : parse_csv(text)) {
            if (auto row = run_from_csv(fields)) rows.push_back(std::move(*row));
        }
        return rows;
    }

    tests::TemporaryFolder folder_;
};

constexpr const char* cells =
    "pattern = \"commands\"\nduration = 3\nfault_after = 1\nretry = 0.5\nstart_within = 60\n"
    "publish_within = 30\nbroker_options = [\"--profile\", \"wifi\"]\n"
    "[axes]\nbrokers = 2\nrobots = 2\nrate = 20\nqos = 1\nrouter_baud = 230400\n"
    "fault = [\"none\", \"kill-home\"]\n";

// How quick real processes are depends on the machine; that none is quicker than its channel, and
// that all arrives, does not.
TEST_F(AirSweep, DeliversWhatTheSameCellDeliversInVirtualTimeAndNoSooner) {
    ASSERT_EQ(sweep("radio", cells).exit_code, 0);
    const Ran real = sweep("air", cells);
    const auto modelled = rows("radio");
    const auto measured = rows("air");
    ASSERT_THAT(modelled, SizeIs(2));
    ASSERT_THAT(measured, SizeIs(2)) << real.output;
    for (std::size_t i = 0; i < measured.size(); ++i) {
        const RunRow& row = measured[i];
        if (row.status.find("this machine was too busy for it") != std::string::npos) {
            GTEST_SKIP() << row.status;
        }
        EXPECT_EQ(row.status, "ok");
        EXPECT_EQ(row.expected, modelled[i].expected);
        EXPECT_EQ(row.delivered, modelled[i].delivered);
        EXPECT_EQ(row.acknowledged_but_lost_qos1, 0);
        EXPECT_EQ(row.failover_recovered_clients, modelled[i].failover_recovered_clients);
        EXPECT_GE(*row.delay_p50_ms, 0.85 * *modelled[i].delay_p50_ms);
    }
    std::ifstream page(folder_ / "air/report.html");
    const std::string report{std::istreambuf_iterator<char>(page), {}};
    EXPECT_THAT(report, HasSubstr("in real time; each broker's cell has a border router (UART: "
                                  "230400 baud; the robots': 115200 baud)"));
}

TEST_F(AirSweep, RefusesWhatItHasNot) {
    const Ran cut = sweep("air", "[axes]\nbrokers = 2\nfault = \"cut\"\n");
    EXPECT_EQ(cut.exit_code, 2);
    EXPECT_THAT(cut.output, HasSubstr("`world = \"air\"`: fault `cut`"));
    const Ran crowd = sweep("air", "[axes]\nrobots = 201\n");
    EXPECT_EQ(crowd.exit_code, 2);
    EXPECT_THAT(crowd.output, HasSubstr("201 robots are too many for one cell in real time"));
}

}  // namespace
}  // namespace romano::experiments::air_sweep_test
