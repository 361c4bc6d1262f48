// Reads recordings as Foxglove does, with none of this project's code: node read_recordings.mjs FILE…
//
// Every message of every topic is decoded by the schema in the file. One line a file; exit status 1 with a sentence
// where one is not as it should be.

import { open } from "node:fs/promises";
import { gunzipSync } from "node:zlib";

import { McapIndexedReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";
import { loadDecompressHandlers } from "@mcap/support";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";

const CONFIG = "config.yaml.gz";
const METADATA = "asddpg";

function check(holds, sentence) {
  if (!holds) {
    throw new Error(sentence);
  }
}

// Decoders ------------------------------------------------------------------------------------------------------------

function decoderOf(channel, schema) {
  check(schema != undefined, `${channel.topic} has no schema`);
  if (channel.messageEncoding === "protobuf" && schema.encoding === "protobuf") {
    return protobufDecoder(schema);
  }
  check(
    channel.messageEncoding === "json" && schema.encoding === "jsonschema",
    `${channel.topic} is in ${channel.messageEncoding} by a schema in ${schema.encoding}`,
  );
  return jsonDecoder(channel.topic, JSON.parse(new TextDecoder().decode(schema.data)));
}

function protobufDecoder(schema) {
  const type = protobuf.Root.fromDescriptor(descriptor.FileDescriptorSet.decode(schema.data)).lookupType(schema.name);
  return (data) => {
    const message = type.decode(data);
    const sentence = type.verify(message);
    check(sentence == undefined, `a ${schema.name} is none: ${sentence}`);
    return type.toObject(message, { longs: Number, defaults: true });
  };
}

function jsonDecoder(topic, schema) {
  check(schema.type === "object", `the schema of ${topic} is of no object`);
  checkViewable(schema, topic);
  const decoder = new TextDecoder("utf-8", { fatal: true });
  return (data) => {
    const message = JSON.parse(decoder.decode(data));
    checkJson(message, schema, topic);
    return message;
  };
}

// Foxglove's viewer reads schemas with one type to a field and properties to each object, or drops the topic.
function checkViewable(schema, path) {
  check(typeof schema.type === "string", `${path} is of the types ${schema.type}, of which a viewer takes one`);
  check(schema.type !== "object" || schema.properties != undefined, `${path} has no properties, which a viewer needs`);
  for (const [name, own] of Object.entries(schema.properties ?? {})) {
    checkViewable(own, `${path}.${name}`);
  }
}

// The part of JSON Schema that recordings use: type, properties, additionalProperties.
function checkJson(value, schema, path) {
  check(schema.type === typeOf(value), `${path} is of type ${typeOf(value)}, not ${schema.type}`);
  if (typeOf(value) !== "object") {
    return;
  }
  for (const [name, item] of Object.entries(value)) {
    const own = schema.properties?.[name] ?? schema.additionalProperties;
    check(own != undefined, `${path} has ${name}, of which its schema knows nothing`);
    checkJson(item, own, `${path}.${name}`);
  }
}

function typeOf(value) {
  return value === null ? "null" : Array.isArray(value) ? "array" : typeof value;
}

// A file --------------------------------------------------------------------------------------------------------------

async function readFile(path) {
  const handle = await open(path, "r");
  try {
    const decompressHandlers = await loadDecompressHandlers();
    const reader = await McapIndexedReader.Initialize({ readable: new FileHandleReadable(handle), decompressHandlers });
    const messages = await messagesByTopic(reader);
    checkCounts(reader, messages);
    checkEpisode(messages);
    await checkProvenance(reader);
    return messages;
  } finally {
    await handle.close();
  }
}

async function messagesByTopic(reader) {
  const decoders = new Map();
  const found = new Map();
  for (const channel of reader.channelsById.values()) {
    decoders.set(channel.id, decoderOf(channel, reader.schemasById.get(channel.schemaId)));
    check(!found.has(channel.topic), `${channel.topic} has two channels`);
    found.set(channel.topic, []);
  }
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic } = reader.channelsById.get(message.channelId);
    try {
      found.get(topic).push({ time: message.logTime, content: decoders.get(message.channelId)(message.data) });
    } catch (error) {
      throw new Error(`${topic} at ${message.logTime} ns: ${error.message}`);
    }
  }
  return found;
}

function checkCounts(reader, messages) {
  const { statistics } = reader;
  check(statistics != undefined, "it has no statistics");
  let total = 0n;
  for (const channel of reader.channelsById.values()) {
    const count = BigInt(messages.get(channel.topic).length);
    const told = statistics.channelMessageCounts.get(channel.id) ?? 0n;
    check(told === count, `the statistics count ${told} messages of ${channel.topic}; there are ${count}`);
    total += count;
  }
  check(statistics.messageCount === total, `the statistics count ${statistics.messageCount} messages, not ${total}`);
  check(statistics.channelCount === reader.channelsById.size, "the statistics count other channels");
}

function checkEpisode(messages) {
  for (const [topic, own] of messages) {
    check(own.length > 0, `${topic} has no message`);
    for (let index = 1; index < own.length; index++) {
      check(own[index - 1].time <= own[index].time, `${topic} goes back in time at message ${index}`);
    }
  }
  const outcome = outcomeOf(messages);
  check(outcome.outcome !== "running", "the episode has no end");
  const steps = countOf(messages, "/step");
  check(steps === outcome.steps, `${steps} messages of /step, and /outcome tells of ${outcome.steps}`);
  check(countOf(messages, "/cmd_vel") === steps, "/cmd_vel has not one message a step");
  for (const topic of ["/tf", "/scan", "/odom"]) {
    const count = countOf(messages, topic);
    const holds = topic === "/tf" ? count > steps : count === steps + 1; // with latency also at the scan's instant
    check(holds, `${topic} has ${count} messages; ${steps} steps need ${steps + 1}`);
  }
  check(messages.get("/step").every((step, index) => step.content.step === index), "the steps do not count from 0");
}

function countOf(messages, topic) {
  return messages.get(topic)?.length ?? 0;
}

function outcomeOf(messages) {
  check(countOf(messages, "/outcome") > 0, "there is no /outcome");
  return messages.get("/outcome").at(-1).content;
}

async function checkProvenance(reader) {
  const metadata = [];
  for await (const record of reader.readMetadata({ name: METADATA })) {
    metadata.push(record);
  }
  check(metadata.length === 1, `there are ${metadata.length} metadata records ${METADATA}`);
  check(metadata[0].metadata.get("task")?.startsWith("nav_"), `the metadata ${METADATA} name no task`);
  const attached = [];
  for await (const attachment of reader.readAttachments({ name: CONFIG, validateCrcs: true })) {
    attached.push(attachment);
  }
  check(attached.length === 1, `there are ${attached.length} attachments ${CONFIG}`);
  const config = gunzipSync(attached[0].data).toString("utf-8");
  check(config.startsWith("task:") && config.includes("provenance:"), `${CONFIG} holds no configuration`);
}

// All files -----------------------------------------------------------------------------------------------------------

const paths = process.argv.slice(2);
if (paths.length === 0) {
  console.error("error: read which recordings? node read_recordings.mjs FILE…");
  process.exit(2);
}
for (const path of paths) {
  try {
    const messages = await readFile(path);
    const count = [...messages.values()].reduce((sum, own) => sum + own.length, 0);
    const { outcome, steps } = outcomeOf(messages);
    console.log(`${path}: ${outcome} after ${steps} steps, ${count} messages of ${messages.size} topics, all decoded`);
  } catch (error) {
    console.error(`error: ${path}: ${error.message}`);
    process.exitCode = 1;
  }
}
