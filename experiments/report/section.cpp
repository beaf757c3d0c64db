#include "experiments/report/section.h"

#include <fstream>
#include <stdexcept>

#include "experiments/report/page.h"

namespace romano::experiments {
namespace {

void write(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file);
    if (!(out << text).flush()) throw std::runtime_error("cannot write `" + file.string() + "`");
}

}  // namespace

std::string to_text(const std::vector<Section>& sections) {
    std::string text;
    for (const Section& section : sections) {
        text += "== " + section.title + "\n" + section.words + "\n\n";
        for (const SectionTable& each : section.tables) {
            if (!each.is_only_csv) text += to_text(each.table) + '\n';
        }
    }
    return text;
}

void write_report(const ReportHead& head, const std::vector<Section>& sections,
                  const std::filesystem::path& folder) {
    std::string html = page_begin(head.title, head.heading);
    for (const Section& section : sections) {
        html +=
            "<h2>" + html_text(section.title) + "</h2>\n<p>" + html_text(section.words) + "</p>\n";
        if (const auto svg = draw(section.figure, folder)) {
            write(folder / (section.figure.name + ".svg"), *svg + '\n');
            html += panels_to_html(section.figure, folder);
        }
        for (const auto& [name, table, is_only_csv] : section.tables) {
            write(folder / (name + ".csv"), to_csv(table));
            if (!is_only_csv) html += "<div class=\"wide words\">\n" + to_html(table) + "</div>\n";
        }
    }
    write(folder / "report.html", html.append(page_end));
}

}  // namespace romano::experiments
