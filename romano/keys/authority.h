// Whom brokers and clients of DTLS, and brokers among themselves, believe by certificates (X.509,
// ECDSA over P-256): a fleet's authority, on the computer of its owner, and what it signs. A
// broker's certificate is for servers alone, its subject is of the organization "ROMANO brokers";
// a client's is for clients alone. So no client passes for a broker.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

struct evp_pkey_st;
struct x509_st;

namespace romano::keys {

inline constexpr const char* authority_name = "authority.pem";
inline constexpr const char* authority_key_name = "authority.key";
inline constexpr const char* broker_certificate_name = "broker.pem";  // and its private key

enum class Holder : std::uint8_t { broker, client };

/// A broker's subject as RFC 2253 writes it.
[[nodiscard]] std::string subject_of_broker(std::string_view name);

class Authority {
public:
    static constexpr int own_days = 20 * 365;

    /// The fleet's; made when it has none. Throws KeyError.
    explicit Authority(const std::filesystem::path& fleet);
    ~Authority();
    Authority(const Authority&) = delete;
    Authority& operator=(const Authority&) = delete;

    /// PEM.
    [[nodiscard]] const std::string& certificate() const { return text_; }
    /// A certificate with that common name, and its private key: PEM. Throws KeyError.
    [[nodiscard]] std::string issue(std::string_view name, Holder holder, int days) const;
    /// Signs a text as S/MIME (RFC 8551), clear and with the text's type, as DDS Security wants it.
    [[nodiscard]] std::string sign(const std::string& text) const;
    /// The list of revoked certificates (RFC 5280): the earlier one's, if there was one, and that
    /// of `revoked`, if it is given. PEM all. Throws KeyError.
    [[nodiscard]] std::string revocations(const std::optional<std::string>& earlier,
                                          const std::optional<std::string>& revoked) const;

private:
    struct Free {
        void operator()(x509_st* certificate) const;
        void operator()(evp_pkey_st* key) const;
    };

    std::unique_ptr<evp_pkey_st, Free> key_;
    std::unique_ptr<x509_st, Free> certificate_;
    std::string text_;
};

/// What is wrong with the first certificate of a PEM text: a sentence without the file's name.
[[nodiscard]] std::optional<std::string> flaw_of(const std::string& pem);
/// PEM, each with the certificate of interest first.
[[nodiscard]] bool is_signed_by(const std::string& pem, const std::string& authority);
[[nodiscard]] bool is_revoked(const std::string& pem, const std::string& revocations);

}  // namespace romano::keys
