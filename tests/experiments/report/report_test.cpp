// A report of synthetic runs holds what a reader needs: verdict, figures, table, failures, rerun.

#include "experiments/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "experiments/report/configuration.h"
#include "experiments/report/crowd.h"
#include "experiments/report/figures.h"
#include "experiments/report/page.h"
#include "experiments/report/section.h"
#include "experiments/report/summary_table.h"
#include "experiments/sweep/results_folder.h"

namespace romano::experiments::report_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* sweep_text = R"(
name = "synthetic"
repetitions = 2
[[axes]]
brokers = [1, 2, 3, 5]
robots = 20
fault = ["none", "kill-leader", "kill-home"]
[[axes]]
brokers = 3
robots = [5, 10, 40]
)";

RunRow made_up(const Cell& cell) {
    RunRow row;
    row.cell = cell;
    const double noise = std::sin(cell.number);
    row.published = row.acknowledged = 100;
    row.acknowledged_but_lost_qos1 = row.acknowledged_but_lost_qos2 = row.duplicates_qos2 = 0;
    row.delivery_ratio = cell.fault == Fault::none ? 1 : 0.99;
    row.delivery_ratio_qos0 = cell.fault == Fault::none ? 1 : 0.97 + 0.01 * noise;
    row.delivery_ratio_qos1 = row.delivery_ratio_qos2 = 1;
    row.delay_p50_ms = 1 + 0.02 * cell.robots + 0.1 * noise;
    row.delay_p99_ms = 4 + 0.1 * cell.robots + noise;
    row.fan_out_p50_ms = 2 + 0.03 * cell.robots;
    row.fan_out_p99_ms = 6 + 0.2 * cell.robots;
    row.interbroker_octets_per_s = 20'000.0 * (cell.brokers - 1);
    row.broker_cpu_percent_mean = 3 + cell.brokers + noise;
    row.broker_rss_peak_mib_mean = 20 + cell.brokers;
    if (cell.fault != Fault::none) {
        row.failover_clients = row.failover_recovered_clients = 7;
        row.failover_first_ms = 120 + 10 * noise;
        row.failover_p50_ms = 150 + 10 * noise;
        row.failover_last_ms = 190 + 10 * noise;
        row.connects_after_fault = row.registers_after_fault = row.subscribes_after_fault = 0;
    }
    if (cell.fault == Fault::kill_leader) row.without_leader_ms = 110 + 5 * noise;
    return row;
}

class Reports : public ::testing::Test {
protected:
    void SetUp() override {
        const char* kept = std::getenv("ROMANO_KEEP_REPORT");
        folder_ = kept != nullptr
                      ? fs::path{kept}
                      : fs::temp_directory_path() / ("romano-report-" + std::to_string(::getpid()));
        const ResultsFolder results{folder_, sweep_, true};
        for (const Cell& cell : sweep_.cells) rows_.push_back(made_up(cell));
        DeliveryAccount account;
        const std::vector<RobotNumber> receivers = {0, 1, 2};
        for (int i = 0; i < 400; ++i) {
            const double sent = i * 0.02;
            const auto sequence = account.on_published(
                0, Stream::group, static_cast<std::uint8_t>(i % 3), sent, receivers);
            const double ready = sent > 4 && sent < 4.15 ? 4.15 : sent;
            for (const RobotNumber receiver : receivers) {
                account.on_arrived(0, sequence, receiver, ready + 0.001 * (receiver + 1));
            }
        }
        for (const Cell& cell : sweep_.cells) results.write_samples(cell, account);
    }
    void TearDown() override {
        if (std::getenv("ROMANO_KEEP_REPORT") == nullptr) fs::remove_all(folder_);
    }

    std::string report() const { return report_of(sweep_, manifest_, rows_, folder_); }

    fs::path folder_;
    Sweep sweep_ = parse_sweep(sweep_text, "synthetic.toml");
    std::vector<RunRow> rows_;
    Manifest manifest_{.build = build_info(),
                       .machine = this_machine(),
                       .started_utc = "2000-01-02 03:04:05 UTC",
                       .sweep_file = "/some/where/synthetic.toml",
                       .broker_version = "romano-broker"};
};

TEST_F(Reports, OfSectionsHaveTheStyleOfAllPages) {  // and so its margins
    fs::create_directories(folder_);
    write_report({.title = "Paper", .heading = "The <paper>"}, {}, folder_);
    std::ifstream file(folder_ / "report.html");
    const std::string html{std::istreambuf_iterator<char>(file), {}};
    EXPECT_TRUE(html.starts_with(page_begin("Paper", "The <paper>")));
    EXPECT_THAT(html, HasSubstr("padding: 2rem"));
    EXPECT_THAT(html, HasSubstr("<h1>The &lt;paper&gt;</h1>"));
}

TEST_F(Reports, StandAloneWithTheirFigures) {
    const std::string html = report();
    for (const char* part :
         {"<!DOCTYPE html>", "Failover time against the number of brokers",
          "Delay against the number of robots", "Delivery ratio",
          "Overhead against the number of brokers", "What a fault looks like",
          "How it was measured", "romano sweep '/some/where/synthetic.toml' --cell 1", "CPU",
          "Commit", "</html>"}) {
        EXPECT_THAT(html, HasSubstr(part));
    }
    for (const char* from_elsewhere : {"<script", "<link", "src=\"", "@import"}) {
        EXPECT_THAT(html, Not(HasSubstr(from_elsewhere)));
    }
    std::ofstream(folder_ / "report.html") << html;
}

TEST_F(Reports, NameTheHostsOfTheBrokers) {
    EXPECT_THAT(report(), Not(HasSubstr("Hosts of the brokers")));
    EXPECT_THAT(report(), HasSubstr("over UDP on one host"));
    manifest_.hosts_file = "/some/where/hosts.toml";
    manifest_.hosts = {
        {.name = "pi1",
         .addresses = {"192.168.1.101", "192.168.1.102"},
         .architecture = "aarch64",
         .broker_version = "romano-broker 0.1.0"},
        {.name = "<b>pi2", .addresses = {}, .architecture = "", .broker_version = ""}};
    manifest_ = parse_manifest(to_json(manifest_, sweep_), "manifest.json");
    const std::string html = report();
    for (const char* part :
         {"Hosts of the brokers", "pi1", "192.168.1.101 192.168.1.102", "aarch64", "&lt;b&gt;pi2",
          "real brokers on 2 hosts and real MQTT-SN robots on another machine",
          "romano sweep '/some/where/synthetic.toml' --hosts '/some/where/hosts.toml' --fresh",
          "--hosts '/some/where/hosts.toml' --cell 1"}) {
        EXPECT_THAT(html, HasSubstr(part));
    }
}

TEST_F(Reports, DrawEveryFigureAsSvgAndKeepItsScript) {
    const auto configurations = configurations_of(rows_);
    for (const Figure& figure : figures_of(configurations, sweep_.settings, folder_)) {
        for (const Plot& plot : one_by_one(figure.plot)) {
            const auto svg = draw(plot, folder_ / "plots");
            ASSERT_TRUE(svg) << figure.title;
            EXPECT_TRUE(svg->starts_with("<svg")) << figure.title;
            EXPECT_TRUE(fs::exists(folder_ / "plots" / (plot.name + ".gp"))) << figure.title;
        }
    }
}

/// Where a drawing has a text: its baseline, from above.
double y_of(const std::string& svg, const std::string& text) {
    const std::size_t at = svg.find(text);
    EXPECT_NE(at, std::string::npos) << text;
    const std::size_t place = svg.rfind("translate(", at);
    return std::stod(svg.substr(svg.find(',', place) + 1));
}

TEST_F(Reports, DrawTheKeyBelowTheAxisHoweverManySeriesThereAre) {
    for (const std::size_t count : {1U, 2U, 5U, 12U}) {
        PlotPanel panel{.title = "t", .x_label = "x axis", .y_label = "y", .series = {}};
        std::vector<std::string> labels;
        for (std::size_t i = 0; i < count; ++i) {
            labels.push_back("median, 3 brokers, QoS 0+1+2, acks " + std::to_string(10 + i));
            const auto y = static_cast<double>(i);
            panel.series.push_back({.label = labels.back(), .points = {{1, y}, {2, y + 1}}});
        }
        for (const std::vector<PlotPanel>& panels :
             {std::vector{panel}, std::vector{panel, panel}}) {
            const auto svg = draw({.name = "keys", .panels = panels}, folder_ / "plots");
            ASSERT_TRUE(svg);
            double above = y_of(*svg, "x axis");
            for (const std::string& label : labels) {
                EXPECT_GT(y_of(*svg, label), above + 8) << label << " of " << count;
                above = y_of(*svg, label);
            }
        }
    }
}

TEST_F(Reports, DrawTheKeyBelowTheAxisHoweverLongItsLabelsAre) {
    for (const std::size_t length : {6U, 7U, 9U, 10U, 16U, 17U}) {  // where a column goes
        PlotPanel panel{.title = "t", .x_label = "x axis", .y_label = "y", .series = {}};
        std::vector<std::string> labels;
        for (char letter = 'a'; letter <= 'g'; ++letter) {
            labels.push_back(std::string(length, letter));
            const double y = letter;
            panel.series.push_back({.label = labels.back(),
                                    .points = {{.x = 1, .y = y, .low = y - 1, .high = y + 1}}});
        }
        const auto svg = draw({.name = "keys", .panels = {panel}}, folder_ / "plots");
        ASSERT_TRUE(svg);
        const double axis = y_of(*svg, "x axis");
        for (const std::string& label : labels) {
            EXPECT_GT(y_of(*svg, '>' + label + '<'), axis + 8) << length;
        }
    }
}

/// The texts of a drawing, each with its place from the left.
std::vector<std::pair<double, std::string>> texts_of(const std::string& svg) {
    std::vector<std::pair<double, std::string>> texts;
    for (std::size_t at = svg.find("<text>"); at != std::string::npos;
         at = svg.find("<text>", at + 1)) {
        const std::size_t place = svg.rfind("translate(", at);
        const std::size_t begin = at + 6;
        texts.emplace_back(std::stod(svg.substr(place + 10)),
                           svg.substr(begin, svg.find('<', begin) - begin));
    }
    return texts;
}

TEST_F(Reports, BreakLabelsThatAreLongerThanAFigureIsWide) {
    const std::string label =
        "3 brokers, QoS 1, backbone radio, router baud 115200, robot baud none, broker dies";
    const std::string word(100, 'm');
    PlotPanel panel{.title = "t", .x_label = "x axis", .y_label = "y", .series = {}};
    panel.series.push_back({.label = label, .points = {{1, 1}, {2, 2}}});
    panel.series.push_back({.label = word, .points = {{1, 2}, {2, 3}}, .marked = false});
    panel.series.push_back({.label = "last", .points = {{1, 3}, {2, 4}}});
    const auto svg = draw({.name = "keys", .panels = {panel}}, folder_ / "plots");
    ASSERT_TRUE(svg);
    std::string drawn;
    for (const auto& [x, text] : texts_of(*svg)) {
        EXPECT_GE(x, 0);
        EXPECT_LE(text.size(), 40U) << "it is cut at the edge";
        drawn += text + ' ';
    }
    EXPECT_THAT(drawn, HasSubstr("QoS 1, backbone radio, router"));
    EXPECT_THAT(drawn, HasSubstr("baud 115200, robot baud none, broker dies"));
    EXPECT_EQ(std::ranges::count(drawn, 'm'), 100);
    EXPECT_GT(y_of(*svg, "robot baud none"), y_of(*svg, "3 brokers")) << "in the next row";
    EXPECT_GT(y_of(*svg, ">last<"), y_of(*svg, "robot baud none"));
}

TEST_F(Reports, LeaveOutPanelsWithoutAPoint) {
    const PlotPanel empty{
        .title = "e", .x_label = "x", .y_label = "y", .series = {{.label = "a", .points = {}}}};
    PlotPanel panel = empty;
    panel.series[0].points = {{1, 1}};
    EXPECT_EQ(one_by_one({.name = "p", .panels = {empty, panel, empty}}).size(), 1U);
    EXPECT_FALSE(draw({.name = "p", .panels = {empty}}, folder_ / "plots"));
}

TEST_F(Reports, NameEachOfSeveralSeriesOfAPanel) {
    const auto configurations = configurations_of(rows_);
    for (const Figure& figure : figures_of(configurations, sweep_.settings, folder_)) {
        for (const PlotPanel& panel : figure.plot.panels) {
            for (const PlotSeries& series : panel.series) {
                EXPECT_TRUE(panel.series.size() == 1 || !series.label.empty()) << figure.title;
            }
        }
    }
}

TEST_F(Reports, ShowTheDelayAgainstWhatVaries) {
    const Sweep rates = parse_sweep("[axes]\nrate = [1, 10]\n", "try.toml");
    std::vector<RunRow> rows;
    for (const Cell& cell : rates.cells) rows.push_back(made_up(cell));
    const auto configurations = configurations_of(rows);
    for (const Figure& figure : figures_of(configurations, rates.settings, folder_)) {
        EXPECT_NE(figure.plot.name, "delay") << "forty series above one number of robots";
    }
    EXPECT_THAT(report(), HasSubstr("Delay against the number of robots"));
    const auto figures = figures_of(configurations, rates.settings, folder_);
    const auto rate = std::ranges::find(figures, "Against the message rate", &Figure::title);
    ASSERT_NE(rate, figures.end());
    EXPECT_LT(rate->plot.panels[0].y_to, 100.1) << "of what was expected no more can be delivered";
    EXPECT_LE(rate->plot.panels[0].y_from, 99.0);
    sweep_ = parse_sweep("[axes]\nbrokers = [1, 3]\nrobots = 20\n", "try.toml");
    rows_.clear();
    for (const Cell& cell : sweep_.cells) rows_.push_back(made_up(cell));
    EXPECT_THAT(report(), HasSubstr("Delay against the number of brokers"));
}

TEST_F(Reports, SetMarksOfOnePlaceBesideEachOtherAndNameALevelOnce) {
    const Sweep levels =
        parse_sweep("[axes]\nbrokers = 3\nqos = [1, 2]\nacks = [0, 1, 2]\n", "try.toml");
    std::vector<RunRow> rows;
    for (const Cell& cell : levels.cells) {
        rows.push_back(made_up(cell));
        auto& other = cell.qos.text() == "1" ? rows.back().delivery_ratio_qos2
                                             : rows.back().delivery_ratio_qos1;
        rows.back().delivery_ratio_qos0 = other = std::nullopt;
    }
    const auto configurations = configurations_of(rows);
    for (const Figure& figure : figures_of(configurations, levels.settings, folder_)) {
        if (figure.plot.name != "delivery" && figure.plot.name != "delay") continue;
        for (const PlotPanel& panel : figure.plot.panels) {
            std::set<double> places;
            for (const PlotSeries& series : panel.series) {
                EXPECT_TRUE(places.insert(series.points.at(0).x).second) << series.label;
                EXPECT_NEAR(series.points.at(0).x, 3, 0.49) << "it would get a tick of its own";
                EXPECT_THAT(series.label, Not(HasSubstr("QoS 1, QoS 1")));
            }
            EXPECT_EQ(places.size(), figure.plot.name == "delay" ? 12U : 6U) << figure.title;
        }
    }
}

TEST_F(Reports, SayHowFineTheTimesOfAFailoverAre) {
    const std::string html = report();
    EXPECT_THAT(html, HasSubstr("a message of each publisher every 1000 ms"));
    EXPECT_THAT(html, HasSubstr("of which up to 1000 ms is the wait for a message"));
    EXPECT_THAT(html, Not(HasSubstr("probe of")));
    for (RunRow& row : rows_) row.failover_probe_ms = 120;
    sweep_.settings.probe_per_s = 200;
    const std::string probed = report();
    EXPECT_THAT(probed, HasSubstr("120 ms</b><span>failover in the median run, by a probe of 200"));
    EXPECT_THAT(probed, HasSubstr("has a message every 5 ms"));
}

TEST_F(Reports, ShowTheSecondsAroundTheFirstFault) {  // a soak's page would be 140 MB of marks
    std::size_t shown = 0;
    const auto configurations = configurations_of(rows_);
    SweepSettings late = sweep_.settings;
    late.fault_after = std::chrono::seconds{12};  // published for 8 s
    for (const Figure& figure : figures_of(configurations, late, folder_)) {
        if (figure.plot.name != "around_a_fault") continue;
        for (const PlotSeries& series : figure.plot.panels.at(0).series) {
            for (const auto& point : series.points) EXPECT_GE(point.x, 7);
            shown += series.points.size();
        }
    }
    EXPECT_EQ(shown, 3U * 50);
}

TEST_F(Reports, TellOfRunsThatFailed) {
    rows_[4].status = "broker b1 ended unexpectedly, signal 11 <Segmentation fault>";
    const std::string html = report();
    EXPECT_THAT(html, HasSubstr("Runs that failed"));
    EXPECT_THAT(html, HasSubstr("signal 11 &lt;Segmentation fault&gt;"));
    EXPECT_THAT(html, HasSubstr("25 of 26"));
}

TEST_F(Reports, TellOfBrokenPromises) {
    rows_[3].acknowledged_but_lost_qos1 = 3;
    EXPECT_THAT(report(), HasSubstr("<div class=\"tile bad\"><b>3</b><span>acknowledged messages"));
}

TEST_F(Reports, OfTenThousandRunsCanBeOpened) {
    std::string rates = "1";
    for (int rate = 2; rate <= 1250; ++rate) rates += ", " + std::to_string(rate);
    sweep_ = parse_sweep("repetitions = 4\n[axes]\nbrokers = [1, 3]\nrate = [" + rates + "]\n",
                         "try.toml");
    rows_.clear();
    for (const Cell& cell : sweep_.cells) rows_.push_back(made_up(cell));
    ASSERT_EQ(rows_.size(), 10'000U);
    for (std::size_t i = 0; i < 600; ++i) rows_[i].status = "no luck";
    const std::string html = report();
    EXPECT_LT(html.size(), 4U << 20U);
    for (const char* part :
         {"The first 500 of 2500 configurations; <code>summary.csv</code> has all",
          "<li>and 100 more, in <code>runs.csv</code></li>",
          "The first 24 of 1250 series are drawn", "a mark is their median"}) {
        EXPECT_NE(html.find(part), std::string::npos) << part;
    }
    const auto configurations = configurations_of(rows_);
    for (const Figure& figure : figures_of(configurations, sweep_.settings, folder_)) {
        for (const PlotPanel& panel : figure.plot.panels) {
            EXPECT_LE(panel.series.size(), most_series) << figure.title;
        }
    }
}

TEST(CrowdedPlots, HaveAMarkForManyRunsFromTheLeastToTheMost) {
    Plot plot{.name = "p",
              .panels = {{.title = "t", .x_label = "x", .y_label = "y", .series = {}},
                         {.title = "t", .x_label = "x", .y_label = "y", .series = {}}}};
    plot.panels[0].series = {{.label = "a", .points = {}}};
    plot.panels[1].series = {{.label = "a", .points = {{.x = 1, .y = 5}, {.x = 1, .y = 7}}}};
    for (int run = 0; run <= 1000; ++run) {
        for (const double x : {1.0, 3.0}) {
            plot.panels[0].series[0].points.push_back({.x = x, .y = x + run});
        }
    }
    plot.panels[0].series[0].points[0].low = -4;
    EXPECT_THAT(thin_out(plot), HasSubstr("a mark is their median"));
    const std::vector<PlotPoint>& drawn = plot.panels[0].series[0].points;
    ASSERT_EQ(drawn.size(), 2U);
    EXPECT_EQ(drawn[0].y, 501);
    EXPECT_EQ(drawn[0].low, -4);
    EXPECT_EQ(drawn[1].x, 3);
    EXPECT_EQ(drawn[1].low, 3);
    EXPECT_EQ(drawn[1].high, 1003);
    EXPECT_EQ(plot.panels[1].series[0].points.size(), 2U)
        << "each run is a mark where they are few";
    EXPECT_EQ(thin_out(plot), "");
}

TEST_F(Reports, OfNoRunAtAllAreStillReports) {
    rows_.clear();
    EXPECT_THAT(report(), HasSubstr("0 of 26 cells"));
}

TEST(Configurations, JoinRepetitionsAndSeedsAndKeepFailuresApart) {
    const Sweep sweep =
        parse_sweep("repetitions = 2\n[axes]\nbrokers = [2, 3]\nseed = [1, 2]\n", "try.toml");
    std::vector<RunRow> rows;
    for (const Cell& cell : sweep.cells) rows.push_back(made_up(cell));
    rows[0].status = "failed";
    const auto configurations = configurations_of(rows);
    ASSERT_EQ(configurations.size(), 2u);
    EXPECT_EQ(configurations[0].runs.size(), 3u);
    EXPECT_EQ(configurations[0].failed.size(), 1u);
    EXPECT_EQ(configurations[1].runs.size(), 4u);
    EXPECT_EQ(configurations[1].sum(&RunRow::published), 400);
    EXPECT_EQ(configurations[1].median(&RunRow::interbroker_octets_per_s), 40'000);
}

TEST(Labels, NameWhatVariesAndIsNotGiven) {
    const Sweep sweep =
        parse_sweep("[axes]\nbrokers = [2, 3]\nacks = [1, 2]\nrobots = [1, 5]\n", "try.toml");
    std::vector<RunRow> rows;
    for (const Cell& cell : sweep.cells) rows.push_back(made_up(cell));
    const auto configurations = configurations_of(rows);
    const std::vector<Axis> given = {Axis::brokers};
    const AxisLabels labels{configurations};
    EXPECT_EQ(labels.of(sweep.cells[0], given), "1 robot, acks 1");
    EXPECT_EQ(labels.of(sweep.cells.back(), given), "5 robots, acks 2");
}

TEST(SummaryTables, AlignTheirColumns) {
    const SummaryTable table{
        .head = {"a", "long head"}, .units = {"", "ms"}, .rows = {{"1", "\u2013"}, {"22", "3.5"}}};
    EXPECT_EQ(to_text(table),
              " a  long head\n"
              "           ms\n"
              "-------------\n"
              " 1          \u2013\n"
              "22        3.5\n");
}

TEST(SummaryTables, NeverRoundALossAway) {
    RunRow row;
    row.delivery_ratio = 0.999999;
    const std::vector<RunRow> rows = {row};
    EXPECT_THAT(to_text(summary_of(configurations_of(rows))), HasSubstr(">99.99"));
}

}  // namespace
}  // namespace romano::experiments::report_test
