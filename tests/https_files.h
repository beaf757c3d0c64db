// What a server over HTTPS needs, made with the openssl program: a certificate of "r1" and
// 127.0.0.1 that vouches for itself, its private key, and a token.
#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/temporary_folder.h"

namespace romano::tests {

class HttpsFiles {
public:
    static constexpr const char* word = "an0ther-word_of.24~chars";

    HttpsFiles() {
        const std::string command =
            "openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj "
            "/CN=r1 -addext subjectAltName=DNS:r1,IP:127.0.0.1 -keyout '" +
            (folder_ / "key").string() + "' -out '" + authority().string() + "' 2>/dev/null";
        EXPECT_EQ(std::system(command.c_str()), 0) << command;
        write("https.pem", read(authority()) + read(folder_ / "key"));
        write("token", std::string{word} + "\n");
    }

    /// With its private key.
    [[nodiscard]] std::filesystem::path certificate() const { return folder_ / "https.pem"; }
    /// Without.
    [[nodiscard]] std::filesystem::path authority() const { return folder_ / "authority.pem"; }
    [[nodiscard]] std::filesystem::path token() const { return folder_ / "token"; }
    /// A file of mode 600.
    std::filesystem::path write(const std::string& name, const std::string& text) const {
        const std::filesystem::path file = folder_ / name;
        std::ofstream(file) << text;
        EXPECT_EQ(::chmod(file.c_str(), 0600), 0);
        return file;
    }
    [[nodiscard]] static std::string read(const std::filesystem::path& file) {
        std::ifstream stream(file);
        return {std::istreambuf_iterator<char>(stream), {}};
    }

private:
    TemporaryFolder folder_;
};

}  // namespace romano::tests
