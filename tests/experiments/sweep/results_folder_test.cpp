// A results folder is the sweep's memory: what is done is not done again.

#include "experiments/sweep/results_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "tests/temporary_folder.h"

namespace romano::experiments::results_folder_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ResultsFolders : public ::testing::Test {
protected:
    RunRow made_up(const Cell& cell) const {
        RunRow row;
        row.cell = cell;
        row.delivery_ratio = 1;
        return row;
    }

    tests::TemporaryFolder temporary_;
    fs::path folder_ = temporary_ / "results";
    Sweep sweep_ = parse_sweep("[axes]\nbrokers = [1, 2, 3]\n", "try.toml");
};

TEST_F(ResultsFolders, RememberTheCellsThatWereRun) {
    {
        ResultsFolder results{folder_, sweep_, false};
        EXPECT_FALSE(results.row_of(sweep_.cells[0]));
        results.put(made_up(sweep_.cells[0]));
    }
    const ResultsFolder again{folder_, sweep_, false};
    EXPECT_TRUE(again.row_of(sweep_.cells[0]));
    EXPECT_FALSE(again.row_of(sweep_.cells[1]));
    EXPECT_EQ(again.rows().at(0).delivery_ratio, 1);
}

TEST_F(ResultsFolders, ForgetARowThatWasCutOff) {
    {
        ResultsFolder results{folder_, sweep_, false};
        results.put(made_up(sweep_.cells[0]));
    }
    const std::string line = csv_line(to_csv(made_up(sweep_.cells[1])));
    std::ofstream(folder_ / "runs.csv", std::ios::app) << line.substr(0, line.size() / 2);
    {
        ResultsFolder results{folder_, sweep_, false};
        EXPECT_FALSE(results.row_of(sweep_.cells[1]));
        results.put(made_up(sweep_.cells[1]));
    }
    EXPECT_EQ((ResultsFolder{folder_, sweep_, false}.rows().size()), 2u);
}

// Cell 1000's files begin as cell 10000's do.
TEST_F(ResultsFolders, TakeACellWithItsFilesAndNoOthers) {
    const fs::path from = temporary_ / "shard";
    RunRow row = made_up(sweep_.cells[0]);
    row.cell.number = 1000;
    {
        ResultsFolder shard{from, sweep_, false};
        shard.put(row);
    }
    for (const char* name : {"samples/cell-1000.csv", "samples/cell-1000-memory.csv",
                             "samples/cell-10000.csv", "traces/cell-1000-b1.txt"}) {
        std::ofstream(from / name) << name;
    }
    {
        ResultsFolder whole{folder_, sweep_, false};
        whole.take(std::vector{row}, from);
    }
    EXPECT_TRUE(fs::exists(folder_ / "samples/cell-1000.csv"));
    EXPECT_TRUE(fs::exists(folder_ / "samples/cell-1000-memory.csv"));
    EXPECT_TRUE(fs::exists(folder_ / "traces/cell-1000-b1.txt"));
    EXPECT_FALSE(fs::exists(folder_ / "samples/cell-10000.csv"));
    EXPECT_EQ(read_results(folder_).rows.size(), 1u);
}

TEST_F(ResultsFolders, AFolderWithoutResultsIsNamed) {
    try {
        (void)read_results(temporary_ / "nothing");
        FAIL() << "accepted";
    } catch (const SweepError& error) {
        EXPECT_THAT(error.what(), HasSubstr("nothing` holds no results of a sweep"));
    }
}

TEST_F(ResultsFolders, RefuseAnotherExperimentUntilFresh) {
    {
        ResultsFolder results{folder_, sweep_, false};
        results.put(made_up(sweep_.cells[0]));
    }
    const Sweep changed = parse_sweep("[axes]\nbrokers = [1, 2]\n", "try.toml");
    try {
        const ResultsFolder results{folder_, changed, false};
        FAIL() << "accepted";
    } catch (const SweepError& error) {
        EXPECT_THAT(error.what(), HasSubstr("the sweep file means another experiment since"));
        EXPECT_THAT(error.what(), HasSubstr("--fresh"));
    }
    EXPECT_TRUE((ResultsFolder{folder_, changed, true}.rows().empty()));
}

TEST_F(ResultsFolders, GoOnWhenTheSweepFileSaysTheSameInOtherWords) {
    {
        ResultsFolder results{folder_, sweep_, false};
        results.put(made_up(sweep_.cells[0]));
    }
    const Sweep same = parse_sweep(
        "# a thought\nduration = 10.0\nnetwork = '127.9'\n[axes]\nbrokers = [1,2,3]", "try.toml");
    EXPECT_EQ((ResultsFolder{folder_, same, false}.rows().size()), 1u);
}

TEST_F(ResultsFolders, BelongToOneSweepAtATime) {
    {
        const ResultsFolder results{folder_, sweep_, false};
        try {
            const ResultsFolder second{folder_, sweep_, true};
            FAIL() << "accepted";
        } catch (const SweepError& error) {
            EXPECT_THAT(error.what(), HasSubstr("another sweep is writing into"));
        }
    }
    EXPECT_NO_THROW((ResultsFolder{folder_, sweep_, true}));
}

TEST_F(ResultsFolders, TakeANewRunOfACellInThePlaceOfTheEarlierOne) {
    {
        ResultsFolder results{folder_, sweep_, false};
        RunRow failed = made_up(sweep_.cells[0]);
        failed.status = "no luck";
        results.put(failed);
        results.put(made_up(sweep_.cells[1]));
        results.put(made_up(sweep_.cells[0]));
    }
    const ResultsFolder again{folder_, sweep_, false};
    EXPECT_EQ(again.rows().size(), 2u);
    EXPECT_TRUE(again.row_of(sweep_.cells[0])->ok());
}

// Ten thousand cells must not cost ten thousand rewritings: a run adds its row, and no more.
TEST_F(ResultsFolders, HaveEachRowAtOnceAndInOrderInTheEnd) {
    const auto numbers = [this] {
        std::vector<std::string> found;
        std::ifstream stream(folder_ / "runs.csv");
        std::string line;
        std::getline(stream, line);
        while (std::getline(stream, line)) found.push_back(line.substr(0, line.find(',')));
        return found;
    };
    RunRow failed = made_up(sweep_.cells[1]);
    failed.status = "no luck";
    ResultsFolder results{folder_, sweep_, false};
    for (const RunRow& row :
         {made_up(sweep_.cells[2]), failed, made_up(sweep_.cells[0]), made_up(sweep_.cells[1])}) {
        results.put(row);
    }
    EXPECT_THAT(numbers(), ElementsAre("3", "2", "1", "2"));
    // So it is found after a kill -9: a cell's last row counts.
    const std::vector<RunRow> read = read_results(folder_).rows;
    ASSERT_EQ(read.size(), 3u);
    EXPECT_EQ(read[1].cell, sweep_.cells[1]);
    EXPECT_TRUE(read[1].ok());
    results.set_in_order();
    EXPECT_THAT(numbers(), ElementsAre("1", "2", "3"));
    results.put(made_up(sweep_.cells[0]));
    EXPECT_THAT(numbers(), ElementsAre("1", "2", "3", "1")) << "it goes on behind them";
}

TEST_F(ResultsFolders, AFreshStartLeavesOtherFilesAlone) {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "notes.txt") << "mine";
    const ResultsFolder results{folder_, sweep_, true};
    EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
}

TEST_F(ResultsFolders, KeepRawSamplesOnePerMessageAndReceiver) {
    const ResultsFolder results{folder_, sweep_, false};
    DeliveryAccount account;
    const std::vector<RobotNumber> receivers = {0, 2};
    account.on_published(1, Stream::group, 1, 0.5, receivers);
    account.on_arrived(1, 0, 2, 0.75);
    results.write_samples(sweep_.cells[0], account);
    const auto samples = read_samples(folder_, sweep_.cells[0]);
    ASSERT_EQ(samples.size(), 2u);
    EXPECT_EQ(samples[0].receiver, 0u);
    EXPECT_EQ(samples[0].delay_ms, std::nullopt);
    EXPECT_EQ(samples[1].delay_ms, 250);
    EXPECT_EQ(samples[1].stream, Stream::group);
    EXPECT_EQ(samples[1].sent_s, 0.5);
}

TEST_F(ResultsFolders, ThatCannotBeMadeAreRefused) {
    EXPECT_THROW((ResultsFolder{"/proc/nowhere", sweep_, false}), SweepError);
}

}  // namespace
}  // namespace romano::experiments::results_folder_test
