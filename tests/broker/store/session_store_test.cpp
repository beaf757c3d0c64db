// A file that applied a broker's log gives back what the broker held (design: replication; the
// file is a mirror that outlives its machine's processes).

#include "broker/store/session_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/broker/core/random_clients.h"
#include "tests/broker/core/scripted_client.h"
#include "tests/temporary_folder.h"

namespace romano::store::session_store_test {
namespace {

namespace fs = std::filesystem;
using namespace romano::broker;
using testing::HasSubstr;

std::string content(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

struct SessionStoreTest : testing::Test {
    tests::TemporaryFolder folder;
    std::string path = folder / "store.db";
};

/// A scripted broker whose log goes into a file.
class KeepingBroker {
public:
    explicit KeepingBroker(const StoreOptions& options, std::uint64_t incarnation = 1)
        : store(options), scripted(options_of(incarnation)) {
        store.begin_log(scripted.core_log());
    }

    /// Adopts all that the file holds.
    void adopts_what_is_stored() {
        auto state = store.load(scripted.core_log().broker);
        for (const auto& message : state.retained) scripted.core.put_retained(message);
        for (auto& image : state.sessions) {
            EXPECT_TRUE(scripted.core.adopt(scripted.now, image, {}, scripted.actions));
        }
        scripted.drain();
    }

    /// What happened since the last call, as one batch.
    bool keeps() {
        Actions batch;
        for (; kept_ < scripted.log.size(); ++kept_) {
            batch.push(Append{kept_ + 1, scripted.log[kept_]});
        }
        return store.keep(batch);
    }

    SessionStore store;
    ScriptedBroker scripted;

private:
    static BrokerOptions options_of(std::uint64_t incarnation) {
        BrokerOptions options = logging_options();
        options.log.incarnation = incarnation;
        return options;
    }
    std::size_t kept_ = 0;
};

/// `adopted`: by a core that has not heard the clients yet.
void expect_same(std::vector<SessionImage> home, std::vector<SessionImage> stored,
                 bool adopted = false) {
    ASSERT_EQ(home.size(), stored.size());
    for (std::size_t i = 0; i < home.size(); ++i) {
        SCOPED_TRACE(home[i].header.client_id);
        home[i].worked_through = stored[i].worked_through = {};  // there is one log only
        if (adopted) home[i].header.provisional = false;
        EXPECT_TRUE(same_state(home[i], stored[i]));
        for (std::size_t d = 0; d < home[i].deliveries.size(); ++d) {
            EXPECT_EQ(home[i].deliveries[d].message->payload,
                      stored[i].deliveries[d].message->payload);
            EXPECT_EQ(home[i].deliveries[d].message->topic, stored[i].deliveries[d].message->topic);
        }
    }
}

void expect_same(const std::vector<MessagePtr>& home, const std::vector<MessagePtr>& stored) {
    std::vector<MessagePtr> kept;  // deletions are remembered for peers only
    for (const auto& message : home) {
        if (!message->payload.empty()) kept.push_back(message);
    }
    ASSERT_EQ(kept.size(), stored.size());
    for (std::size_t i = 0; i < kept.size(); ++i) {
        EXPECT_EQ(kept[i]->topic, stored[i]->topic);
        EXPECT_EQ(kept[i]->payload, stored[i]->payload);
        EXPECT_EQ(kept[i]->position, stored[i]->position);
        EXPECT_EQ(kept[i]->published_at, stored[i]->published_at);
    }
}

class RandomWorkload : public SessionStoreTest,
                       public testing::WithParamInterface<std::uint64_t> {};

TEST_P(RandomWorkload, IsReadBackAsTheHomeHasItAndSurvivesRestarts) {
    SCOPED_TRACE("seed " + std::to_string(GetParam()));
    for (std::uint64_t life = 1; life <= 4 && !HasFailure(); ++life) {
        KeepingBroker broker({.path = path}, life);
        broker.adopts_what_is_stored();
        RandomClients clients{broker.scripted, GetParam() * 100 + life, 8, Peers::none};
        for (int step = 1; step <= 400 && !HasFailure(); ++step) {
            clients.step();
            ASSERT_TRUE(broker.keeps()) << broker.store.problem();
            if (step % 80 != 0) continue;
            const auto stored = broker.store.load(broker.scripted.core_log().broker);
            expect_same(broker.scripted.core.images(), stored.sessions, true);
            expect_same(broker.scripted.core.retained(), stored.retained);
        }
    }
}

TEST_P(RandomWorkload, LeavesNoMessageBehindThatNobodyWaitsFor) {
    std::size_t retained = 0;
    {
        KeepingBroker broker({.path = path});
        RandomClients clients{broker.scripted, GetParam(), 8, Peers::none};
        for (int step = 0; step < 600; ++step) clients.step();
        for (const auto& image : broker.scripted.core.images()) {
            broker.scripted.core.release(image.header.client_id, broker.scripted.actions);
        }
        broker.scripted.drain();
        ASSERT_TRUE(broker.keeps());
        retained = broker.store.load({}).retained.size();
    }
    Database file(path);
    EXPECT_EQ(file.number("SELECT COUNT(*) FROM messages"), static_cast<std::int64_t>(retained));
    EXPECT_EQ(file.number("SELECT COUNT(*) FROM deliveries"), 0);
    EXPECT_EQ(file.number("SELECT COUNT(*) FROM topics"), 0);
}

TEST_P(RandomWorkload, CanBeKeptAnewAsAWhole) {
    KeepingBroker broker({.path = path});
    RandomClients clients{broker.scripted, GetParam(), 8, Peers::none};
    for (int step = 0; step < 300; ++step) clients.step();
    ASSERT_TRUE(broker.store.keep_all(broker.scripted.core));  // nothing was kept before
    const auto stored = broker.store.load(broker.scripted.core_log().broker);
    expect_same(broker.scripted.core.images(), stored.sessions);
    expect_same(broker.scripted.core.retained(), stored.retained);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomWorkload, testing::Range<std::uint64_t>(1, 7));

TEST_F(SessionStoreTest, Qos2GoesOnWhereItStoppedAcrossARestart) {
    auto first = std::make_unique<KeepingBroker>(StoreOptions{.path = path}, 1);
    ScriptedClient robot(first->scripted, "robot");
    ScriptedClient publisher(first->scripted, "publisher");
    publisher.connects();
    robot.connects(false);
    robot.subscribes("cmd");
    publisher.publishes(publisher.registers("cmd"), "go", Qos::exactly_once);
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    ASSERT_TRUE(first->keeps());
    first.reset();

    KeepingBroker second({.path = path}, 2);
    second.adopts_what_is_stored();
    ScriptedClient same(second.scripted, "robot", robot.address.endpoint.port);
    const auto repeated = same.hears<Publish>();
    EXPECT_TRUE(repeated.dup);
    EXPECT_EQ(repeated.msg_id, msg_id);
    same.says(Pubrec{msg_id});
    EXPECT_EQ(same.hears<Pubrel>().msg_id, msg_id);
    same.says(Pubcomp{msg_id});
    same.hears_nothing();
}

// --- files that are not possible

std::string refusal(const StoreOptions& options) {
    try {
        const SessionStore store(options);
    } catch (const StoreRefusal& refused) {
        return refused.what();
    }
    return "accepted";
}

TEST_F(SessionStoreTest, RefusesAForeignFileAndLeavesItAlone) {
    std::ofstream(path) << "a diary, not a database; longer than the hundred octets of a header: "
                           "......................................................";
    const std::string before = content(path);
    EXPECT_THAT(refusal({.path = path}), HasSubstr("is no store of romano-broker"));
    EXPECT_EQ(content(path), before);
}

TEST_F(SessionStoreTest, RefusesAnotherProgramsDatabaseAndLeavesItAlone) {
    Database(path).execute("CREATE TABLE songs(title TEXT)");
    const std::string before = content(path);
    EXPECT_THAT(refusal({.path = path}), HasSubstr("is no store of romano-broker"));
    EXPECT_EQ(content(path), before);
}

TEST_F(SessionStoreTest, RefusesANewerSchemaAndLeavesItAlone) {
    { const SessionStore store({.path = path}); }
    Database(path).execute("PRAGMA journal_mode = DELETE; PRAGMA user_version = 7");
    const std::string before = content(path);
    EXPECT_THAT(refusal({.path = path}), HasSubstr("newer romano-broker (version 7"));
    EXPECT_EQ(content(path), before);
}

TEST_F(SessionStoreTest, BringsAnOlderSchemaUpToDate) {
    {
        KeepingBroker broker({.path = path});
        ScriptedClient{broker.scripted, "robot"}.connects(false);
        ASSERT_TRUE(broker.keeps());
    }
    Database(path).execute("ALTER TABLE sessions DROP COLUMN departed; PRAGMA user_version = 1");
    EXPECT_EQ(SessionStore({.path = path}).load({}).sessions.size(), 1U);
    EXPECT_EQ(Database(path).number("PRAGMA user_version"), 2);
}

TEST_F(SessionStoreTest, TellsWhenASessionWasLeftBehind) {
    KeepingBroker broker({.path = path});
    ScriptedClient robot(broker.scripted, "robot");
    ScriptedClient other(broker.scripted, "other");
    robot.connects(false);
    robot.says(Disconnect{});
    other.connects(false, 10);
    broker.scripted.waits(15s);
    ASSERT_TRUE(broker.keeps());
    const auto at_home = broker.scripted.core.images();
    const auto stored = broker.store.load({}).sessions;
    ASSERT_EQ(stored.size(), 2U);
    for (std::size_t i = 0; i < stored.size(); ++i) {
        EXPECT_NE(stored[i].header.departed, broker::HybridTime{});
        EXPECT_EQ(stored[i].header.departed, at_home[i].header.departed);
    }
}

TEST_F(SessionStoreTest, RefusesADamagedFileAndLeavesItAlone) {
    {
        KeepingBroker broker({.path = path});
        RandomClients clients{broker.scripted, 1, 8, Peers::none};
        for (int step = 0; step < 500; ++step) clients.step();
        ASSERT_TRUE(broker.keeps());
    }
    std::string octets = content(path);
    ASSERT_GT(octets.size(), 20'000U);
    for (std::size_t at = 4096; at < octets.size(); at += 97) octets[at] = '\x5a';
    std::ofstream(path, std::ios::binary) << octets;
    EXPECT_THAT(refusal({.path = path}), HasSubstr("is damaged"));
    EXPECT_EQ(content(path), octets);
}

TEST_F(SessionStoreTest, RefusesATruncatedFileAndLeavesItAlone) {
    { const SessionStore store({.path = path}); }
    fs::resize_file(path, 5000);
    const std::string before = content(path);
    EXPECT_THAT(refusal({.path = path}), HasSubstr("is damaged"));
    EXPECT_EQ(content(path), before);
}

TEST_F(SessionStoreTest, RefusesWhatIsNoFile) {
    EXPECT_THAT(refusal({.path = folder.path()}), HasSubstr("is no regular file"));
    EXPECT_THAT(refusal({.path = "/dev/full"}), HasSubstr("is no regular file"));
    EXPECT_THAT(refusal({.path = folder / "no" / "such.db"}),
                HasSubstr("cannot be opened for writing"));
}

TEST_F(SessionStoreTest, RefusesAFileThatIsReadOnlyToThisUser) {
    { const SessionStore store({.path = path}); }
    const std::string before = content(path);
    chmod(path.c_str(), 0444);
    chmod(folder.path().c_str(), 0755);
    const bool is_root = geteuid() == 0;
    ASSERT_EQ(seteuid(is_root ? 65534 : geteuid()), 0);
    const std::string why = refusal({.path = path});
    ASSERT_EQ(seteuid(is_root ? 0 : geteuid()), 0);
    EXPECT_THAT(why, HasSubstr("cannot be opened for writing"));
    EXPECT_EQ(content(path), before);
}

TEST_F(SessionStoreTest, SaysSoWhenThisUserMayNotEnterTheFolder) {
    const std::string closed = folder / "closed";
    fs::create_directory(closed);
    chmod(closed.c_str(), 0);
    chmod(folder.path().c_str(), 0755);
    const bool is_root = geteuid() == 0;
    ASSERT_EQ(seteuid(is_root ? 65534 : geteuid()), 0);
    const std::string why = refusal({.path = closed + "/store.db"});
    ASSERT_EQ(seteuid(is_root ? 0 : geteuid()), 0);
    chmod(closed.c_str(), 0700);
    EXPECT_THAT(why, HasSubstr("cannot be reached (Permission denied)"));
}

TEST_F(SessionStoreTest, RefusesAFileThatAnotherBrokerHas) {
    const SessionStore first({.path = path});
    EXPECT_THAT(refusal({.path = path}), HasSubstr("in use by another process"));
}

TEST_F(SessionStoreTest, RefusesAFileBeyondItsLimitAtTheStart) {
    EXPECT_THAT(refusal({.path = path, .most_octets = 8192}), HasSubstr("full"));
}

// --- while running

TEST_F(SessionStoreTest, KeepsAllOfABatchOrNothingWhenTheDiskIsFull) {
    KeepingBroker broker({.path = path, .most_octets = 256UL * 1024});
    ScriptedClient subscriber(broker.scripted, "subscriber");
    ScriptedClient publisher(broker.scripted, "publisher");
    subscriber.connects(false);
    subscriber.subscribes("log");
    subscriber.says(Disconnect{});
    subscriber.hears<Disconnect>();
    publisher.connects();
    const TopicId topic = publisher.registers("log");
    ASSERT_TRUE(broker.keeps());
    const std::string chunk(10'000, 'x');
    std::size_t kept = 0;
    for (;; ++kept) {
        ASSERT_LT(kept, 100U);
        publisher.publishes(topic, chunk, Qos::at_least_once);
        publisher.publishes(topic, "small", Qos::at_least_once);
        if (!broker.keeps()) break;
    }
    EXPECT_THAT(broker.store.problem(), HasSubstr("full"));
    const auto stored = broker.store.load({});
    EXPECT_EQ(stored.sessions.at(1).deliveries.size(), 2 * kept);

    // There is room again: the client fetches what waited for it.
    EXPECT_FALSE(broker.store.keep_all(broker.scripted.core));
    subscriber.connects(false);
    while (subscriber.unheard() > 0) {
        const auto message = *subscriber.next();
        if (const auto* registers = std::get_if<Register>(&message)) {
            subscriber.says(Regack{registers->topic_id, registers->msg_id, ReturnCode::accepted});
        } else if (const auto* publish = std::get_if<Publish>(&message)) {
            subscriber.says(Puback{publish->topic, publish->msg_id, ReturnCode::accepted});
        }
    }
    EXPECT_TRUE(broker.store.keep_all(broker.scripted.core)) << broker.store.problem();
    expect_same(broker.scripted.core.images(), broker.store.load({}).sessions);
}

TEST_F(SessionStoreTest, TellsTheLastIncarnationThatIsReferredTo) {
    KeepingBroker broker({.path = path}, 41);
    ScriptedClient publisher(broker.scripted, "publisher");
    publisher.connects();
    publisher.publishes(publisher.registers("pose"), "x", Qos::at_most_once, true);
    EXPECT_EQ(broker.store.last_incarnation(), 0U);
    ASSERT_TRUE(broker.keeps());
    EXPECT_EQ(broker.store.last_incarnation(), 41U);
}

}  // namespace
}  // namespace romano::store::session_store_test
