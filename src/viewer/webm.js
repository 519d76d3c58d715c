// A video file of encoded pictures: WebM with one track, which is a part of Matroska (RFC 9559) in EBML (RFC 8794).

const join = (parts) => {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
};

/// Eight bytes, so that lengths are independent of what they say.
function number(value, kind = "setBigUint64") {
  const bytes = new DataView(new ArrayBuffer(8));
  bytes[kind](0, kind === "setBigUint64" ? BigInt(Math.round(value)) : value);
  return new Uint8Array(bytes.buffer);
}

const text = (value) => new TextEncoder().encode(value);

/// An element: its id in hexadecimal, the length with the mark of eight bytes, the content.
function element(id, ...content) {
  const data = join(content), length = number(data.length);
  length[0] = 1;
  return join([Uint8Array.from(id.match(/../g), (byte) => parseInt(byte, 16)), length, data]);
}

/// Times relative to that of their cluster [ms] are two bytes.
function block(data, time, isKey) {
  return element("a3", Uint8Array.of(0x81, (time >> 8) & 255, time & 255, isKey ? 0x80 : 0), data);
}

/// `pictures`: time [ms], isKey, data of each, the first of them a key; `codec`: "V_VP9" or "V_VP8"; `length`: [ms].
export function webm(pictures, { codec, width, height, length }) {
  const head = element("1a45dfa3", element("4286", number(1)), element("42f7", number(1)), element("42f2", number(4)), element("42f3", number(8)),
    element("4282", text("webm")), element("4287", number(4)), element("4285", number(2)));
  const info = element("1549a966", element("2ad7b1", number(1e6)), element("4489", number(length, "setFloat64")),
    element("4d80", text("Pliant")), element("5741", text("Pliant")));
  const tracks = element("1654ae6b", element("ae", element("d7", number(1)), element("73c5", number(1)), element("83", number(1)), element("9c", number(0)),
    element("86", text(codec)), element("e0", element("b0", number(width)), element("ba", number(height)))));
  const groups = [];  // from key to key
  for (const picture of pictures) {
    if (picture.isKey) groups.push([]);
    groups.at(-1).push(picture);
  }
  const clusters = groups.map((group) => element("1f43b675", element("e7", number(group[0].time)),
    ...group.map(({ time, isKey, data }) => block(data, time - group[0].time, isKey))));
  const cues = (places) => element("1c53bb6b", ...groups.map((group, i) => element("bb", element("b3", number(group[0].time)),
    element("b7", element("f7", number(1)), element("f1", number(places[i]))))));
  let place = info.length + tracks.length + cues(groups.map(() => 0)).length;
  const places = clusters.map((cluster) => (place += cluster.length) - cluster.length);
  return new Blob([head, element("18538067", info, tracks, cues(places), ...clusters)], { type: "video/webm" });
}
