// The handles of the finger's view: the touch is dragged, turned and widened, the sensors are sunk and spread.
import { handle } from "./handles.js";
import { clip, degrees, plain } from "./numbers.js";

const STEEPEST = 1.35;
const APART = 30; // pixels between two handles, so that a finger tip finds each

export function fingerHandles(view) {
  const { section, above } = view;
  const touch = () => view.store.state.touch ?? view.said.state.touch; // a finger that was just taken has none yet
  let from = null; // what was when a hand came
  const start = () => {
    view.held = true;
    from = { touch: structuredClone(touch()), state: structuredClone(view.store.kept ?? view.store.state), said: view.said, scale: { ...section.scale }, above: view.said.area ? { ...above.scale } : null };
  };
  const move = (change) => {
    from.moved = true;
    view.look({ touch: { ...touch(), ...change } }, { moving: true }, false);
  };
  const end = () => {
    view.held = false;
    view.look({}, {}, true);
  };
  const step = (change) => view.look({ touch: { ...touch(), ...change } }, {}, true);
  const along = (at) => clip(at, view.said.window.left, view.said.window.right);
  const across = (at) => clip(at, view.said.window.front, view.said.window.back);

  const position = handle(section.sheet.box, "position", "Position of the touch", {
    start,
    by: (dx) => move({ position: [along(from.touch.position[0] + dx / from.scale.k), ...from.touch.position.slice(1)] }),
    key: (right, up, coarse) => {
      if (right) step({ position: [along(touch().position[0] + right * coarse * 1e-4), ...touch().position.slice(1)] });
      else step({ force: touch().force * 1.05 ** (up * coarse) });
    },
    end,
  });

  const leaning = (lean, force) => {
    if (touch().position.length === 1) return { angle: clip(lean, -STEEPEST, STEEPEST), force };
    const sideways = Math.tan(touch().angle) * Math.sin(touch().azimuth);
    const forwards = Math.tan(clip(lean, -STEEPEST, STEEPEST));
    return { angle: clip(Math.atan(Math.hypot(forwards, sideways)), 0, STEEPEST), azimuth: Math.atan2(sideways, forwards), force };
  };
  const force = handle(section.sheet.box, "force", "Angle and force of the touch", {
    start: () => {
      start();
      from.tail = tail();
    },
    by: (dx, dy) => {
      const { px, py } = section.scale;
      const [x, y] = [from.tail[0] + dx - px(touch().position[0]), py(0) - from.tail[1] - dy];
      move(leaning(Math.atan2(-x, Math.max(y, 4)), section.force(Math.hypot(x, Math.max(y, 4)))));
    },
    key: (right, up, coarse) => {
      if (right) step(leaning(section.lean() - (right * coarse) / degrees, touch().force));
      else step({ force: touch().force * 1.05 ** (up * coarse) });
    },
    end,
  }, "small");

  const tail = () => {
    const { px, py } = section.scale;
    const [lean, length] = [section.lean(), section.length(touch().force)];
    return [px(touch().position[0]) - length * Math.sin(lean), py(0) - length * Math.cos(lean)];
  };

  const width = handle(section.sheet.box, "width", "Half width of the touch", {
    start,
    by: (dx) => move({ half_width: clip(from.touch.half_width + dx / from.scale.k, 2e-5, 0.2) }),
    key: (right, up, coarse) => step({ half_width: clip(touch().half_width * 1.05 ** ((right || up) * coarse), 2e-5, 0.2) }),
    end,
  }, "small");

  // Sensors: sideways the pitch, downwards the depth.
  const entry = (key) => view.finger.latest?.find((one) => one.key === key);
  const sensors = handle(section.sheet.box, "sensors", "Depth and pitch of the sensors", {
    start: () => {
      start();
      from.numbers = { depth: entry("sensors.depth")?.value, pitch: entry("sensors.pitch")?.value };
    },
    by: (dx, dy) => {
      const count = new Set(from.said.sensors.y.map((y) => y.toFixed(7))).size;
      const spread = (0.5 * Math.max(count - 1, 1)) || 1;
      const { k } = from.scale;
      from.edits = [];
      const most = 0.98 * (from.said.skin.base ?? Infinity);
      if (from.numbers.depth) from.edits.push(["sensors.depth", clip(from.numbers.depth + dy / k, 2e-4, most)]);
      if (from.numbers.pitch) from.edits.push(["sensors.pitch", Math.max(from.numbers.pitch + dx / k / spread, 1e-4)]);
      view.look({ text: from.state.text }, { edits: from.edits, moving: true, window: Object.values(from.said.window) }, false);
    },
    key: (right, up, coarse) => {
      const key = right ? "sensors.pitch" : "sensors.depth";
      const one = entry(key);
      if (one) view.look({}, { edits: [[key, Math.max(one.value + (right || -up) * coarse * 5e-5, 1e-4)]] }, true, key);
    },
    end: () => {
      view.held = false;
      view.look({ text: from.state.text }, { edits: from.edits ?? [] }, true);
    },
  }, "sensor");

  const place2 = handle(above.sheet.box, "above", "Position of the touch, from above", {
    start,
    by: (dx, dy) => move({ position: [along(from.touch.position[0] + dx / from.above.k), across(from.touch.position[1] - dy / from.above.k)] }),
    key: (right, up, coarse) => step({ position: [along(touch().position[0] + right * coarse * 1e-4), across(touch().position[1] + up * coarse * 1e-4)] }),
    end,
  });

  const turn = handle(above.sheet.box, "turn", "Drag of the touch, from above", {
    start: () => {
      start();
      from.tip = tip();
    },
    by: (dx, dy) => {
      const { px, py } = above.scale;
      const x = from.tip[0] + dx - px(touch().position[0]);
      const y = py(touch().position[1]) - from.tip[1] - dy;
      const sine = clip(Math.hypot(x, y) / (0.2 * above.scale.high), 0.02, Math.sin(STEEPEST));
      move({ azimuth: Math.atan2(y, x), angle: Math.asin(sine) });
    },
    key: (right, up, coarse) => step(right ? { azimuth: wrapped(touch().azimuth - (right * coarse * 2) / degrees) } : { angle: clip(Math.abs(touch().angle) + (up * coarse) / degrees, 0, STEEPEST) }),
    end,
  }, "small");

  const tip = () => {
    const { px, py, high } = above.scale;
    const long = 0.2 * high * Math.sin(touch().angle);
    return [px(touch().position[0]) + long * Math.cos(touch().azimuth), py(touch().position[1]) - long * Math.sin(touch().azimuth)];
  };

  const place = () => {
    const { said } = view;
    if (!said || !section.sheet.width) return;
    const { px, py } = section.scale;
    const now = said.state.touch;
    const where = now.position.map((v, i) => `${"yz"[i]} ${plain(1e3 * v)} mm`).join(", ");
    position.place(px(now.position[0]), py(0), 1e3 * now.position[0], where);
    force.place(...tail(), degrees * now.angle, `${plain(degrees * now.angle)} degrees, ${plain(now.force)} ${said.units.force}`);
    if (said.wide) width.place(px(now.position[0]) + Math.max(APART, section.scale.k * now.half_width), py(0), 1e3 * now.half_width, `${plain(1e3 * now.half_width)} mm`);
    else width.hide();
    const last = said.sensors.y.reduce((best, y, i, all) => (y > all[best] ? i : best), 0);
    const [depth, pitch] = [entry("sensors.depth"), entry("sensors.pitch")];
    if (depth || pitch) sensors.place(px(said.sensors.y[last]), py(said.sensors.depth[last]), 1e3 * said.sensors.depth[last],
      [depth && `depth ${plain(1e3 * depth.value)} mm`, pitch && `pitch ${plain(1e3 * pitch.value)} mm`].filter(Boolean).join(", "));
    else sensors.hide();
    if (!said.area || !above.sheet.width) return;
    place2.place(above.scale.px(now.position[0]), above.scale.py(now.position[1]), 1e3 * now.position[0], where);
    turn.place(...tip(), degrees * now.azimuth, `azimuth ${plain(degrees * now.azimuth)} degrees, angle ${plain(degrees * now.angle)} degrees`);
  };
  view.place = () => requestAnimationFrame(place);
  for (const one of [section, above]) new ResizeObserver(() => view.place()).observe(one.sheet.box);
}

const wrapped = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
