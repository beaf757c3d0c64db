#include "experiments/sweep/progress_bar.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace romano::experiments {
namespace {

constexpr std::size_t bar_width = 24;

std::size_t columns_of(std::FILE* out) {
    winsize size{};
    return ::ioctl(::fileno(out), TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

ProgressBar::ProgressBar(std::FILE* out, std::size_t total, std::size_t done)
    : out_(out),
      terminal_(::isatty(::fileno(out)) == 1),
      total_(total),
      done_(done),
      done_before_(done) {}

ProgressBar::~ProgressBar() {
    erase();
}

void ProgressBar::show(double share, std::string_view doing) {
    if (!terminal_) return;
    const auto now = Clock::now();
    if (now - shown_ < std::chrono::milliseconds{100}) return;
    shown_ = now;
    const double over = static_cast<double>(done_ - done_before_) + std::clamp(share, 0.0, 1.0);
    const double all = static_cast<double>(total_ - done_before_);
    std::string text = bar_of((static_cast<double>(done_before_) + over) /
                                  std::max(static_cast<double>(total_), 1.0),
                              bar_width) +
                       " " + std::to_string(done_) + "/" + std::to_string(total_);
    if (over > 0.05) {
        const std::chrono::duration<double> spent = now - started_;
        const auto left = std::chrono::seconds{std::lround(spent.count() / over * (all - over))};
        text += ", " + duration_text(left) + " left";
    }
    text += "  ";
    text += doing;
    text.resize(std::min(text.size(), columns_of(out_) - 1));
    std::fprintf(out_, "\r\x1b[K%s", text.c_str());
    std::fflush(out_);
}

void ProgressBar::finish_cell(std::string_view line) {
    ++done_;
    erase();
    std::fprintf(out_, "[%zu/%zu] %.*s\n", done_, total_, static_cast<int>(line.size()),
                 line.data());
    std::fflush(out_);
    shown_ = {};
}

void ProgressBar::erase() {
    if (terminal_) std::fputs("\r\x1b[K", out_);
    std::fflush(out_);
}

std::string bar_of(double share, std::size_t width) {
    const auto full = static_cast<std::size_t>(
        std::lround(std::clamp(share, 0.0, 1.0) * static_cast<double>(width)));
    return "[" + std::string(full, '#') + std::string(width - full, '.') + "]";
}

std::string duration_text(std::chrono::seconds duration) {
    const auto s = duration.count();
    std::array<char, 48> text{};
    if (s < 60) {
        std::snprintf(text.data(), text.size(), "%lld s", static_cast<long long>(s));
    } else if (s < 3600) {
        std::snprintf(text.data(), text.size(), "%lld min %02lld s", static_cast<long long>(s / 60),
                      static_cast<long long>(s % 60));
    } else {
        std::snprintf(text.data(), text.size(), "%lld h %02lld min",
                      static_cast<long long>(s / 3600), static_cast<long long>(s / 60 % 60));
    }
    return text.data();
}

}  // namespace romano::experiments
