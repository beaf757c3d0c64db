#include "romano/dtls/datagrams.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>

namespace romano::dtls {

struct Datagrams::Method {
    static Datagrams& owner(BIO* bio) { return *static_cast<Datagrams*>(BIO_get_data(bio)); }

    static int on_read(BIO* bio, char* to, int most) {
        BIO_clear_retry_flags(bio);
        Bytes& in = owner(bio).in_;
        if (in.empty()) {
            BIO_set_retry_read(bio);
            return -1;
        }
        const std::size_t size = std::min(in.size(), static_cast<std::size_t>(most));
        std::memcpy(to, in.data(), size);
        in = {};
        return static_cast<int>(size);
    }
    static int on_write(BIO* bio, const char* from, int size) {
        BIO_clear_retry_flags(bio);
        owner(bio).write({reinterpret_cast<const std::uint8_t*>(from),  //
                          static_cast<std::size_t>(size)});
        return size;
    }
    static long on_control(BIO*, int what, long, void*) {
        switch (what) {
            case BIO_CTRL_FLUSH:
            case BIO_CTRL_DGRAM_SET_PEEK_MODE:  // DTLSv1_listen reads once, and nobody before it
            case BIO_CTRL_DGRAM_SET_NEXT_TIMEOUT:
                return 1;
            case BIO_CTRL_DGRAM_QUERY_MTU:
                return mtu;
            default:
                return 0;
        }
    }
    static int on_create(BIO* bio) {
        BIO_set_init(bio, 1);
        return 1;
    }

    struct Free {
        void operator()(BIO_METHOD* method) const { BIO_meth_free(method); }
    };
    static std::unique_ptr<BIO_METHOD, Free> make() {
        std::unique_ptr<BIO_METHOD, Free> made{
            BIO_meth_new(BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "datagrams")};
        if (!made) throw std::bad_alloc();
        BIO_meth_set_read(made.get(), on_read);
        BIO_meth_set_write(made.get(), on_write);
        BIO_meth_set_ctrl(made.get(), on_control);
        BIO_meth_set_create(made.get(), on_create);
        return made;
    }
};

Datagrams::Ssl Datagrams::make_ssl(SSL_CTX* context) {
    static const auto method = Method::make();
    Ssl made{SSL_new(context)};
    BIO* bio = BIO_new(method.get());
    if (!made || bio == nullptr) {
        BIO_free(bio);
        throw std::bad_alloc();
    }
    BIO_set_data(bio, this);
    SSL_set_bio(made.get(), bio, bio);
    SSL_set_app_data(made.get(), this);
    SSL_set_mtu(made.get(), mtu);
    return made;
}

}  // namespace romano::dtls
