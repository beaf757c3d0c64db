// A fleet's authority and what it signs, as OpenSSL judges it.

#include "romano/keys/authority.h"

#include <gtest/gtest.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <fstream>
#include <memory>
#include <string>

#include "romano/keys/key_error.h"
#include "romano/keys/key_folder.h"
#include "tests/temporary_folder.h"

namespace romano::keys::authority_test {
namespace {

using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;

Certificate certificate_in(const std::string& pem) {
    const std::unique_ptr<BIO, decltype(&BIO_free)> from{
        BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())), BIO_free};
    return {PEM_read_bio_X509(from.get(), nullptr, nullptr, nullptr), X509_free};
}

bool is_believed(const std::string& pem, const std::string& authority, int purpose) {
    const Certificate of_authority = certificate_in(authority);
    const Certificate judged = certificate_in(pem);
    const std::unique_ptr<X509_STORE, decltype(&X509_STORE_free)> store{X509_STORE_new(),
                                                                        X509_STORE_free};
    X509_STORE_add_cert(store.get(), of_authority.get());
    const std::unique_ptr<X509_STORE_CTX, decltype(&X509_STORE_CTX_free)> context{
        X509_STORE_CTX_new(), X509_STORE_CTX_free};
    X509_STORE_CTX_init(context.get(), store.get(), judged.get(), nullptr);
    X509_STORE_CTX_set_purpose(context.get(), purpose);
    return X509_verify_cert(context.get()) == 1;
}

struct AnAuthority : testing::Test {
    tests::TemporaryFolder folder;
};

TEST_F(AnAuthority, IsMadeOnceAndFoundAgain) {
    const std::string first = Authority(folder.path()).certificate();
    EXPECT_EQ(Authority(folder.path()).certificate(), first);
    std::filesystem::permissions(folder / authority_key_name, std::filesystem::perms::others_read,
                                 std::filesystem::perm_options::add);
    EXPECT_THROW(Authority{folder.path()}, KeyError);
}

TEST_F(AnAuthority, SignsWhoIsAClientAndWhoIsABrokerAndNobodyIsBoth) {
    const Authority authority(folder.path());
    const std::string client = authority.issue("anna/1", Holder::client, 1);
    const std::string broker = authority.issue("b1", Holder::broker, 1);
    const std::string& own = authority.certificate();
    EXPECT_TRUE(is_believed(client, own, X509_PURPOSE_SSL_CLIENT));
    EXPECT_FALSE(is_believed(client, own, X509_PURPOSE_SSL_SERVER)) << "no broker";
    EXPECT_TRUE(is_believed(broker, own, X509_PURPOSE_SSL_SERVER));
    EXPECT_FALSE(is_believed(broker, own, X509_PURPOSE_SSL_CLIENT));
    EXPECT_EQ(X509_check_host(certificate_in(broker).get(), "b1", 0, 0, nullptr), 1);
    tests::TemporaryFolder elsewhere;
    const Authority other(elsewhere.path());
    EXPECT_FALSE(is_believed(client, other.certificate(), X509_PURPOSE_SSL_CLIENT));
}

TEST_F(AnAuthority, OfAnotherCertificateIsRefused) {
    (void)Authority(folder.path());
    tests::TemporaryFolder elsewhere;
    (void)Authority(elsewhere.path());
    std::filesystem::copy_file(elsewhere / authority_name, folder / authority_name,
                               std::filesystem::copy_options::overwrite_existing);
    EXPECT_THROW(Authority{folder.path()}, KeyError);
}

TEST_F(AnAuthority, FlawsAreSaid) {
    const Authority authority(folder.path());
    EXPECT_FALSE(flaw_of(authority.issue("anna", Holder::client, 1)));
    EXPECT_EQ(
        flaw_of(authority.issue("anna", Holder::client, -1)),
        "has expired; `romano keys certificate` (a broker: `romano keys renew`) makes another one");
    EXPECT_EQ(flaw_of("anna"), "is no certificate");
}

TEST_F(AnAuthority, CertifiesWhoHasAKeyAndBrokersOnce) {
    KeyFolder fleet(folder / "fleet");
    fleet.add({.brokers = {"b1"}, .robots = {}, .operators = {"anna"}});
    const auto file = fleet.certify("anna/1", 2);
    EXPECT_EQ(file.filename(), "anna-1.pem");
    const auto text_of = [](const std::filesystem::path& path) {
        std::ifstream stream(path);
        return std::string{std::istreambuf_iterator<char>(stream), {}};
    };
    const std::string broker = text_of(fleet.broker_folder("b1") / broker_certificate_name);
    EXPECT_TRUE(is_believed(broker, text_of(fleet.broker_folder("b1") / authority_name),
                            X509_PURPOSE_SSL_SERVER));
    (void)fleet.certify("anna", 2);
    EXPECT_EQ(text_of(fleet.broker_folder("b1") / broker_certificate_name), broker);
    EXPECT_THROW((void)fleet.certify("carl", 2), KeyError);
    EXPECT_TRUE(problems_of(folder / "fleet").empty());
}

}  // namespace
}  // namespace romano::keys::authority_test
