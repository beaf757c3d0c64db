// What `romano keys` makes, and what it says of keys that are not as they should be.

#include "romano/keys/key_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "romano/keys/broker_record.h"
#include "romano/keys/key_error.h"
#include "tests/temporary_folder.h"

namespace romano::keys::key_folder_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct KeysOfAFleet : testing::Test {
    KeysOfAFleet() {
        fleet.add({.brokers = {"b1", "b2"}, .robots = {"abcd1234"}, .operators = {"anna"}});
    }
    std::string refusal(const Names& names) {
        try {
            fleet.add(names);
        } catch (const KeyError& error) {
            return error.what();
        }
        return "";
    }

    tests::TemporaryFolder folder;
    fs::path root = folder / "fleet";
    KeyFolder fleet{root};
    fs::path robot = root / "robots/abcd1234.key";
    fs::path table = root / "brokers/b1/clients.keys";
};

TEST_F(KeysOfAFleet, EachClientHasItsKeyAndEachBrokerAll) {
    const OwnKey own = read_own_key(robot);
    EXPECT_EQ(own.name, "abcd1234");
    EXPECT_EQ(own.bound, 0U);
    for (const char* broker : {"b1", "b2"}) {
        const ClientKeys keys = read_table(fleet.broker_folder(broker) / table_name);
        EXPECT_EQ(keys.size(), 2U);
        EXPECT_EQ(keys.at("abcd1234"), own.client);
        EXPECT_EQ(keys.at("anna").role, Role::person);
        EXPECT_NE(keys.at("anna").key, own.client.key);
    }
    EXPECT_THAT(problems_of(root), IsEmpty());
    EXPECT_THAT(problems_of(fleet.broker_folder("b1")), IsEmpty());
    EXPECT_THAT(problems_of(robot), IsEmpty());
}

TEST_F(KeysOfAFleet, WhoIsAddedLaterLeavesTheOthersTheirKeys) {
    const OwnKey before = read_own_key(robot);
    fleet.add({.brokers = {"b3"}, .robots = {"00000007"}, .operators = {}});
    EXPECT_EQ(read_own_key(robot).client, before.client);
    for (const char* broker : {"b1", "b3"}) {
        const ClientKeys keys = read_table(fleet.broker_folder(broker) / table_name);
        EXPECT_EQ(keys.size(), 3U);
        EXPECT_EQ(keys.at("abcd1234"), before.client);
    }
}

TEST_F(KeysOfAFleet, ANameHasOneKeyAndWrongNamesChangeNothing) {
    EXPECT_THAT(refusal({.brokers = {}, .robots = {"00000001", "abcd1234"}, .operators = {}}),
                HasSubstr("--robot 'abcd1234': has a key already"));
    EXPECT_THAT(refusal({.brokers = {}, .robots = {}, .operators = {"abcd1234"}}),
                HasSubstr("has a key already"));
    EXPECT_THAT(refusal({.brokers = {}, .robots = {"a/b"}, .operators = {}}),
                HasSubstr("--robot 'a/b': must be 1 to 20"));
    EXPECT_THAT(refusal({.brokers = {"../b"}, .robots = {}, .operators = {}}),
                HasSubstr("--broker '../b': must be"));
    EXPECT_EQ(fleet.clients().size(), 2U);
}

TEST_F(KeysOfAFleet, WhoIsWithdrawnIsInNoTableAndMayGetANewKey) {
    const OwnKey before = read_own_key(robot);
    fleet.withdraw({"abcd1234"});
    EXPECT_FALSE(read_table(table).contains("abcd1234"));
    EXPECT_THAT(problems_of(root), ElementsAre(HasSubstr("abcd1234 stands in no broker's table")));
    EXPECT_THROW(fleet.withdraw({"abcd1234"}), KeyError);
    fleet.add({.brokers = {}, .robots = {"abcd1234"}, .operators = {}});
    EXPECT_NE(read_own_key(robot).client.key, before.client.key);
    EXPECT_THAT(problems_of(root), IsEmpty());
}

TEST_F(KeysOfAFleet, EachBrokerHasAPlaceThatNoOtherHadOrWillHave) {
    KeyFolder places(folder / "places");
    places.add({.brokers = {"a", "b"}, .robots = {}, .operators = {}});
    const auto place = [&](const char* broker) {
        return read_given_place(places.broker_folder(broker) / place_name);
    };
    EXPECT_EQ(place("a"), 1U);
    EXPECT_EQ(place("b"), 2U);
    places.add({.brokers = {"a"}, .robots = {}, .operators = {}});
    EXPECT_EQ(place("a"), 1U) << "not taken yet";
    fs::remove(places.broker_folder("a") / place_name);
    fs::remove_all(places.broker_folder("b"));
    places.add({.brokers = {"a", "b"}, .robots = {}, .operators = {}});
    EXPECT_EQ(place("a"), 3U);
    EXPECT_EQ(place("b"), 4U);
    write_given_place(folder / "places" / "places.given", most_places);
    places.add({.brokers = {"c"}, .robots = {}, .operators = {}});
    EXPECT_FALSE(place("c")) << "all are given";
}

TEST_F(KeysOfAFleet, FilesThatOthersMayReadAreRefused) {
    EXPECT_EQ(fs::status(table).permissions(), fs::perms::owner_read | fs::perms::owner_write);
    fs::permissions(robot, fs::perms::group_read, fs::perm_options::add);
    EXPECT_THROW((void)read_own_key(robot), KeyError);
    EXPECT_THAT(problems_of(root), ElementsAre(HasSubstr("mode 640); say: chmod 600")));
}

TEST_F(KeysOfAFleet, WhatIsWrongIsSaid) {
    const auto say = [&](const fs::path& file, const std::string& text) {
        std::ofstream(file) << text;
        const auto problems = problems_of(root);
        return problems.empty() ? std::string{} : problems.front();
    };
    const std::string key(32, 'a');
    EXPECT_THAT(say(robot, "robot abcd1234 " + key + "aa 0\n"),
                HasSubstr("line 1: the key of abcd1234 must be 32 hexadecimal digits, and has 34"));
    EXPECT_THAT(say(robot, "robot abcd1234 " + std::string(32, 'x') + " 0\n"),
                HasSubstr("must be 32 hexadecimal digits"));
    EXPECT_THAT(say(robot, "\nrobot other " + key + " 0\n"), HasSubstr("is the key of other"));
    EXPECT_THAT(say(robot, "robot abcd1234 " + key + " 0\n"), HasSubstr("is another key"));
    EXPECT_THAT(say(robot, "robot abcd1234 " + key + "\n"), HasSubstr("lacks the bound"));
    EXPECT_THAT(say(robot, "robot abcd1234 " + key + " -1\n"), HasSubstr("is no number"));
    EXPECT_THAT(say(robot, "robot abcd1234 " + key + " 4294967295\n"),
                HasSubstr("all numbers of this key are used"));
    EXPECT_THAT(say(robot, "ghost abcd1234 " + key + " 0\n"), HasSubstr("'ghost' must be robot"));
    EXPECT_THAT(say(robot, "# nothing\n"), HasSubstr("holds no key"));
    fs::remove(robot);  // it is with its robot
    EXPECT_EQ(say(root / "robots/README", "mine"), "");
    EXPECT_THAT(say(table, "robot abcd1234 " + key + "\nrobot abcd1234 " + key + "\n"),
                HasSubstr("line 2: abcd1234 stands there twice"));
    EXPECT_THAT(say(table, "robot abcd1234 " + key + "\n"), HasSubstr("other clients or keys"));
    std::ofstream(table) << "robot a " << key << "\nrobot b " << key << '\n';
    EXPECT_THAT(problems_of(table.parent_path()), ElementsAre(HasSubstr("a and b have one key")));
    EXPECT_THAT(problems_of(folder / "nowhere"), ElementsAre(HasSubstr("is not there")));
}

}  // namespace
}  // namespace romano::keys::key_folder_test
