// MCAP, https://mcap.dev/spec: what is written is read; whatever was cut or spoilt is no harm.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "experiments/mcap/compression.h"
#include "tests/experiments/mcap/files_in_memory.h"

namespace romano::experiments::mcap {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr Timestamp second = 1'000'000'000;

TEST(Mcap, ARecordIsAnOpcodeALengthAndLittleEndianFields) {
    Octets out;
    write_channel(out, {.id = 0x0102,
                        .schema_id = 3,
                        .topic = "a",
                        .message_encoding = "json",
                        .metadata = {{"k", "v"}}});
    EXPECT_THAT(
        out, ElementsAre(0x04, 31, 0, 0, 0, 0, 0, 0, 0, 0x02, 0x01, 3, 0, 1, 0, 0, 0, 'a', 4, 0, 0,
                         0, 'j', 's', 'o', 'n', 10, 0, 0, 0, 1, 0, 0, 0, 'k', 1, 0, 0, 0, 'v'));
}

TEST(Mcap, MessagesComeBackInTheOrderOfTheirTimesWithTheirTopics) {
    FileInMemory file = a_file(3);
    Reader reader{file};
    ASSERT_TRUE(reader.is_mcap());
    EXPECT_TRUE(reader.is_finished());
    EXPECT_EQ(reader.start(), 1 * second);
    EXPECT_EQ(reader.end(), 30 * second);
    for (int number = 0; number < 30; ++number) {
        const auto told = reader.next();
        ASSERT_TRUE(told);
        EXPECT_EQ(as_text(told->data), std::to_string(number));
        EXPECT_EQ(told->channel->topic, "t" + std::to_string(number % 3));
        EXPECT_EQ(told->channel->metadata_of("topic_type"), "name");
        EXPECT_EQ(told->time, second * static_cast<Timestamp>(number + 1));
    }
    EXPECT_FALSE(reader.next());
}

TEST(Mcap, TheSummaryBeginsWhereTheFooterSaysAndHasItsChecksum) {
    FileInMemory file = a_file(3);
    const std::size_t footer = file.octets.size() - magic.size() - 20;
    FieldReader fields{Bytes{file.octets}.subspan(footer)};
    const std::uint64_t start = fields.u64();
    const std::uint64_t offsets = fields.u64();
    const std::uint32_t crc = fields.u32();
    ASSERT_LT(start, offsets);
    ASSERT_LT(offsets, footer);
    EXPECT_EQ(file.octets[static_cast<std::size_t>(start)], 0x03);    // a schema
    EXPECT_EQ(file.octets[static_cast<std::size_t>(offsets)], 0x0E);  // a summary offset
    EXPECT_EQ(crc,
              crc32_of(Bytes{file.octets}.subspan(static_cast<std::size_t>(start),
                                                  footer + 16 - static_cast<std::size_t>(start))));
}

TEST(Mcap, SeekGoesOnWithTheFirstMessageAtThatTimeOrAfterIt) {
    FileInMemory file = a_file(3);
    Reader reader{file};
    for (const auto& [to, first] : {std::pair{0, 0}, {15, 14}, {11, 10}, {30, 29}, {2, 1}}) {
        reader.seek(second * static_cast<Timestamp>(to));
        EXPECT_EQ(as_text(reader.next()->data), std::to_string(first)) << to;
    }
    reader.seek(15 * second + 1);
    EXPECT_EQ(as_text(reader.next()->data), "15");
    reader.seek(31 * second);
    EXPECT_FALSE(reader.next());
}

TEST(Mcap, AFileThatWasCutAnywhereGivesAllMessagesOfItsWholeChunks) {
    const FileInMemory whole = a_file(3, false);
    std::vector<std::size_t> chunk_ends;
    FileInMemory copy = whole;
    FileWalk walk{copy};
    while (const auto place = walk.next()) {
        if (place->opcode == Opcode::chunk) chunk_ends.push_back(place->end());
    }
    ASSERT_THAT(chunk_ends, SizeIs(3));
    for (std::size_t size = 0; size < whole.octets.size(); ++size) {
        FileInMemory cut;
        cut.octets.assign(whole.octets.begin(),
                          whole.octets.begin() + static_cast<std::ptrdiff_t>(size));
        Reader reader{cut};
        EXPECT_EQ(reader.is_mcap(), size >= magic.size());
        if (!reader.is_mcap()) continue;
        EXPECT_FALSE(reader.is_finished());
        const auto chunks =
            std::ranges::count_if(chunk_ends, [size](std::size_t end) { return end <= size; });
        EXPECT_THAT(texts_in(reader), SizeIs(static_cast<std::size_t>(10 * chunks))) << size;
        EXPECT_LE(reader.left_out().octets_cut, size);
    }
}

TEST(Mcap, ZerosThatAPowerFailureLeavesAtTheEndAreACut) {
    FileInMemory file = a_file(2, false);
    file.octets.resize(file.octets.size() + 4096);
    Reader reader{file};
    EXPECT_THAT(texts_in(reader), SizeIs(20));
    EXPECT_EQ(reader.left_out().octets_cut, 4096U);
}

TEST(Mcap, AnySpoiltOctetIsNoHarmAndADamagedChunkIsCounted) {
    const FileInMemory whole = a_file(3);
    std::mt19937 random{1};
    bool was_damaged = false;
    for (int round = 0; round < 3000; ++round) {
        FileInMemory spoilt = whole;
        for (int i = 0; i < 1 + round % 4; ++i) {
            spoilt.octets[8 + random() % (spoilt.octets.size() - 8)] =
                static_cast<std::uint8_t>(random());
        }
        Reader reader{spoilt};
        EXPECT_LE(texts_in(reader).size(), 30U);
        reader.seek(reader.end());
        (void)texts_in(reader);
        was_damaged = was_damaged || reader.left_out().chunks_damaged > 0;
    }
    EXPECT_TRUE(was_damaged);
}

TEST(Mcap, AChunkThatClaimsToBeHugeIsLeftOut) {
    FileInMemory file;
    file.append(magic);
    write_chunk(file.octets,
                {.start = 1, .end = 2, .uncompressed_octets = 1ULL << 40U, .compression = "zstd"},
                {});
    Reader reader{file};
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.left_out().chunks_too_large, 1U);
}

TEST(Mcap, ACompressionThatCannotBeReadIsNamed) {
    FileInMemory file;
    file.append(magic);
    write_chunk(file.octets, {.start = 1, .end = 2, .uncompressed_octets = 1, .compression = "lz4"},
                {});
    Reader reader{file};
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.left_out().chunks_compressed, 1U);
    EXPECT_THAT(reader.left_out().compressions, ElementsAre("lz4"));
}

TEST(Mcap, AChunkOfAnotherWriterHoldsItsChannelsAndIsSortedByTime) {
    Octets records;
    write_channel(records, {.id = 7, .topic = "others", .message_encoding = "cdr"});
    for (const Timestamp time : {9, 3}) {
        const std::string text = std::to_string(time);
        write_message(records, {.channel_id = 7, .log_time = time, .data = as_octets(text)});
    }
    write_message(records, {.channel_id = 8, .log_time = 4});  // of no channel
    FileInMemory file;
    file.append(magic);
    write_chunk(file.octets, {.start = 3, .end = 9, .uncompressed_octets = records.size()},
                records);
    Reader reader{file};
    EXPECT_THAT(texts_in(reader), ElementsAre("3", "9"));
    EXPECT_EQ(reader.left_out().messages_unknown, 1U);
}

TEST(Mcap, FurtherTopicsThanTheMostAreRefusedAndKnownOnesGoOn) {
    ChunkWriter writer = a_writer();
    for (std::size_t i = 0; i < ChunkWriter::most_channels; ++i) {
        ASSERT_TRUE(writer.add(1, std::to_string(i), "name", {}));
        if (i % 1000 == 0) (void)writer.take_chunk();
    }
    EXPECT_FALSE(writer.add(1, "one more", "name", {}));
    EXPECT_TRUE(writer.add(1, "7", "name", {}));
    EXPECT_FALSE(writer.add(1, "7", "short", {}));  // another one of the same name
}

TEST(Mcap, ASummaryThatCannotBeAppendedSaysSo) {
    FileInMemory file = a_file(1, false);
    EXPECT_FALSE(append_summary(file, [](Bytes) { return false; }));
}

}  // namespace
}  // namespace romano::experiments::mcap
