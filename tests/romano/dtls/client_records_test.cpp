// Which numbers a client's records have, and which of the broker's it takes.

#include "romano/dtls/record/client_records.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace romano::dtls::client_records_test {
namespace {

using Octets = std::vector<std::uint8_t>;

const Octets ping{2, 22};
constexpr auto data = ContentType::application_data;

/// A record of epoch 1 that OpenSSL wrote, as far as it can be read.
Octets written(std::uint64_t number, std::uint64_t nonce) {
    Octets record(header_octets + explicit_nonce_octets + 20);
    put_header(record, ContentType::handshake, epoch_and_number(1, number), {},
               record.size() - header_octets);
    put_be64(record, header_octets, nonce);
    return record;
}
Octets written(std::uint64_t number) {
    return written(number, epoch_and_number(1, number));
}
Octets operator+(Octets left, const Octets& right) {
    left.insert(left.end(), right.begin(), right.end());
    return left;
}

TEST(NumberAbove, IsAboveAllRecordsOfEpochOneInADatagram) {
    EXPECT_EQ(number_above(written(0)), 1U);
    EXPECT_EQ(number_above(written(7) + written(5)), 8U);
    Octets hello = written(9);
    hello[4] = 0;  // epoch 0: in the clear
    EXPECT_EQ(number_above(hello), 0U);
    EXPECT_EQ(number_above(hello + written(2)), 3U);
}

TEST(NumberAbove, IsAboveNoncesThatWereDrawnAmongOurs) {
    EXPECT_EQ(number_above(written(0, epoch_and_number(1, 500))), 501U);
    EXPECT_EQ(number_above(written(0, epoch_and_number(2, 500))), 1U) << "we have none of those";
    EXPECT_GT(number_above(written(0, epoch_and_number(1, most_number))), most_number);
}

TEST(NumberAbove, IsNoneOfWhatIsCut) {
    const Octets record = written(3);
    for (std::size_t size = 0; size < record.size(); ++size) {
        EXPECT_EQ(number_above(Bytes{record}.first(size)), 0U) << size;
    }
    Octets without_nonce = written(3);
    without_nonce.resize(header_octets);
    put_be16(without_nonce, 11, 0);
    EXPECT_EQ(number_above(without_nonce), 4U);
}

struct AClientsRecords : testing::TestWithParam<Suite> {
    /// Of the broker.
    Octets answer(std::uint64_t number, const Octets& message, ContentType type = data) {
        Octets out(message.size() + most_overhead);
        out.resize(cipher.seal(keys.suite, keys.server, type, number, message, out));
        return out;
    }
    static bool takes(ClientRecords& records, const Octets& datagram) {
        return records.open(*first_record(datagram)).has_value();
    }

    const RecordKeys keys{GetParam(), {{1}, {2}}, {{3}, {4}}};
    RecordCipher cipher;
};
INSTANTIATE_TEST_SUITE_P(EverySuite, AClientsRecords,
                         testing::Values(Suite::aes_128_ccm_8, Suite::aes_128_gcm));

TEST_P(AClientsRecords, AreNumberedOneByOneFromTheFirstWhateverBecomesOfThem) {
    ClientRecords records{keys, {}, 3};
    std::set<std::uint64_t> numbers;
    for (int n = 0; n < 50; ++n) {
        const auto type = n % 3 == 0 ? ContentType::alert : data;
        const Bytes sealed = records.seal(type, ping);
        ASSERT_FALSE(sealed.empty());
        const Record record = *first_record(sealed);
        EXPECT_EQ(record.type, type);
        EXPECT_EQ(be64(record.body, 0), epoch_and_number(1, record.number)) << "the nonce";
        EXPECT_TRUE(numbers.insert(record.number).second) << record.number;
        EXPECT_TRUE(records.seal(data, Octets(most_message + 1)).empty());
    }
    EXPECT_EQ(*numbers.begin(), 3U);
}

TEST_P(AClientsRecords, EndWhereTheirNumbersWouldWrap) {
    ClientRecords records{keys, {}, most_number - 1};
    EXPECT_FALSE(records.seal(data, ping).empty());
    EXPECT_FALSE(records.is_used_up());
    EXPECT_EQ(first_record(records.seal(data, ping))->number, most_number);
    EXPECT_TRUE(records.is_used_up());
    EXPECT_TRUE(records.seal(data, ping).empty());
}

TEST_P(AClientsRecords, HaveTheBrokersIdWhenItGaveOne) {
    const Octets id{9, 8, 7};
    ClientRecords records{keys, *ConnectionId::of(id), 1};
    EXPECT_TRUE(records.has_brokers_id());
    const auto record = first_record(records.seal(data, ping), id.size());
    ASSERT_TRUE(record);
    EXPECT_EQ(Octets(record->id.begin(), record->id.end()), id);
    Octets opened(100);
    const auto message = cipher.open(keys.suite, keys.client, *record, opened);
    ASSERT_TRUE(message);
    EXPECT_EQ(message->type, data);
    opened.resize(message->size);
    EXPECT_EQ(opened, ping);
}

TEST_P(AClientsRecords, OfTheBrokerAreTakenOnceInTheWindow) {
    ClientRecords records{keys, {}, 1};
    constexpr std::uint64_t turn = std::uint64_t{1} << 38U;
    EXPECT_TRUE(takes(records, answer(1, ping)));
    EXPECT_TRUE(takes(records, answer(turn + 100, ping)));
    EXPECT_FALSE(takes(records, answer(turn + 100, ping)));
    EXPECT_TRUE(takes(records, answer(turn + 99, ping))) << "late";
    EXPECT_FALSE(takes(records, answer(turn + 99, ping)));
    EXPECT_FALSE(takes(records, answer(turn, ping))) << "too late";
    EXPECT_FALSE(takes(records, answer(2, ping)));
}

TEST_P(AClientsRecords, ThatAreForgedOrSentBackAreNotTakenAndDoNotMoveTheWindow) {
    ClientRecords records{keys, {}, 1};
    Octets forged = answer(most_number - 1, ping);
    forged.back() ^= 1U;
    EXPECT_FALSE(takes(records, forged));
    const Bytes own = records.seal(data, ping);
    EXPECT_FALSE(takes(records, Octets(own.begin(), own.end())));
    EXPECT_TRUE(takes(records, answer(0, ping)));
}

}  // namespace
}  // namespace romano::dtls::client_records_test
