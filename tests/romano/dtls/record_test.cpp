// Records of DTLS 1.2, octet by octet, and their protection against another implementation.

#include "romano/dtls/record/record.h"

#include <gtest/gtest.h>

#include <vector>

#include "romano/dtls/record/record_cipher.h"
#include "romano/protection/ccm.h"

namespace romano::dtls::record_test {
namespace {

using Octets = std::vector<std::uint8_t>;

const Octets datagram{23, 0xFE, 0xFD, 0, 1, 0, 0, 0, 0, 1, 2, 0, 3, 7, 8, 9, 22, 1};

TEST(DtlsRecord, HeaderAsInRfc6347Section41) {
    const auto record = first_record(datagram);
    ASSERT_TRUE(record);
    EXPECT_EQ(record->type, ContentType::application_data);
    EXPECT_EQ(record->version, version_1_2);
    EXPECT_EQ(record->epoch, 1);
    EXPECT_EQ(record->number, 0x102U);
    EXPECT_EQ(Octets(record->body.begin(), record->body.end()), (Octets{7, 8, 9}));
    EXPECT_EQ(record->whole.size(), 16U);
}

TEST(DtlsRecord, IsNoneWhenItIsCutOrOfAnotherType) {
    for (std::size_t size = 0; size < 16; ++size) {
        EXPECT_FALSE(first_record(Bytes{datagram}.first(size))) << size;
    }
    Octets other = datagram;
    for (const int type : {0, 19, 24, 25, 255}) {
        other[0] = static_cast<std::uint8_t>(type);
        EXPECT_FALSE(first_record(other)) << type;
    }
}

struct Sealed : testing::TestWithParam<Suite> {
    Octets seal(const Octets& message, std::uint64_t number = 5) {
        Octets out(message.size() + most_overhead);
        out.resize(
            cipher.seal(GetParam(), key, ContentType::application_data, number, message, out));
        return out;
    }
    std::optional<Octets> open(const Octets& octets) {
        const auto record = first_record(octets);
        Octets out(100);
        const auto opened =
            record ? cipher.open(GetParam(), key, *record, out) : std::optional<Opened>{};
        if (!opened) return std::nullopt;
        EXPECT_EQ(opened->type, ContentType::application_data);
        out.resize(opened->size);
        return out;
    }

    const WriteKey key{{1, 2, 3}, {4, 5, 6, 7}};
    RecordCipher cipher;
};
INSTANTIATE_TEST_SUITE_P(EverySuite, Sealed,
                         testing::Values(Suite::aes_128_ccm_8, Suite::aes_128_gcm));

TEST_P(Sealed, IsOpenedByItsKeyAlone) {
    const Octets message{2, 22};
    const Octets record = seal(message);
    EXPECT_EQ(record.size(), message.size() + overhead(GetParam()));
    EXPECT_EQ(open(record), message);
    const auto parsed = first_record(record);
    Octets out(100);
    EXPECT_FALSE(cipher.open(GetParam(), WriteKey{{1, 2}, {4, 5, 6, 7}}, *parsed, out));
    EXPECT_FALSE(cipher.open(GetParam(), WriteKey{{1, 2, 3}, {4, 5, 6, 8}}, *parsed, out));
}

TEST_P(Sealed, NoOctetCanBeChanged) {
    const Octets record = seal({9, 8, 7, 6, 5});
    for (std::size_t at = 0; at < record.size(); ++at) {
        for (int bit = 0; bit < 8; ++bit) {
            Octets changed = record;
            changed[at] ^= static_cast<std::uint8_t>(1 << bit);
            EXPECT_FALSE(open(changed)) << at;
        }
    }
}

TEST_P(Sealed, AnEmptyMessageIsNeitherSealedNorOpened) {
    EXPECT_TRUE(seal({}).empty());
    Octets empty(overhead(GetParam()));
    put_header(empty, ContentType::application_data, epoch_and_number(1, 7), {},
               empty.size() - header_octets);
    EXPECT_FALSE(open(empty));
}

TEST(DtlsRecord, CcmIsThatOfRfc3610WithTheNonceOfRfc6655) {
    const WriteKey key{{0xC0, 0xC1}, {1, 2, 3, 4}};
    const Octets message{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17};
    Octets record(message.size() + most_overhead);
    RecordCipher cipher;
    record.resize(cipher.seal(Suite::aes_128_ccm_8, key, ContentType::application_data,
                              0x010203040506, message, record));
    const Octets nonce{1, 2, 3, 4, 0, 1, 1, 2, 3, 4, 5, 6};
    const Octets readable{0, 1, 1, 2, 3, 4, 5, 6, 23, 0xFE, 0xFD, 0, 17};
    Octets expected = message;
    Octets tag(8);
    protection::Ccm(key.key, nonce).seal(readable, expected, tag);
    Octets whole{23, 0xFE, 0xFD, 0, 1, 1, 2, 3, 4, 5, 6, 0, 33, 0, 1, 1, 2, 3, 4, 5, 6};
    whole.insert(whole.end(), expected.begin(), expected.end());
    whole.insert(whole.end(), tag.begin(), tag.end());
    EXPECT_EQ(record, whole);
}

TEST(DtlsRecord, WithAConnectionIdItIsThatOfRfc9146Sections4And5) {
    const WriteKey key{{0xC0, 0xC1}, {1, 2, 3, 4}};
    const Octets message{2, 22};
    const Octets id{0xA1, 0xA2, 0xA3};
    Octets record(message.size() + most_overhead);
    RecordCipher cipher;
    record.resize(cipher.seal(Suite::aes_128_ccm_8, key, ContentType::application_data,
                              0x010203040506, message, record, id));
    const Octets nonce{1, 2, 3, 4, 0, 1, 1, 2, 3, 4, 5, 6};
    const Octets readable{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF,  // no number
                          25,   3,    25,   0xFE, 0xFD,                    //
                          0,    1,    1,    2,    3,    4,    5,    6,     // epoch and number
                          0xA1, 0xA2, 0xA3, 0,    3};                      // of the inner plaintext
    Octets inner{2, 22, 23};
    Octets tag(8);
    protection::Ccm(key.key, nonce).seal(readable, inner, tag);
    Octets whole{25,   0xFE, 0xFD, 0,  1, 1, 2, 3, 4, 5, 6, 0xA1,
                 0xA2, 0xA3, 0,    19, 0, 1, 1, 2, 3, 4, 5, 6};
    whole.insert(whole.end(), inner.begin(), inner.end());
    whole.insert(whole.end(), tag.begin(), tag.end());
    EXPECT_EQ(record, whole);
    const auto parsed = first_record(record, id.size());
    ASSERT_TRUE(parsed);
    EXPECT_EQ(Octets(parsed->id.begin(), parsed->id.end()), id);
    Octets out(10);
    const auto opened = cipher.open(Suite::aes_128_ccm_8, key, *parsed, out);
    ASSERT_TRUE(opened);
    EXPECT_EQ(opened->type, ContentType::application_data);
    EXPECT_EQ(Octets(out.begin(), out.begin() + 2), message);
    EXPECT_EQ(opened->size, 2U);
}

TEST(DtlsRecord, WithAConnectionIdEveryOctetCounts) {
    const WriteKey key{{1, 2, 3}, {4, 5, 6, 7}};
    const Octets id{1, 2, 3, 4, 5, 6, 7, 8};
    RecordCipher cipher;
    for (const Suite suite : {Suite::aes_128_ccm_8, Suite::aes_128_gcm}) {
        Octets record(100);
        record.resize(cipher.seal(suite, key, ContentType::alert, 7, Octets{1, 0}, record, id));
        EXPECT_EQ(record.size(), 2 + overhead(suite, id.size()));
        Octets out(100);
        for (std::size_t bit = 0; bit < 8 * record.size(); ++bit) {
            Octets changed = record;
            changed[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
            const auto parsed = first_record(changed, id.size());
            EXPECT_FALSE(parsed && cipher.open(suite, key, *parsed, out)) << bit;
        }
        for (std::size_t size = 0; size < record.size(); ++size) {
            EXPECT_FALSE(first_record(Bytes{record}.first(size), id.size())) << size;
        }
        EXPECT_EQ(cipher.open(suite, key, *first_record(record, id.size()), out)->type,
                  ContentType::alert);
    }
}

}  // namespace
}  // namespace romano::dtls::record_test
