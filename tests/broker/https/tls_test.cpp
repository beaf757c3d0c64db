// What a server or a client is told when its files are no good.

#include "broker/https/tls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>

#include "romano/keys/key_error.h"
#include "tests/https_files.h"

namespace romano::https::tls_test {
namespace {

using testing::HasSubstr;
using tests::HttpsFiles;

template <typename Make>
std::string refusal(Make&& make) {
    try {
        (void)make();
    } catch (const keys::KeyError& error) {
        return error.what();
    }
    return {};
}

struct TlsFiles : testing::Test {
    HttpsFiles files;
    std::string server_refusal(const std::string& text) {
        const auto file = files.write("other.pem", text);
        const std::string said = refusal([&] { return server_tls(file); });
        EXPECT_THAT(said, HasSubstr(file.string()));
        return said;
    }
};

TEST_F(TlsFiles, OfAServerHoldACertificateAndItsPrivateKeyInAnyOrder) {
    EXPECT_EQ(refusal([&] { return server_tls(files.certificate()); }), "");
    const std::string both = HttpsFiles::read(files.certificate());
    const std::string certificate = HttpsFiles::read(files.authority());
    const auto turned = files.write("turned.pem", both.substr(certificate.size()) + certificate);
    EXPECT_EQ(refusal([&] { return server_tls(turned); }), "");
}

TEST_F(TlsFiles, OfAServerAreRefusedInASentence) {
    const std::string certificate = HttpsFiles::read(files.authority());
    EXPECT_THAT(server_refusal(""), HasSubstr("has no certificate"));
    EXPECT_THAT(server_refusal("nonsense"), HasSubstr("has no certificate"));
    EXPECT_THAT(server_refusal(certificate), HasSubstr("has no private key"));
    const HttpsFiles others;
    const std::string key =
        HttpsFiles::read(others.certificate()).substr(HttpsFiles::read(others.authority()).size());
    EXPECT_THAT(server_refusal(certificate + key), HasSubstr("has no private key of its"));
    ASSERT_EQ(::chmod(files.certificate().c_str(), 0640), 0);
    EXPECT_THAT(refusal([&] { return server_tls(files.certificate()); }), HasSubstr("chmod 600"));
    EXPECT_THAT(refusal([&] { return server_tls("/nowhere/https.pem"); }), HasSubstr("No such"));
}

TEST_F(TlsFiles, OfAServerMayHaveNoPasswordThatSomebodyWouldHaveToType) {
    const auto locked = files.write("locked", "");
    const std::string command = "openssl pkey -in '" + files.certificate().string() +
                                "' -aes256 -passout pass:word -out '" + locked.string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);
    EXPECT_THAT(server_refusal(HttpsFiles::read(files.authority()) + HttpsFiles::read(locked)),
                HasSubstr("without a password"));
}

TEST_F(TlsFiles, OfAClientNameWhomItBelieves) {
    EXPECT_EQ(refusal([&] { return client_tls(files.authority()); }), "");
    EXPECT_EQ(refusal([&] { return client_tls(std::nullopt); }), "");
    EXPECT_THAT(refusal([&] { return client_tls("/nowhere/ca.pem"); }),
                HasSubstr("/nowhere/ca.pem: cannot be used"));
    EXPECT_NE(refusal([&] { return client_tls(files.write("no.pem", "nonsense")); }), "");
}

}  // namespace
}  // namespace romano::https::tls_test
