#include "experiments/sweep/text_file.h"

#include <fstream>
#include <iterator>

#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

std::string read_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream stream(file, std::ios::binary | std::ios::trunc);
    if (!stream.write(text.data(), static_cast<std::streamsize>(text.size())).flush()) {
        throw SweepError("cannot write `" + file.string() + "`");
    }
}

void make_folder(const std::filesystem::path& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed) {
        throw SweepError("cannot make the folder `" + folder.string() + "`: " + failed.message());
    }
}

}  // namespace romano::experiments
