// Subscribes to everything a Foxglove server offers and prints each message, decoded, as one JSON line. node client.cjs ADDRESS
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const WebSocket = require("ws");

const client = new FoxgloveClient({ ws: new WebSocket(process.argv[2], ["foxglove.sdk.v1", FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const readers = new Map();
const say = (content) => console.log(JSON.stringify(content, (_, value) => {
  if (typeof value === "bigint") return Number(value);
  return ArrayBuffer.isView(value) ? Array.from(value) : value;
}));

client.on("error", (error) => say({ error: String(error) }));
client.on("serverInfo", (info) => say({ name: info.name, capabilities: info.capabilities }));
client.on("advertise", (channels) => {
  for (const { id, topic, encoding, schema, schemaEncoding } of channels) {
    readers.set(client.subscribe(id), { topic, reader: new MessageReader(parse(schema, { ros2: true })) });
    say({ advertised: topic, encoding, schemaEncoding });
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const { topic, reader } = readers.get(subscriptionId);
  say({ topic, time_ns: timestamp, message: reader.readMessage(data) });
});
