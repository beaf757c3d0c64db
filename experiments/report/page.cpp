#include "experiments/report/page.h"

#include "experiments/report/summary_table.h"

namespace romano::experiments {
namespace {

constexpr const char* page_style = R"(
:root { color-scheme: light; --ink: #1d2330; --soft: #5b6475; --line: #dfe3ea; --good: #0b7a4b;
        --bad: #b3261e; }
body { font: 16px/1.55 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; color: var(--ink);
       max-width: 1180px; margin: 0 auto; padding: 2rem 1.5rem 4rem; background: #fff; }
h1 { font-size: 1.9rem; margin: 0 0 .2rem; } h2 { font-size: 1.3rem; margin: 2.6rem 0 .4rem; }
.sub { color: var(--soft); margin: 0 0 1.4rem; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(240px, 1fr)); gap: .8rem; }
.tile { border: 1px solid var(--line); border-radius: 10px; padding: .8rem 1rem; }
.tile b { display: block; font-size: 1.55rem; line-height: 1.25; }
.tile span { color: var(--soft); font-size: .88rem; line-height: 1.35; display: block; }
.good b { color: var(--good); } .bad b { color: var(--bad); }
figure { margin: .6rem 0 0; } .panels { display: flex; flex-wrap: wrap; align-items: flex-start; gap: .6rem; }
.panels svg { flex: 1 1 340px; max-width: 600px; min-width: 0; height: auto; }
figcaption { border-left: 3px solid var(--line); padding: .1rem 0 .1rem .9rem; max-width: 56rem; }
figcaption p { margin: .3rem 0; } .how { color: var(--soft); font-size: .92rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .32rem .45rem; text-align: right; border-bottom: 1px solid var(--line);
         white-space: nowrap; } th { vertical-align: bottom; } th small { color: var(--soft);
         font-weight: normal; } tbody tr:hover { background: #f5f7fa; }
.words td:last-child { white-space: normal; min-width: 16rem; } .wide + .wide { margin-top: 1.2rem; }
pre { background: #f5f7fa; border: 1px solid var(--line); border-radius: 8px; padding: .8rem 1rem;
      overflow-x: auto; font-size: .86rem; } code { font-size: .92em; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1.2rem; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; } code { overflow-wrap: anywhere; }
@media (max-width: 30rem) { body { padding: 1.2rem .8rem 3rem; } dl { grid-template-columns: 1fr; }
                            dd { margin-bottom: .4rem; } }
)";

}  // namespace

std::string page_begin(std::string_view title, std::string_view heading) {
    return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
           html_text(title) + ": " + std::string{project_title} + "</title>\n<style>" + page_style +
           "</style>\n</head>\n<body>\n<h1>" + html_text(heading) + "</h1>\n";
}

std::string panels_to_html(const Plot& plot, const std::filesystem::path& scripts) {
    std::string html = "<div class=\"panels\">\n";
    for (const Plot& panel : one_by_one(plot)) {
        html += draw(panel, scripts).value_or("<p><em>Not drawn: gnuplot is missing.</em></p>");
    }
    return html + "</div>\n";
}

std::string to_html(const Figure& figure, const std::filesystem::path& scripts) {
    return "<figure>\n" + panels_to_html(figure.plot, scripts) + "<figcaption><p>" + figure.shows +
           "</p><p class=\"how\">How it was measured: " + figure.measured +
           "</p></figcaption>\n</figure>\n";
}

}  // namespace romano::experiments
