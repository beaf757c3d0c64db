// From the raw runs to what they say: medians, spread, ratios to the reflector of the same
// repetition, and whether the targets hold.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace romano::bench {

/// One run of one contestant.
struct Row {
    std::string scenario;
    std::string contestant;
    unsigned repetition;
    double deliveries_per_s = 0;
    double p50_us = 0;
    double p99_us = 0;
    double cpu_us_a_message = 0;  // the contestant's, for each message published
    double generator_cpu_percent = 0;
    double lost = 0;
    double duplicates = 0;
    double resident_start_kib = 0;
    double resident_joined_kib = 0;  // and the two below: at the end, with all sessions
    double proportional_joined_kib = 0;
    double anonymous_joined_kib = 0;
    unsigned sessions = 0;
};

using Field = double Row::*;

/// The values of one field, by repetition.
[[nodiscard]] std::map<unsigned, double> values(const std::vector<Row>& rows,
                                                const std::string& scenario,
                                                const std::string& contestant, Field field);
[[nodiscard]] double median(std::vector<double> values);

struct Target {
    std::string what;
    std::string wanted;  // "at least 0.85"
    std::optional<double> measured;
    double low = 0;  // over the repetitions
    double high = 0;
    bool holds = false;
};

[[nodiscard]] std::vector<Target> judge(const std::vector<Row>& rows);

[[nodiscard]] std::string table_of(const std::vector<Row>& rows);
[[nodiscard]] std::string table_of(const std::vector<Target>& targets);
[[nodiscard]] std::string csv_of(const std::vector<Row>& rows);
[[nodiscard]] std::string json_of(const std::vector<Row>& rows, const std::vector<Target>& targets);

}  // namespace romano::bench
