// The identity and the bound of a broker are stored together, and drawn anew together.

#include "romano/keys/broker_record.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "romano/keys/key_error.h"
#include "romano/keys/private_file.h"
#include "romano/protection/reserve.h"
#include "tests/temporary_folder.h"

namespace romano::keys::broker_record_test {
namespace {

TEST(BrokerRecord, IsFoundAsItWasWritten) {
    const tests::TemporaryFolder folder;
    const auto file = folder / "broker.numbers";
    BrokerRecord record = read_broker_record(file);
    EXPECT_EQ(record.bound, 0U);
    EXPECT_NE(read_broker_record(file).identity, record.identity) << "not stored, so drawn again";
    record.bound = protection::max_number - 1;
    write_broker_record(file, record);
    EXPECT_EQ(read_broker_record(file).identity, record.identity);
    EXPECT_EQ(read_broker_record(file).bound, record.bound);
}

TEST(BrokerRecord, ABrokerThatHasUsedAllNumbersIsAnotherOne) {
    const tests::TemporaryFolder folder;
    const auto file = folder / "broker.numbers";
    write_broker_record(file, {{1, 2, 3}, protection::max_number});
    EXPECT_EQ(read_broker_record(file).bound, 0U);
    EXPECT_NE(read_broker_record(file).identity, (protection::SenderId{1, 2, 3}));
}

TEST(BrokerRecord, KeepsItsPlaceAndOneOfBeforeHasNone) {
    const tests::TemporaryFolder folder;
    const auto file = folder / "broker.numbers";
    write_broker_record(file, {{1, 2, 3}, 8192, 127});
    EXPECT_EQ(read_broker_record(file).place, 127U);
    write_private_file(file, "identity 0102030405060708 bound 4096\n");
    EXPECT_EQ(read_broker_record(file).place, 0U);
    EXPECT_EQ(read_broker_record(file).bound, 4096U);
    write_broker_record(file, {{1, 2, 3}, protection::max_number, 5});
    EXPECT_EQ(read_broker_record(file).place, 0U) << "another broker has another place";
}

TEST(GivenPlace, IsReadAsItWasWrittenAndRefusedWhenItIsDamaged) {
    const tests::TemporaryFolder folder;
    const auto file = folder / "broker.place";
    EXPECT_FALSE(read_given_place(file));
    write_given_place(file, 127);
    EXPECT_EQ(read_given_place(file), 127U);
    for (const char* text : {"", "place 0\n", "place 128\n", "place 5 6\n", "5\n"}) {
        write_private_file(file, text);
        EXPECT_THROW((void)read_given_place(file), KeyError) << text;
    }
}

TEST(BrokerRecord, IsRefusedWhenItIsDamaged) {
    const tests::TemporaryFolder folder;
    const auto file = folder / "broker.numbers";
    write_broker_record(file, {{1, 2, 3}, 8192});
    for (const char* text :
         {"", "identity 0102", "identity 0102 bound x\n", "identity 0102030405060708 bound 5\nmore",
          "identity 0102030405060708 bound 5 place 128\n"}) {
        std::ofstream(file) << text;
        EXPECT_THROW((void)read_broker_record(file), KeyError) << text;
    }
}

}  // namespace
}  // namespace romano::keys::broker_record_test
