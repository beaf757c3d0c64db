// Whom brokers and clients of DTLS believe by certificates (X.509, ECDSA over P-256): a fleet's
// authority, on the computer of its owner, and what it signs. A broker's certificate is for servers
// alone and a client's for clients alone, so that no client passes for a broker.
#pragma once

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

}  // namespace romano::keys
