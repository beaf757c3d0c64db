// Reads a recording with @mcap/core, which others wrote: `node read_mcap.mjs [--from-start] FILE`. Prints a JSON object a line for
// each message, by the file's index and checked against its statistics; with --from-start as the file stands, without its end. What
// is not so ends it with exit code 1 and a sentence.

import {createRequire} from 'node:module';
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';

const require = createRequire(process.env.MCAP_TEST_MODULES + '/');
const {McapIndexedReader, McapStreamReader} = require('@mcap/core');
const {decompress} = require('fzstd');

const fromStart = process.argv[2] === '--from-start';
const octets = new Uint8Array(readFileSync(process.argv.at(-1)));
const decompressHandlers = {zstd: (records, size) => decompress(records, new Uint8Array(Number(size)))};
const text = (data) => new TextDecoder('utf-8', {fatal: true}).decode(data);

function print(channel, schema, message) {
    assert.equal(schema.name, 'romano.Published');
    assert.equal(schema.encoding, 'jsonschema');
    const properties = JSON.parse(text(schema.data)).properties;
    assert.equal(channel.messageEncoding, 'json');
    const content = JSON.parse(text(message.data));
    for (const key of Object.keys(content)) assert.ok(key in properties, `the schema has ${key}`);
    assert.equal(message.logTime, message.publishTime);
    process.stdout.write(JSON.stringify({
        topic: channel.topic, kind: channel.metadata.get('topic_type'), sequence: message.sequence,
        time_ms: Number(message.logTime / 1000000n), ...content,
    }) + '\n');
}

if (fromStart) {
    const reader = new McapStreamReader({decompressHandlers, validateCrcs: true});
    reader.append(octets);
    const channels = new Map();
    const schemas = new Map();
    for (let record; (record = reader.nextRecord());) {
        if (record.type === 'Schema') schemas.set(record.id, record);
        if (record.type === 'Channel') channels.set(record.id, record);
        if (record.type !== 'Message') continue;
        const channel = channels.get(record.channelId);
        print(channel, schemas.get(channel.schemaId), record);
    }
} else {
    const readable = {
        size: async () => BigInt(octets.length),
        read: async (offset, length) => octets.slice(Number(offset), Number(offset + length)),
    };
    const reader = await McapIndexedReader.Initialize({readable, decompressHandlers});
    let count = 0n;
    for await (const message of reader.readMessages({validateCrcs: true})) {
        const channel = reader.channelsById.get(message.channelId);
        print(channel, reader.schemasById.get(channel.schemaId), message);
        ++count;
    }
    const {statistics} = reader;
    assert.equal(statistics.messageCount, count);
    assert.equal(statistics.channelCount, reader.channelsById.size);
    assert.equal(statistics.chunkCount, reader.chunkIndexes.length);
    let sum = 0n;
    for (const one of statistics.channelMessageCounts.values()) sum += one;
    assert.equal(sum, count);
}
