// SPDX-License-Identifier: BSD-3-Clause
// Reads a recording with the public library of JavaScript, as viewers in browsers do.
// node read_mcap.cjs FILE [SECONDS]: prints what its index gives, and what a stream gives, as JSON.
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { decompress } = require("fzstd");
const { open } = require("fs/promises");

const decompressHandlers = {
  zstd: (data, size) => decompress(data, new Uint8Array(Number(size))),
};

async function byIndex(file, size, seconds) {
  const readable = {
    size: async () => BigInt(size),
    read: async (offset, length) => {
      const buffer = new Uint8Array(Number(length));
      await file.read(buffer, 0, Number(length), Number(offset));
      return buffer;
    },
  };
  const began = performance.now();
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const opened = performance.now() - began;
  const { messageStartTime, messageEndTime, messageCount } = reader.statistics;
  const from = (part) => messageStartTime + ((messageEndTime - messageStartTime) * part) / 100n;
  const seeks = [];
  let messages = 0;
  for (const part of [75n, 25n, 90n, 10n, 50n]) {
    const start = performance.now();
    const startTime = from(part);
    for await (const _ of reader.readMessages({ startTime, endTime: startTime + BigInt(seconds * 1e9) })) messages++;
    seeks.push(performance.now() - start);
  }
  const memory = process.memoryUsage().rss / 1e6;
  let all = 0;
  if (messageCount < 1000000n) for await (const _ of reader.readMessages()) all++;
  const chunks = reader.chunkIndexes.length;
  return { chunks, channels: reader.channelsById.size, count: Number(messageCount), all, messages, opened, seeks, memory };
}

async function byStream(file) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  const buffer = new Uint8Array(1 << 20);
  const sequences = [];
  for (;;) {
    const { bytesRead } = await file.read(buffer, 0, buffer.length);
    if (!bytesRead) return { sequences, done: reader.done() };
    reader.append(buffer.slice(0, bytesRead));
    for (let record; (record = reader.nextRecord()); ) if (record.type === "Message") sequences.push(record.sequence);
  }
}

(async () => {
  const file = await open(process.argv[2], "r");
  const { size } = await file.stat();
  const seconds = Number(process.argv[3] ?? 1);
  const found = {};
  try {
    found.index = await byIndex(file, size, seconds);
  } catch (error) {
    found.refusal = error.message;
  }
  if (size < 1e8) found.stream = await byStream(file);
  console.log(JSON.stringify(found));
})();
