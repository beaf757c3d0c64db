#include "broker/https/tls.h"

#include <boost/asio/buffer.hpp>
#include <string>

#include "romano/keys/key_error.h"
#include "romano/keys/private_file.h"

namespace romano::https {
namespace {

namespace ssl = boost::asio::ssl;
using boost::system::error_code;

void set_versions(ssl::context& context) {
    SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_2_VERSION);
    SSL_CTX_set_cipher_list(context.native_handle(), "ECDHE+AESGCM:ECDHE+CHACHA20");
}

[[noreturn]] void refuse(const std::filesystem::path& file, const char* what,
                         const error_code& error) {
    throw keys::KeyError(file.string() + ": " + what + " (" + error.message() + ")");
}

}  // namespace

ssl::context server_tls(const std::filesystem::path& certificate) {
    const std::string text = keys::read_private_file(certificate);
    ssl::context context(ssl::context::tls_server);
    set_versions(context);
    SSL_CTX* const raw = context.native_handle();
    SSL_CTX_set_options(raw, SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION |
                                 SSL_OP_CIPHER_SERVER_PREFERENCE);
    SSL_CTX_set_num_tickets(raw, 0);
    SSL_CTX_set_session_cache_mode(raw, SSL_SESS_CACHE_OFF);
    SSL_CTX_set_mode(raw, SSL_MODE_RELEASE_BUFFERS);
    // OpenSSL would ask for it at the terminal.
    context.set_password_callback([](auto&&...) { return std::string{}; });
    error_code error;
    context.use_certificate_chain(boost::asio::buffer(text), error);
    if (error) refuse(certificate, "has no certificate that can be used", error);
    context.use_private_key(boost::asio::buffer(text), ssl::context::pem, error);
    if (error) {
        refuse(certificate,
               "has no private key of its certificate, without a password, beside it; a PEM file "
               "with both is needed",
               error);
    }
    return context;
}

ssl::context client_tls(const std::optional<std::filesystem::path>& authority) {
    ssl::context context(ssl::context::tls_client);
    set_versions(context);
    context.set_verify_mode(ssl::verify_peer);
    error_code error;
    if (authority) {
        context.load_verify_file(authority->string(), error);
    } else {
        context.set_default_verify_paths(error);
    }
    if (error) refuse(authority.value_or("the system's certificates"), "cannot be used", error);
    return context;
}

}  // namespace romano::https
