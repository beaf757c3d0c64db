#include "experiments/sweep/results_folder.h"

#include <set>
#include <span>
#include <string_view>

#include "experiments/sweep/text_file.h"

namespace romano::experiments {
namespace {

namespace fs = std::filesystem;

constexpr const char* sweep_copy = "sweep.toml";

bool means(const std::string& text, const Sweep& sweep) {
    try {
        return is_same_experiment(parse_sweep(text, sweep_copy), sweep);
    } catch (const SweepError&) {  // of a version that had other settings
        return false;
    }
}

using Rows = std::map<Cell, RunRow>;

/// Without a last row that was cut off. Throws SweepError on columns of another version.
Rows read_rows(const fs::path& file, const char* advice) {
    Rows runs;
    const auto rows = parse_csv(read_text(file));
    if (rows.empty()) return runs;
    if (rows.front() != run_columns()) {
        throw SweepError("`" + file.string() + "` has the columns of another version" + advice);
    }
    for (const CsvRow& fields : std::span{rows}.subspan(1)) {
        if (auto row = run_from_csv(fields)) runs.insert_or_assign(row->cell, *row);
    }
    return runs;
}

std::vector<RunRow> in_order(const Rows& rows) {
    std::vector<RunRow> ordered;
    ordered.reserve(rows.size());
    for (const auto& [cell, row] : rows) ordered.push_back(row);
    return ordered;
}

/// "cell-0012" of "cell-0012.csv" and "cell-0012-b1.txt".
std::string_view stem_in(std::string_view name) {
    constexpr std::string_view word = "cell-";
    if (!name.starts_with(word)) return {};
    return name.substr(0, name.find_first_not_of("0123456789", word.size()));
}

const CsvRow& sample_columns() {
    static const CsvRow columns = {"publisher", "sequence", "stream",
                                   "qos",       "receiver", "sent_s",
                                   "delay_ms",  "copies",   "acknowledged_after_ms"};
    return columns;
}

const CsvRow& memory_columns() {
    static const CsvRow columns = {"at_s", "broker", "rss_mib"};
    return columns;
}

}  // namespace

std::string file_stem(const Cell& cell) {
    const std::string digits = std::to_string(cell.number);
    return "cell-" + std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits;
}

ResultsFolder::ResultsFolder(fs::path folder, const Sweep& sweep, bool fresh)
    : folder_(std::move(folder)) {
    std::error_code failed;
    fs::create_directories(folder_, failed);
    if (!failed) claim_ = Claim::on_folder(folder_);
    if (!failed && !claim_) {
        throw SweepError("another sweep is writing into `" + folder_.string() +
                         "`; wait for its end, or set another `output`");
    }
    if (fresh) {
        for (const char* ours : {sweep_copy, "runs.csv", "summary.csv", "samples", "traces",
                                 "manifest.json", "report.html"}) {
            fs::remove_all(folder_ / ours, failed);
        }
    }
    if (!failed) fs::create_directories(folder_ / "samples", failed);
    if (!failed) fs::create_directories(folder_ / "traces", failed);
    if (failed) {
        throw SweepError("cannot make the results folder `" + folder_.string() +
                         "`: " + failed.message());
    }
    if (fs::exists(folder_ / sweep_copy)) {
        if (!means(read_text(folder_ / sweep_copy), sweep)) {
            throw SweepError("the sweep file means another experiment since `" + folder_.string() +
                             "` was begun; use --fresh to start anew, or set another `output`");
        }
    }
    write_text(folder_ / sweep_copy, sweep.text);
    rows_ = read_rows(folder_ / "runs.csv", "; use --fresh to start anew");
    set_in_order();
}

void ResultsFolder::set_in_order() {
    std::string whole = csv_line(run_columns());
    for (const auto& [cell, row] : rows_) whole += csv_line(to_csv(row));
    // Under another name first: whoever reads, and whoever goes on after a power cut, finds a
    // whole.
    write_text(folder_ / "runs.csv.new", whole);
    fs::rename(folder_ / "runs.csv.new", folder_ / "runs.csv");
    runs_ = std::ofstream(folder_ / "runs.csv", std::ios::binary | std::ios::app);
}

std::vector<RunRow> ResultsFolder::rows() const {
    return in_order(rows_);
}

const RunRow* ResultsFolder::row_of(const Cell& cell) const {
    const auto found = rows_.find(cell);
    return found == rows_.end() ? nullptr : &found->second;
}

void ResultsFolder::put(const RunRow& row) {
    rows_.insert_or_assign(row.cell, row);
    if (!(runs_ << csv_line(to_csv(row))).flush()) {
        throw SweepError("cannot write `" + (folder_ / "runs.csv").string() + "`");
    }
}

void ResultsFolder::take(std::span<const RunRow> rows, const fs::path& from) {
    std::set<std::string, std::less<>> stems;
    for (const RunRow& row : rows) stems.insert(file_stem(row.cell));
    for (const char* part : {"samples", "traces"}) {
        std::error_code none;
        for (const auto& file : fs::directory_iterator(from / part, none)) {
            const std::string name = file.path().filename().string();
            if (!stems.contains(stem_in(name))) continue;
            std::error_code failed;
            fs::copy_file(file.path(), folder_ / part / name, fs::copy_options::overwrite_existing,
                          failed);
            if (failed) {
                throw SweepError("cannot copy `" + file.path().string() + "`: " + failed.message());
            }
        }
    }
    for (const RunRow& row : rows) put(row);
}

Results read_results(const fs::path& folder) {
    const fs::path copy = folder / sweep_copy;
    if (!fs::exists(copy) || !fs::exists(folder / "runs.csv")) {
        throw SweepError("`" + folder.string() + "` holds no results of a sweep (" + sweep_copy +
                         " and runs.csv are missing)");
    }
    return {.sweep = parse_sweep(read_text(copy), copy.string()),
            .rows = in_order(read_rows(folder / "runs.csv", ""))};
}

void ResultsFolder::write_samples(const Cell& cell, const DeliveryAccount& account) const {
    std::string text = csv_line(sample_columns());
    for (const auto& messages : account.by_publisher()) {
        for (const PublishedMessage& message : messages) {
            const auto& acknowledged = message.acknowledged_at_s;
            for (const Delivery& delivery : message.deliveries) {
                const auto since_sent_ms = [&message](const std::optional<double>& at_s) {
                    return at_s ? csv_number((*at_s - message.sent_at_s) * 1e3) : std::string{};
                };
                text +=
                    csv_line({std::to_string(message.publisher), std::to_string(message.sequence),
                              message.stream == Stream::group ? "group" : "one-to-one",
                              std::to_string(message.qos), std::to_string(delivery.receiver),
                              csv_number(message.sent_at_s), since_sent_ms(delivery.first_at_s),
                              std::to_string(delivery.copies), since_sent_ms(acknowledged)});
            }
        }
    }
    write_text(folder_ / "samples" / (file_stem(cell) + ".csv"), text);
}

void ResultsFolder::write_memory(const Cell& cell, const std::vector<MemorySample>& memory) const {
    std::string text = csv_line(memory_columns());
    for (const auto& [at_s, broker, rss_mib] : memory) {
        text += csv_line({csv_number(at_s), broker, csv_number(rss_mib)});
    }
    write_text(folder_ / "samples" / (file_stem(cell) + "-memory.csv"), text);
}

fs::path ResultsFolder::trace_file(const Cell& cell, const std::string& name) const {
    return folder_ / "traces" / (file_stem(cell) + "-" + name + ".txt");
}

std::vector<Sample> read_samples(const fs::path& folder, const Cell& cell) {
    const auto rows = parse_csv(read_text(folder / "samples" / (file_stem(cell) + ".csv")));
    std::vector<Sample> samples;
    if (rows.empty() || rows.front() != sample_columns()) return samples;
    for (const CsvRow& fields : std::span{rows}.subspan(1)) {
        if (fields.size() != sample_columns().size()) continue;
        samples.push_back({.publisher = static_cast<RobotNumber>(std::stoul(fields[0])),
                           .sequence = static_cast<std::uint32_t>(std::stoul(fields[1])),
                           .stream = fields[2] == "group" ? Stream::group : Stream::one_to_one,
                           .qos = static_cast<std::uint8_t>(std::stoul(fields[3])),
                           .receiver = static_cast<RobotNumber>(std::stoul(fields[4])),
                           .sent_s = parse_csv_number(fields[5]).value_or(0),
                           .delay_ms = parse_csv_number(fields[6])});
    }
    return samples;
}

std::vector<MemorySample> read_memory(const fs::path& folder, const Cell& cell) {
    const auto rows = parse_csv(read_text(folder / "samples" / (file_stem(cell) + "-memory.csv")));
    std::vector<MemorySample> memory;
    if (rows.empty() || rows.front() != memory_columns()) return memory;
    for (const CsvRow& fields : std::span{rows}.subspan(1)) {
        if (fields.size() != memory_columns().size()) continue;
        memory.push_back({parse_csv_number(fields[0]).value_or(0), fields[1],
                          parse_csv_number(fields[2]).value_or(0)});
    }
    return memory;
}

}  // namespace romano::experiments
